/** The avatar's file in three.js, the reader that most pages use: its rig, at rest and bent. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import path from "node:path";
import { test } from "node:test";

import { Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const root = path.join(import.meta.dirname, "../..");
const MAKE = `
import sys
from model.estimators import load_estimators
from model.gltf import to_glb
from model.measurements import MeasurementSet
from model.rig import load_rig
body = load_estimators()["female"].estimate(MeasurementSet({"stature": 1.68, "weight": 66.0}))
sys.stdout.buffer.write(to_glb(body, rig=load_rig()))
`;

async function avatar() {
  const options = { cwd: root, maxBuffer: 2 ** 22 };
  const bytes = execFileSync(path.join(root, ".venv/bin/python"), ["-c", MAKE], options);
  const copy = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const { scene } = await new GLTFLoader().parseAsync(copy, "");
  scene.updateMatrixWorld(true);
  const meshes = [];
  scene.traverse((object) => object.isSkinnedMesh && meshes.push(object));
  return { scene, meshes };
}

test("three.js reads the rig: still at rest, bent where a bone turns", async () => {
  const { scene, meshes } = await avatar();
  assert.equal(meshes.length, 2);
  const [skin] = meshes;
  assert.equal(skin.skeleton.bones.length, 22);
  const { position, normal } = skin.geometry.attributes;
  const rest = new Vector3();
  const shown = new Vector3();
  let moved = 0;
  for (let i = 0; i < position.count; i += 7) {
    skin.getVertexPosition(i, shown);
    moved = Math.max(moved, shown.distanceTo(rest.fromBufferAttribute(position, i)));
    const length = Math.hypot(normal.getX(i), normal.getY(i), normal.getZ(i));
    assert.ok(Math.abs(length - 1) < 0.01);
  }
  assert.ok(moved < 1e-4, `${moved} m`);

  scene.getObjectByName("leftLowerArm").rotation.x = -1;
  scene.updateMatrixWorld(true);
  skin.skeleton.update();
  let farthest = 0;
  let right = 0;
  for (let i = 0; i < position.count; i += 7) {
    skin.getVertexPosition(i, shown);
    const distance = shown.distanceTo(rest.fromBufferAttribute(position, i));
    if (rest.x > 0) farthest = Math.max(farthest, distance);
    else right = Math.max(right, distance);
  }
  assert.ok(farthest > 0.2 && right < 1e-4, `${farthest} and ${right} m`);
});
