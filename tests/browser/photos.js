/** What the tests of photos share: photos of people who are no people, and a listener to all traffic. */

import http from "node:http";

/** The body that stands in the composed photos: another one than the form's woman. */
export const PERSON = {
  body: "female",
  measurements: { stature: 168, bust_girth: 92, waist_girth: 80, hip_girth: 100 },
};

/**
 * A rendered body before a wall with a picture and a cupboard on a wooden floor, in uneven light
 * and with a camera's noise: a JPEG file, or one of another `type`.
 *
 * @param {object} how `side`, `size` ([width, height]) and how much of the height the body's
 *   picture takes (`share`), how far down it stands (`drop`, a share too)
 */
export async function composed(page, request, how = {}) {
  const { side = "front", size = [600, 900], share = 0.94, drop = 0.03, type = "image/jpeg" } = how;
  const picture = async (silhouette) => {
    const answer = await request.post(`/api/v1/avatars/${side}.png`, {
      data: { ...PERSON, silhouette },
    });
    return (await answer.body()).toString("base64");
  };
  const pictures = [await picture(false), await picture(true)];
  const base64 = await page.evaluate(
    async ([[body, outline], [width, height], share, drop, type]) => {
      const opened = async (text) => {
        const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
        return createImageBitmap(new Blob([bytes], { type: "image/png" }));
      };
      const drawing = (across, down) => new OffscreenCanvas(across, down).getContext("2d");
      const person = await opened(body);
      const cut = drawing(person.width, person.height);
      cut.drawImage(await opened(outline), 0, 0);
      const mask = cut.getImageData(0, 0, person.width, person.height);
      for (let i = 0; i < mask.data.length; i += 4) mask.data[i + 3] = mask.data[i];
      cut.putImageData(mask, 0, 0);
      cut.globalCompositeOperation = "source-in";
      cut.drawImage(person, 0, 0);

      const photo = drawing(width, height);
      const wall = photo.createLinearGradient(0, 0, width, 0);
      wall.addColorStop(0, "#a7a096");
      wall.addColorStop(1, "#d8d1c6");
      photo.fillStyle = wall;
      photo.fillRect(0, 0, width, height);
      const parts = [["#78604c", 0, 0.84, 1, 0.16], ["#5a6e82", 0.06, 0.1, 0.2, 0.22], ["#4a4238", 0.86, 0.5, 0.14, 0.38]];
      for (const [colour, x, y, across, down] of parts) {
        photo.fillStyle = colour;
        photo.fillRect(x * width, y * height, across * width, down * height);
      }
      const tall = share * height;
      const broad = (tall * person.width) / person.height;
      photo.drawImage(cut.canvas, (width - broad) / 2, drop * height, broad, tall);
      const all = photo.getImageData(0, 0, width, height);
      let seed = 1;
      for (let i = 0; i < all.data.length; i += 1) {
        seed = (seed * 48271) % 2147483647;
        if (i % 4 < 3) all.data[i] += (seed % 13) - 6;
      }
      photo.putImageData(all, 0, 0);
      const blob = await photo.canvas.convertToBlob({ type, quality: 0.9 });
      let text = "";
      for (const byte of new Uint8Array(await blob.arrayBuffer())) text += String.fromCharCode(byte);
      return btoa(text);
    },
    [pictures, size, share, drop, type],
  );
  return Buffer.from(base64, "base64");
}

/** The JPEG file as a camera on its side writes it: to be turned a quarter to the right (EXIF 6). */
export function lyingOnItsSide(jpeg) {
  const tiff = Buffer.alloc(26);
  tiff.write("II*\0", 0, "latin1");
  tiff.writeUInt32LE(8, 4); // the first directory, of one entry:
  tiff.writeUInt16LE(1, 8);
  tiff.writeUInt16LE(0x0112, 10); // orientation,
  tiff.writeUInt16LE(3, 12); // a short,
  tiff.writeUInt32LE(1, 14); // one of them:
  tiff.writeUInt16LE(6, 18);
  const content = Buffer.concat([Buffer.from("Exif\0\0", "latin1"), tiff]);
  const length = Buffer.alloc(2);
  length.writeUInt16BE(content.length + 2);
  return Buffer.concat([jpeg.subarray(0, 2), Buffer.from([0xff, 0xe1]), length, content, jpeg.subarray(2)]);
}

/**
 * A server before the site that hands everything through and keeps what the browser sent: also
 * what workers send, and the bytes of files, neither of which a browser's own tools tell for sure.
 *
 * What is asked for at an address that `refused` matches is not answered; `policy` says whether
 * answers keep the site's Content-Security-Policy.
 */
export async function listen(site) {
  const { hostname, port } = new URL(site);
  const heard = [];
  const ways = { heard, refused: null, policy: true };
  const server = http.createServer((request, response) => {
    if (ways.refused?.test(request.url)) {
      request.socket.destroy();
      return;
    }
    const pieces = [];
    request.on("data", (piece) => pieces.push(piece));
    request.on("end", () => {
      const { method, url, headers } = request;
      const body = Buffer.concat(pieces);
      heard.push({ method, url, headers, body });
      const onwards = http.request({ hostname, port, method, path: url, headers }, (answer) => {
        if (!ways.policy) delete answer.headers["content-security-policy"];
        response.writeHead(answer.statusCode, answer.headers);
        answer.pipe(response);
      });
      onwards.end(body);
    });
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return Object.assign(ways, {
    url: `http://127.0.0.1:${server.address().port}`,
    close: () => new Promise((resolve) => server.close(resolve).closeAllConnections()),
  });
}

/** A server of somebody else's, which welcomes every page and keeps what it is asked for. */
export async function elsewhere() {
  const heard = [];
  const server = http.createServer(({ url }, response) => {
    heard.push(url);
    response.writeHead(204, {
      "access-control-allow-origin": "*",
      "cross-origin-resource-policy": "cross-origin",
    });
    response.end();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    heard,
    close: () => new Promise((resolve) => server.close(resolve).closeAllConnections()),
  };
}

/** Bytes that are looked for in what was sent, and how far apart in the photo they begin. */
const [SLICE, APART] = [48, 240];

/**
 * Whether requests carry a part of a photo: in an address, a header or a body; as it is, or as
 * base64, in hexadecimal or percent-encoded.
 *
 * @param {Buffer} photo
 * @param {{url: string, headers: object, body: Buffer}[]} requests
 */
export function carries(requests, photo) {
  const sent = requests.map(
    ({ url, headers, body }) => `${url}\n${JSON.stringify(headers)}\n${body.toString("latin1")}`,
  );
  const everything = sent.join("\n");
  // Letters of base64 that addresses and forms cannot hold are written otherwise there.
  const plain = everything
    .replace(/%2b/gi, "+")
    .replace(/%2f/gi, "/")
    .replaceAll("-", "+")
    .replaceAll("_", "/");
  const lower = everything.toLowerCase();
  for (let at = 0; at + SLICE + 3 <= photo.length; at += APART) {
    const slice = photo.subarray(at, at + SLICE);
    const letters = slice.toString("latin1");
    if (everything.includes(letters) || everything.includes(slice.toString())) return true;
    if (lower.includes(slice.toString("hex"))) return true;
    const escaped = [...slice].map((byte) => `%${byte.toString(16).padStart(2, "0")}`).join("");
    if (lower.includes(escaped)) return true;
    if (lower.includes(encodeURIComponent(letters).toLowerCase())) return true;
    // Three bytes are four letters: a photo may begin at any of the three.
    for (const shift of [0, 1, 2]) {
      const base64 = photo.subarray(at + shift, at + shift + SLICE).toString("base64");
      if (plain.includes(base64)) return true;
    }
  }
  return false;
}

/** The parts of a multipart body: `{name, type, content}` each. */
export function partsOf({ headers, body }) {
  const boundary = `--${headers["content-type"].match(/boundary=(.+)$/)[1]}`;
  const parts = [];
  let at = body.indexOf(boundary);
  while (at >= 0) {
    const start = at + boundary.length + 2;
    const end = body.indexOf(boundary, start);
    if (end < 0) break;
    const gap = body.indexOf("\r\n\r\n", start);
    const head = body.subarray(start, gap).toString();
    parts.push({
      name: head.match(/name="([^"]+)"/)[1],
      type: head.match(/content-type: (.+)/i)?.[1] ?? null,
      content: body.subarray(gap + 4, end - 2),
    });
    at = end;
  }
  return parts;
}
