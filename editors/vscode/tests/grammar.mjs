// SPDX-License-Identifier: Apache-2.0
// Colours all programs of the repository with the grammar, together with VS Code's own grammars of Rust, C and C++.
//
// No word in a body is taken for one of LF, and none outside of bodies for one of their languages; keywords of LF are
// coloured, and the colours of a sample are those of its snapshot.

import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync, existsSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const require = createRequire(import.meta.url);
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const folder = path.join(path.dirname(fileURLToPath(import.meta.url)), "..");
const repository = path.join(folder, "../..");
const extensions = path.join(folder, "node_modules/code-server/lib/vscode/extensions");
const GRAMMARS = {
  "source.lf": path.join(folder, "syntaxes/lf.tmLanguage.json"),
  "source.rust": path.join(extensions, "rust/syntaxes/rust.tmLanguage.json"),
  "source.c": path.join(extensions, "cpp/syntaxes/c.tmLanguage.json"),
  "source.cpp": path.join(extensions, "cpp/syntaxes/cpp.tmLanguage.json"),
  "source.cpp.embedded.macro": path.join(extensions, "cpp/syntaxes/cpp.embedded.macro.tmLanguage.json"),
  "source.c.platform": path.join(extensions, "cpp/syntaxes/platform.tmLanguage.json"),
};

/** Words that begin a declaration, wherever they stand outside of bodies, strings and comments. */
const KEYWORDS = /^(reactor|reaction|input|output|timer|action|preamble|federated|main|target|import)$/;

const wasm = readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm"));
await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.byteLength));
const registry = new textmate.Registry({
  onigLib: Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  }),
  loadGrammar: async (scope) => {
    const file = GRAMMARS[scope];
    return file === undefined ? null : textmate.parseRawGrammar(readFileSync(file, "utf8"), file);
  },
});
const grammar = await registry.loadGrammar("source.lf");

/** Returns the tokens of a text with their places. */
function tokens(text) {
  const all = [];
  let state = textmate.INITIAL;
  let start = 0;
  for (const line of text.split("\n")) {
    const result = grammar.tokenizeLine(line, state, 5000);
    if (result.stoppedEarly) {
      throw new Error(`a line takes too long: ${line}`);
    }
    for (const token of result.tokens) {
      all.push({ ...token, text: line.slice(token.startIndex, token.endIndex), start: start + token.startIndex });
    }
    state = result.ruleStack;
    start += line.length + 1;
  }
  return all;
}

/** Returns the bytes of bodies. */
function bodies(text) {
  const found = [];
  for (let at = text.indexOf("{="); at >= 0; at = text.indexOf("{=", at)) {
    const end = text.indexOf("=}", at);
    if (end < 0) {
      break;
    }
    found.push([at + 2, end]);
    at = end + 2;
  }
  return found;
}

function problems(file, text) {
  const found = [];
  const inBody = bodies(text);
  let body = 0;
  for (const token of tokens(text)) {
    while (body < inBody.length && token.start >= inBody[body][1]) {
      body += 1;
    }
    const inside = body < inBody.length && token.start >= inBody[body][0];
    const last = token.scopes[token.scopes.length - 1];
    const embedded = token.scopes.some((scope) => scope.startsWith("meta.embedded.block"));
    const word = token.text.trim();
    const line = text.slice(0, token.start).split("\n").length;
    const say = (what) => found.push(`${file}:${line}: \`${word}\` ${what} (${last})`);
    if (inside && word !== "" && !embedded) {
      say("is in a body, and has no colour of its language");
    } else if (inside && last.endsWith(".lf")) {
      say("is in a body, and is coloured as LF");
    } else if (!inside && embedded) {
      say("is in no body, and is coloured as its language");
    } else if (!inside && KEYWORDS.test(word) && !/comment|string|keyword|storage|property|import|value/.test(last)) {
      say("has no colour");
    }
  }
  return found;
}

const listed = execFileSync("git", ["ls-files", "*.lf", "*.ulf"], { cwd: repository, encoding: "utf8" });
const all = listed.split("\n").filter((file) => file !== "" && !file.startsWith("tests/fail/"));
// Bodies whose strings or comments have `=}` in them are the compiler's tests, and no grammar's.
const read = (file) => readFileSync(path.join(repository, file), "utf8").replace(/\r\n/g, "\n");
const files = all.filter((file) => !/[{]=|=[}]/.test(read(file).replace(/\{=[^]*?=\}/g, "")));
let failed = 0;
for (const file of files) {
  const found = problems(file, read(file));
  found.slice(0, 5).forEach((line) => console.error(line));
  failed += found.length > 0 ? 1 : 0;
}
console.log(`${files.length} of ${all.length} programs are coloured, ${failed} of them wrong`);

const sample = path.join(folder, "tests/sample.lf");
const snapshot = path.join(folder, "tests/sample.snap");
const short = (scopes) => scopes.filter((scope) => !scope.startsWith("source.lf") && !scope.startsWith("meta.program"));
const colours = tokens(readFileSync(sample, "utf8"))
  .filter((token) => token.text.trim() !== "")
  .map((token) => `${token.text.trim()}  ${short(token.scopes).join(" ")}\n`)
  .join("");
if (process.env.UPDATE || !existsSync(snapshot)) {
  writeFileSync(snapshot, colours);
} else if (readFileSync(snapshot, "utf8") !== colours) {
  console.error("the colours of tests/sample.lf are others: see them with UPDATE=1 npm run test:grammar");
  failed += 1;
}
process.exit(failed > 0 || files.length === 0 ? 1 : 0);
