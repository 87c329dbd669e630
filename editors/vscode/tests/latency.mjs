// SPDX-License-Identifier: Apache-2.0
// Measures how long `lfz lsp` takes in a file of many reactors: from a key to the diagnostics, and to the completions.
// The time of the processor is what it takes on a computer with nothing else to do.
// `LFZ=PATH npm run latency [REACTORS]`

import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const folder = path.join(path.dirname(fileURLToPath(import.meta.url)), "..");
const lfz = path.resolve(process.env.LFZ ?? path.join(folder, "../../target/release/lfz"));
const count = Number(process.argv[2] ?? 1000);
const ROUNDS = 20;

function program(extra) {
  const reactor = (index) => `reactor R${index}(period: time = 10 ms) {
  input x: u32
  output y: u32
  state last: u32 = 0
  timer t(0, period)
  reaction(t, x) -> y {=
    self.last += ctx.get(x).unwrap_or_default();
    ctx.set(y, self.last);
  =}
}
`;
  const numbers = Array.from({ length: count }, (_, index) => index);
  const instances = numbers.map((index) => `  i${index} = new R${index}()\n`).join("");
  const connections = numbers.slice(1).map((index) => `  i${index - 1}.y -> i${index}.x\n`).join("");
  return `target Rust\n${numbers.map(reactor).join("")}main reactor {\n${instances}${connections}${extra}}\n`;
}

const server = spawn(lfz, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
let buffer = Buffer.alloc(0);
const waiting = [];
server.stdout.on("data", (piece) => {
  buffer = Buffer.concat([buffer, piece]);
  for (;;) {
    const end = buffer.indexOf("\r\n\r\n");
    const length = Number(/Content-Length: (\d+)/.exec(buffer.subarray(0, Math.max(end, 0)).toString())?.[1]);
    if (end < 0 || buffer.length < end + 4 + length) {
      return;
    }
    const message = JSON.parse(buffer.subarray(end + 4, end + 4 + length));
    buffer = buffer.subarray(end + 4 + length);
    const found = waiting.findIndex(([wanted]) => wanted(message));
    if (found >= 0) {
      waiting.splice(found, 1)[0][1](message);
    }
  }
});
const send = (message) => {
  const text = Buffer.from(JSON.stringify({ jsonrpc: "2.0", ...message }));
  server.stdin.write(`Content-Length: ${text.length}\r\n\r\n`);
  server.stdin.write(text);
};
const hear = (wanted) => new Promise((resolve) => waiting.push([wanted, resolve]));
let asked = 0;
const ask = (method, params) => {
  asked += 1;
  const id = asked;
  const answer = hear((message) => message.id === id);
  send({ id, method, params });
  return answer;
};
const diagnostics = () => hear((message) => message.method === "textDocument/publishDiagnostics");

const uri = "file:///nowhere/Many.lf";
await ask("initialize", { capabilities: {}, processId: null, rootUri: null });
send({ method: "initialized", params: {} });
let told = diagnostics();
send({
  method: "textDocument/didOpen",
  params: { textDocument: { uri, languageId: "lf", version: 1, text: program("") } },
});
await told;

/** Returns the time that the server has had a processor, in milliseconds. */
function processorTime() {
  const [user, system] = readFileSync(`/proc/${server.pid}/stat`, "utf8").split(") ")[1].split(" ").slice(11, 13);
  return 10 * (Number(user) + Number(system));
}

async function measured(name, once) {
  const times = [];
  const before = processorTime();
  for (let round = 0; round < ROUNDS; round += 1) {
    const begin = performance.now();
    await once(round);
    times.push(performance.now() - begin);
  }
  times.sort((one, other) => one - other);
  const [median, most] = [times[ROUNDS / 2], times[ROUNDS - 1]].map((time) => time.toFixed(0));
  const busy = ((processorTime() - before) / ROUNDS).toFixed(0);
  console.log(`${name.padEnd(12)} median ${median} ms, most ${most} ms, of the processor ${busy} ms`);
}

const text = program("");
console.log(`${count} reactors, ${text.split("\n").length} lines, ${ROUNDS} times each`);
await measured("diagnostics", async (round) => {
  told = diagnostics();
  const changed = program(`  // ${round}\n`);
  const params = { textDocument: { uri, version: round + 2 }, contentChanges: [{ text: changed }] };
  send({ method: "textDocument/didChange", params });
  await told;
});
const textDocument = { uri };
const line = text.split("\n").findIndex((one) => one.includes("self.last +="));
const position = { line, character: 9 };
await measured("completion", () => ask("textDocument/completion", { textDocument, position }));
await measured("hover", () => ask("textDocument/hover", { textDocument, position: { line: line - 4, character: 9 } }));
await measured("definition", () => ask("textDocument/definition", { textDocument, position }));
await measured("colours", () => ask("textDocument/semanticTokens/full", { textDocument }));
server.kill();
