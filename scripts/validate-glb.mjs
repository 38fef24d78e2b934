// Judges GLB files with Khronos' glTF validator: node scripts/validate-glb.mjs [--modules FOLDER] FILE...
//
// Prints every message; exits with 1 where a file has an error or a warning. That readers make tangents for a normal map is none: glTF says how (3.7.2.1,
// MikkTSpace), and tangents in the file would make it a third larger. The validator is pinned in
// tests/node/package.json (`npm ci` there installs it); FOLDER is another node_modules folder to take it from.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const files = process.argv.slice(2);
let modules = join(dirname(fileURLToPath(import.meta.url)), "../tests/node/node_modules");
if (files[0] === "--modules") {
  modules = resolve(files[1]);
  files.splice(0, 2);
}
const validator = createRequire(join(modules, "x.js"))("gltf-validator");

let bad = files.length === 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: file });
  const { numErrors, numInfos, numHints } = report.issues;
  const messages = report.issues.messages.filter((message) => message.code !== "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE");
  const numWarnings = report.issues.numWarnings - (report.issues.messages.length - messages.length);
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
  for (const message of messages) console.log(`  ${message.code} ${message.pointer ?? ""}: ${message.message}`);
  bad ||= numErrors + numWarnings > 0;
}
process.exit(bad ? 1 : 0);
