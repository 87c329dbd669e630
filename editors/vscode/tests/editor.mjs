// SPDX-License-Identifier: Apache-2.0
// Uses the packed extension in a real editor. `LFZ` names the program `lfz`; `SCREENSHOTS` a folder for pictures.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { chmodSync, existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { folder, startEditor } from "./host.mjs";

const lfz = path.resolve(process.env.LFZ ?? path.join(folder, "../../target/debug/lfz"));
const pictures = process.env.SCREENSHOTS;
const notes = mkdtempSync(path.join(tmpdir(), "lf-calls-"));
const calls = path.join(notes, "calls");
process.env.LF_EDITOR_CALLS = calls;
process.env.LF_EDITOR_LFZ = lfz;
writeFileSync(calls, "");
// Other federations of this user are not the suite's.
process.env.XDG_RUNTIME_DIR = notes;

const METER = `target Rust
/** Counts what the wheel of the meter does. */
reactor Meter(period: time = 250 ms) {
  output count: u32
  state turns: u32 = 0
  timer t(0, period)
  reaction(t) -> count {=
    self.turns += 1;
    ctx.set(count, self.turns);
  =}
}
`;
const GRID = `target Rust {
  coordination: decentralized,
  timeout: 2 s
}

import Meter from "Meter.lf"

reactor Show {
  @capacity(16)
  input x: u32
  state last: u32 = 0

  reaction(x) {=
    let value = ctx.get(x).unwrap_or_default();
    println!("{value} after {}", self.last);
    self.last = value;
  =}
}

federated reactor {
  @maxwait(20 ms)
  show = new Show()
  meter = new Meter()
  meter.count -> show.x after 10 ms
}
`;
const HELLO = `target C {
  timeout: 1 s
}

main reactor {
  timer t(0, 100 ms)
  state n: int = 0

  reaction(t) {=
    // Counts.
    self->n++;
    lf_print("%d", self->n);
  =}
}
`;

const COUNT = `target Rust {
  timeout: 1 s
}
main reactor {
  timer t(0, 100 ms)
  state n: u32 = 0
  reaction(t) {=
    self.n += 1;
    println!("{}", self.n);
  =}
}
`;

const COMINGS = `target Rust

reactor Meter {
  output watts: u32
  timer t(0, 100 ms)
  reaction(t) -> watts {= ctx.set(watts, 5); =}
}

reactor Show {
  input watts: u32
  reaction(watts) {= println!("{}", ctx.get(watts).unwrap_or_default()); =}
}

federated reactor {
  meter = new Meter()
  @transient
  show = new Show()
  meter.watts -> show.watts
}
`;

/** Waits until a condition holds that only the world outside of the page knows. */
async function until(what, condition) {
  const end = Date.now() + 60_000;
  while (!(await condition())) {
    assert.ok(Date.now() < end, `never: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

const called = () => readFileSync(calls, "utf8").split("\n");
const tests = [];
const test = (name, body) => tests.push([name, body]);
let editor;

async function picture(name) {
  if (pictures !== undefined) {
    await editor.screenshot(path.join(pictures, `${name}.png`));
  }
}

test("a missing lfz is told with its remedy", async () => {
  const toast = editor.page.locator(".notification-list-item", { hasText: "there is no program" });
  await editor.open("Grid.lf");
  await toast.waitFor();
  await toast.getByText("Open Setting").waitFor();
  await picture("missing");
  await editor.page.keyboard.press("Escape");
  const settings = path.join(editor.workspace, ".vscode/settings.json");
  writeFileSync(settings, JSON.stringify({ "lfz.path": path.join(folder, "tests/lfz.sh") }));
  await until("the server starts with the new setting", () => called().includes("lsp"));
  await editor.page.locator(".notifications-toasts").waitFor({ state: "hidden" });
});

test("lenses and waits stand between the lines", async () => {
  for (const title of ["Run federation", "Debug", "Build for board", "Show graph"]) {
    await editor.page.locator(".codelens-decoration a", { hasText: title }).waitFor();
  }
  await editor.line("waits 20 ms for meter").waitFor();
  await picture("grid");
});

test("words have the colours of what they are, in bodies by their own language", async () => {
  const colour = async (line, word) => {
    const shown = editor.page.locator(".view-line", { hasText: line }).first();
    const span = shown.locator("span", { hasText: new RegExp(`^${word}$`) }).first();
    return await span.evaluate((node) => getComputedStyle(node).color);
  };
  const plain = await editor.page.locator(".monaco-editor").first().evaluate((node) => getComputedStyle(node).color);
  const [keyword, reactor] = [await colour("let value = ctx", "let"), await colour("reactor Show", "Show")];
  assert.equal(new Set([plain, keyword, reactor]).size, 3);
});

test("an error is told while it is typed, and has a quick fix", async () => {
  await editor.go(24, 19);
  await editor.page.keyboard.type("q");
  await editor.page.locator(".squiggly-error").first().waitFor();
  const fix = editor.page.locator(".action-widget", { hasText: "Write `show`" });
  // The editor may know the error before it knows what to do about it.
  await until("the fix is offered", async () => {
    await editor.page.keyboard.press("Control+.");
    return await fix.waitFor({ timeout: 3000 }).then(
      () => true,
      () => false,
    );
  });
  await picture("fix");
  await editor.page.keyboard.press("Enter");
  await editor.page.locator(".squiggly-error").first().waitFor({ state: "detached" });
  await editor.line("meter.count -> show.x").waitFor();
});

test("names are described with facts of the program", async () => {
  for (const [line, column, fact] of [
    [22, 4, "federate 0: waits 20 ms for meter"],
    [10, 9, "messages of meter after 10 ms, capacity 16, waits 20 ms"],
  ]) {
    await editor.go(line, column);
    await editor.command("Show or Focus Hover");
    await editor.page.locator(".monaco-hover", { hasText: fact }).waitFor();
    await picture("hover");
    await editor.page.keyboard.press("Escape");
  }
});

test("a body is completed by the methods of ctx", async () => {
  await editor.go(16, 23);
  await editor.page.keyboard.press("Enter");
  await editor.page.keyboard.type("ctx.get");
  const list = editor.page.locator(".suggest-widget.visible .monaco-list-row");
  await list.filter({ hasText: "get_elapsed_logical_time" }).first().waitFor();
  await picture("completion");
  await editor.page.keyboard.press("Escape");
  await editor.page.keyboard.press("Control+Shift+K");
  await editor.line("ctx.get_").waitFor({ state: "detached" });
});

test("a definition is found in another file", async () => {
  await editor.go(24, 12);
  await editor.page.keyboard.press("F12");
  await editor.page.locator('.tab.active[data-resource-name="Meter.lf"]').waitFor();
});

test("a name is changed in both files", async () => {
  await editor.go(4, 12);
  await editor.page.keyboard.press("F2");
  const input = editor.page.locator(".rename-box input");
  await input.fill("total");
  await editor.page.keyboard.press("Enter");
  await editor.line("ctx.set(total").waitFor();
  await editor.command("File: Save All Files");
  const text = (name) => readFileSync(path.join(editor.workspace, name), "utf8");
  const isSaved = () => text("Meter.lf").includes("output total") && text("Grid.lf").includes("meter.total ->");
  await until("both files are saved", isSaved);
});

test("a federation runs until it is stopped", async () => {
  await editor.open("Grid.lf");
  await editor.page.locator(".codelens-decoration a", { hasText: "Run federation" }).click();
  await until("it runs", () => called().includes(`run ${path.join(editor.workspace, "Grid.lf")}`));
  await editor.page.locator(".xterm-rows", { hasText: "the program runs" }).waitFor();
  await picture("run");
  await editor.command("LF: Stop");
  await until("it has ended", () => called().includes("ended"));
});

test("the graph is beside the text", async () => {
  await editor.command("LF: Show Graph");
  const frame = editor.page.frameLocator("iframe.webview.ready").frameLocator("iframe#active-frame");
  await frame.locator("svg").first().waitFor();
  await picture("graph");
  assert.ok(called().includes(`graph ${path.join(editor.workspace, "Grid.lf")}`));
  await editor.command("View: Close All Editors");
});

test("an image is built for a board", async () => {
  await editor.open("Hello.lf");
  await editor.line("lf_print").waitFor();
  await picture("c");
  await editor.command("LF: Build for Board");
  const box = editor.page.locator(".quick-input-box input");
  await editor.page.locator(".quick-input-message", { hasText: "The board" }).waitFor();
  await box.fill("qemu_cortex_m3");
  await editor.page.keyboard.press("Enter");
  const file = path.join(editor.workspace, "Hello.lf");
  await until("west is called", () => called().includes(`west lf-build ${file} -w -b qemu_cortex_m3`));
});

test("a federation is built for the boards of a deployment", async () => {
  await editor.open("Grid.lf");
  await editor.command("LF: Build for Board");
  await editor.page.locator(".quick-input-list .monaco-list-row", { hasText: "two-boards.yaml" }).click();
  const words = ["lf-fed-build", path.join(editor.workspace, "Grid.lf"), "--deployment"];
  const call = `west ${words.join(" ")} ${path.join(editor.workspace, "deployment/two-boards.yaml")}`;
  await until("west is called", () => called().includes(call));
});

const view = () => editor.page.frameLocator("iframe.webview.ready").frameLocator("iframe#active-frame");

test("federates are seen, stopped and started", async () => {
  await editor.command("View: Close All Editors");
  const words = ["run", "Comings.lf", "--trace", "traces"];
  const run = spawn(lfz, words, { cwd: editor.workspace, stdio: ["ignore", "ignore", "inherit"] });
  const ended = new Promise((resolve) => run.on("exit", resolve));
  await editor.open("Comings.lf");
  await editor.command("LF: Show Federations");
  const show = view().locator("tr", { hasText: "show" });
  await show.getByText("runs", { exact: true }).waitFor({ timeout: 600_000 });
  await picture("federations");
  await show.getByRole("button", { name: "Stop" }).click();
  await show.getByText("does not run").waitFor();
  await show.getByRole("button", { name: "Start" }).click();
  await show.getByText("runs", { exact: true }).waitFor();
  run.kill("SIGINT");
  await ended;
  await view().getByText("No federation of yours runs").waitFor();
});

test("a recorded run is a table of times, with its lines", async () => {
  await editor.command("View: Close All Editors");
  await editor.command("LF: Show Trace");
  await view().locator("pre", { hasText: "running reactions" }).waitFor();
  await picture("trace");
  await view().locator("a", { hasText: "Comings.lf:6" }).first().click();
  await editor.page.locator('.tab.active[data-resource-name="Comings.lf"]').waitFor();
});

/** Whether this computer has a debug adapter, as the extension looks for it. */
function hasAdapter() {
  const folders = (process.env.PATH ?? "").split(path.delimiter).filter(existsSync);
  return folders.flatMap((one) => readdirSync(one)).some((name) => /^lldb-(dap|vscode)(-\d+)?$/.test(name));
}

if (hasAdapter()) {
  test("a breakpoint at a line of a body in Rust stops the program there", async () => {
    await editor.command("View: Close All Editors");
    await editor.open("Count.lf");
    await editor.go(9, 5);
    await editor.page.keyboard.press("F9");
    await editor.page.locator(".debug-breakpoint, .codicon-debug-breakpoint").first().waitFor();
    await editor.page.locator(".codelens-decoration a", { hasText: "Debug" }).click();
    const stopped = editor.page.locator(".debug-top-stack-frame-line, .codicon-debug-stackframe").first();
    await stopped.waitFor({ timeout: 300_000 });
    await editor.page.locator(".debug-call-stack", { hasText: "reaction_1" }).waitFor();
    await picture("debug");
    await editor.page.keyboard.press("Shift+F5");
    await editor.page.locator(".debug-toolbar").waitFor({ state: "hidden" });
  });
  test("a federate is debugged beside the others", async () => {
    await editor.command("View: Close All Editors");
    await editor.command("View: Show Explorer");
    await editor.open("Meter.lf");
    await editor.go(8, 5);
    await editor.page.keyboard.press("F9");
    await editor.open("Grid.lf");
    await editor.page.locator(".codelens-decoration a", { hasText: "Debug" }).click();
    await editor.page.locator(".quick-input-list .monaco-list-row", { hasText: "meter" }).click();
    await editor.page.locator('.tab.active[data-resource-name="Meter.lf"]').waitFor({ timeout: 300_000 });
    await editor.page.locator(".debug-call-stack", { hasText: "Meter::reaction_1" }).waitFor();
    await picture("federate");
    await editor.page.keyboard.press("Shift+F5");
    await editor.page.locator(".debug-toolbar").waitFor({ state: "hidden" });
  });
} else {
  console.log("skipped: there is no lldb-dap for a breakpoint");
}

assert.ok(existsSync(lfz), `there is no ${lfz}: cargo build --bin lfz`);
chmodSync(path.join(folder, "tests/lfz.sh"), 0o755);
let failed = 0;
const files = {
  "Grid.lf": GRID,
  "Meter.lf": METER,
  "Hello.lf": HELLO,
  "Count.lf": COUNT,
  "Comings.lf": COMINGS,
  "deployment/two-boards.yaml": "federates: {}\n",
  ".vscode/settings.json": JSON.stringify({ "lfz.path": "/nowhere/lfz" }),
};
try {
  editor = await startEditor({ files, settings: {} });
  for (const [name, body] of tests) {
    try {
      await body();
      console.log(`ok ${name}`);
    } catch (error) {
      failed += 1;
      console.log(`FAILED ${name}: ${error.message}`);
      await editor.screenshot(path.join(pictures ?? tmpdir(), "lf-editor-failure.png"));
      break;
    }
  }
} finally {
  await editor?.end();
  rmSync(notes, { recursive: true, force: true });
}
console.log(`${tests.length - failed} passed, ${failed} failed`);
process.exit(failed === 0 ? 0 : 1);
