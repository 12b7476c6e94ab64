import assert from "node:assert/strict";
import { test } from "node:test";

import { carries } from "./photos.js";

const PHOTO = Buffer.from(Array.from({ length: 3000 }, (_, i) => (i * i * 31 + 17 * i) % 251));
const request = (parts) => ({ url: "/", headers: {}, body: Buffer.alloc(0), ...parts });

const part = PHOTO.subarray(700, 1300);
for (const [how, parts] of Object.entries({
  "a body": { body: Buffer.concat([Buffer.from("--x\r\n"), part]) },
  "base64 in a body": { body: Buffer.from(`{"a": "${part.toString("base64")}"}`) },
  "base64 of all, a byte later": { body: Buffer.from(Buffer.concat([Buffer.from("?"), PHOTO]).toString("base64")) },
  "base64 in an address": { url: `/a?b=${encodeURIComponent(part.toString("base64"))}` },
  "base64 for addresses": { url: `/a?b=${part.toString("base64url")}` },
  "hexadecimal in an address": { url: `/${part.toString("hex").toUpperCase()}` },
  "a header": { headers: { "x-a": part.toString("base64") } },
  "percent-encoded bytes": { url: `/a?b=${[...part].map((byte) => `%${byte.toString(16).padStart(2, "0").toUpperCase()}`).join("")}` },
  "percent-encoded letters": { url: `/a?b=${encodeURIComponent(part.toString("latin1"))}` },
})) {
  test(`a photo is found in ${how}`, () => {
    assert.ok(carries([request({}), request(parts)], PHOTO));
  });
}

test("another photo, or none, is not found", () => {
  const other = Buffer.from(PHOTO.map((byte) => 255 - byte));
  assert.ok(!carries([request({ body: other, url: `/${other.toString("base64url")}` })], PHOTO));
});
