/** The avatar's file in three.js, the reader that most pages use: its rig, at rest and bent. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import path from "node:path";
import { test } from "node:test";

import { Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { readGlb } from "../../static/glb.js";

const root = path.join(import.meta.dirname, "../..");
const HEAD = `
import sys
from model.estimators import load_estimators
from model.gltf import to_glb
from model.measurements import MeasurementSet
from model.morph_targets import morph_targets
from model.rig import load_rig
asked = MeasurementSet({"stature": 1.68, "weight": 66.0})
estimator = load_estimators()["female"]
body = estimator.estimate(asked)
`;

/** The file that the last argument of Python's words makes. */
function file(made) {
  const options = { cwd: root, maxBuffer: 2 ** 23 };
  const words = `${HEAD}sys.stdout.buffer.write(${made})`;
  const bytes = execFileSync(path.join(root, ".venv/bin/python"), ["-c", words], options);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
}

async function avatar() {
  const { scene } = await new GLTFLoader().parseAsync(file("to_glb(body, rig=load_rig())"), "");
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

test("three.js bends the body by its morph targets as the page does", async () => {
  const glb = file("to_glb(body, morphs=morph_targets(estimator, body, asked))");
  const { positions, targets } = readGlb(glb);
  assert.deepEqual(targets.map(({ name }) => name), ["stature", "weight"]);
  const { scene } = await new GLTFLoader().parseAsync(glb, "");
  const skin = scene.getObjectByProperty("isMesh", true);
  assert.deepEqual(Object.keys(skin.morphTargetDictionary), ["stature", "weight"]);
  skin.morphTargetInfluences = [0.5, -0.25];
  const shown = new Vector3();
  let moved = 0;
  for (let i = 0; i < positions.length / 3; i += 7) {
    skin.getVertexPosition(i, shown);
    const expected = [0, 1, 2].map((k) => {
      const at = 3 * i + k;
      return positions[at] + 0.5 * targets[0].moves[at] - 0.25 * targets[1].moves[at];
    });
    assert.ok(shown.distanceTo(new Vector3(...expected)) < 1e-5);
    moved = Math.max(moved, Math.abs(expected[1] - positions[3 * i + 1]));
  }
  assert.ok(moved > 0.05, `${moved} m`);
});
