// SPDX-License-Identifier: Apache-2.0
// Asks Perfetto's own trace processor about a trace: node query.cjs FOLDER TRACE SQL...
//
// FOLDER is a build of Perfetto's UI, which has the trace processor as engine_bundle.js and trace_processor.wasm: a
// worker of a browser, for which this is the browser. Each answer is a line: a list of rows in JSON.
//
// The messages in both directions are those of Perfetto's protos/perfetto/trace_processor/trace_processor.proto.
"use strict";

const fs = require("fs");
const path = require("path");

const [folder, trace, ...queries] = process.argv.slice(2);

// --- Protocol buffers, as far as they are needed ---

function varint(number) {
  const bytes = [];
  let rest = BigInt(number);
  for (; rest > 127n; rest >>= 7n) bytes.push(Number(rest & 127n) | 128);
  return Buffer.from([...bytes, Number(rest)]);
}

const whole = (field, number) => Buffer.concat([varint(field * 8), varint(number)]);
const bytes = (field, value) => Buffer.concat([varint(field * 8 + 2), varint(value.length), value]);

function* fields(buffer) {
  let at = 0;
  const read = () => {
    let value = 0n;
    for (let shift = 0n; ; shift += 7n) {
      const byte = buffer[at++];
      value |= BigInt(byte & 127) << shift;
      if (byte < 128) return value;
    }
  };
  while (at < buffer.length) {
    const key = Number(read());
    const [field, type] = [key >> 3, key & 7];
    if (type === 0) {
      yield [field, read()];
    } else {
      const length = type === 2 ? Number(read()) : type === 1 ? 8 : 4;
      yield [field, buffer.subarray(at, at + length)];
      at += length;
    }
  }
}

function integers(buffer) {
  const all = [];
  let [value, shift] = [0n, 0n];
  for (const byte of buffer) {
    value |= BigInt(byte & 127) << shift;
    shift += 7n;
    if (byte < 128) {
      all.push(BigInt.asIntN(64, value));
      [value, shift] = [0n, 0n];
    }
  }
  return all;
}

// --- The trace processor in its worker ---

const port = { postMessage: (data) => answer(Buffer.from(data)) };
const self = { location: { href: "http://localhost/engine_bundle.js" } };

/** The environment of the worker in a browser: files are there at once, and there is no `process`. */
const browser = {
  self,
  WorkerGlobalScope: class {},
  console: { log() {}, warn() {}, error: console.error },
  process: undefined,
  XMLHttpRequest: class {
    open(_, url) {
      this.response = fs.readFileSync(path.join(folder, path.basename(String(url))));
    }
    send() {}
  },
};

const [APPEND, FINISH, QUERY] = [1, 2, 3];
let sent = 0;

function ask(method, rest = Buffer.alloc(0)) {
  const request = Buffer.concat([whole(1, sent++), whole(2, method), rest]);
  port.onmessage({ data: new Uint8Array(bytes(1, request)) });
}

let rows = null;

/** Collects the rows of a query; they come before `ask` returns. */
function answer(stream) {
  for (const [, message] of fields(stream)) {
    for (const [field, result] of fields(message)) {
      if (field === 5) throw new Error(`the trace processor: ${result}`);
      if (field === 203) collect(result);
    }
  }
}

function collect(result) {
  for (const [field, value] of fields(result)) {
    if (field === 1) rows.columns += 1;
    if (field === 2 && value.length > 0) throw new Error(`the trace processor: ${value}`);
    if (field !== 3) continue;
    const batch = { 1: [], 2: [], 5: [] };
    const doubles = [];
    for (const [part, data] of fields(value)) {
      if (part === 1 || part === 2) batch[part].push(...integers(data));
      if (part === 3) for (let at = 0; at < data.length; at += 8) doubles.push(data.readDoubleLE(at));
      if (part === 5) batch[5].push(...data.toString().split("\0"));
    }
    for (const type of batch[1]) {
      const cells = { 1: () => null, 2: () => Number(batch[2].shift()), 3: () => doubles.shift(), 4: () => batch[5].shift() };
      rows.cells.push(cells[Number(type)]());
    }
  }
}

async function main() {
  const worker = fs.readFileSync(path.join(folder, "engine_bundle.js"), "utf8");
  new Function(...Object.keys(browser), worker)(...Object.values(browser));
  self.onmessage({ data: port });
  // The messages that the worker has deferred until its WebAssembly was ready.
  await new Promise(setImmediate);
  ask(APPEND, bytes(101, fs.readFileSync(trace)));
  ask(FINISH);
  for (const query of queries) {
    rows = { columns: 0, cells: [] };
    ask(QUERY, bytes(103, bytes(1, Buffer.from(query))));
    const table = [];
    while (rows.cells.length > 0) table.push(rows.cells.splice(0, rows.columns));
    console.log(JSON.stringify(table));
  }
}

main().then(
  () => process.exit(0),
  (error) => {
    console.error(error);
    process.exit(1);
  },
);
