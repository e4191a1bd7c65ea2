// The report of Khronos' validator for a model, as one line of JSON: node valid.js MODEL.glb

import { readFile } from "node:fs/promises";

import validator from "gltf-validator";

const report = await validator.validateBytes(new Uint8Array(await readFile(process.argv[2])), { maxIssues: 100 });
const { numErrors: errors, numWarnings: warnings, numInfos: infos, numHints: hints, messages } = report.issues;
console.log(JSON.stringify({ version: report.validatorVersion, errors, warnings, infos, hints, messages }));
