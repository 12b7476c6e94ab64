/**
 * Khronos's glTF validator on a file or on what comes in: prints its findings as JSON, and fails
 * where there is an error or a warning.
 *
 *     node scripts/validate_glb.mjs avatar.glb
 */

import { readFileSync } from "node:fs";

import { validateBytes } from "gltf-validator";

const bytes = readFileSync(process.argv[2] ?? 0);
const { issues } = await validateBytes(new Uint8Array(bytes));
console.log(JSON.stringify(issues, null, 2));
process.exitCode = issues.numErrors + issues.numWarnings > 0 ? 1 : 0;
