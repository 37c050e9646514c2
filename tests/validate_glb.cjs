// Validates GLB files by the rules of the Khronos validator: node tests/validate_glb.cjs FILE …
const fs = require("fs");
const validator = require("gltf-validator");

async function main() {
  let bad = false;
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    const { numErrors, numWarnings, messages } = report.issues;
    console.log(`${file.split("/").pop()}: ${numErrors} errors, ${numWarnings} warnings`);
    for (const message of messages.filter((m) => m.severity <= 1).slice(0, 5)) {
      console.log(`  ${message.code} ${message.pointer || ""}: ${message.message}`);
    }
    bad = bad || numErrors > 0;
  }
  process.exit(bad ? 1 : 0);
}

main().catch((error) => {
  console.error(String(error));
  process.exit(1);
});
