// SPDX-License-Identifier: Apache-2.0
// A real editor with the packed extension: the server of code-server, which is VS Code's, and a headless Chromium.

import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const folder = path.join(path.dirname(fileURLToPath(import.meta.url)), "..");
const code = path.join(folder, "node_modules/code-server/lib/vscode");
const main = path.join(code, "out/server-main.js");

/** Installs the modules of VS Code's server, as code-server's own script does, which refuses some users. */
function prepare() {
  const quiet = { cwd: code, stdio: ["ignore", "ignore", "inherit"] };
  if (!existsSync(path.join(code, "node_modules/node-pty"))) {
    execFileSync("npm", ["install", "--ignore-scripts", "--omit=dev", "--no-audit", "--no-fund"], quiet);
  }
  const terminal = path.join(code, "node_modules/node-pty/build/Release/pty.node");
  if (!existsSync(terminal)) {
    // Terminals need a module in C++, whose headers are those of this Node.js where they are installed. What npm would
    // do after that is for those who change the module.
    const headers = existsSync("/usr/include/node") ? { npm_config_nodedir: "/usr" } : {};
    spawnSync("npm", ["rebuild", "node-pty"], { cwd: code, stdio: "ignore", env: { ...process.env, ...headers } });
    if (!existsSync(terminal)) {
      throw new Error("node-pty cannot be compiled: it needs make, g++, python3 and the headers of Node.js");
    }
  }
}

/** Starts an editor in a folder with these files, and settings of a machine. */
export async function startEditor({ files, settings, width = 1280, height = 800 }) {
  prepare();
  const home = mkdtempSync(path.join(tmpdir(), "lf-editor-"));
  const workspace = path.join(home, "program");
  mkdirSync(workspace);
  for (const [name, text] of Object.entries(files)) {
    mkdirSync(path.dirname(path.join(workspace, name)), { recursive: true });
    writeFileSync(path.join(workspace, name), text);
  }
  const data = path.join(home, "data");
  mkdirSync(path.join(data, "data/Machine"), { recursive: true });
  const quiet = {
    "workbench.startupEditor": "none",
    "telemetry.telemetryLevel": "off",
    "terminal.integrated.gpuAcceleration": "off",
    "editor.minimap.enabled": false,
    "chat.commandCenter.enabled": false,
    "workbench.secondarySideBar.defaultVisibility": "hidden",
  };
  writeFileSync(path.join(data, "data/Machine/settings.json"), JSON.stringify({ ...quiet, ...settings }));
  const words = [main, "--server-data-dir", data, "--extensions-dir", path.join(home, "extensions")];
  words.push("--accept-server-license-terms", "--telemetry-level", "off");
  const extension = path.join(folder, "out/lf-zephyr.vsix");
  execFileSync("node", [...words, "--install-extension", extension], { stdio: ["ignore", "ignore", "inherit"] });
  const server = spawn("node", [...words, "--without-connection-token", "--host", "127.0.0.1", "--port", "0"], {
    stdio: ["ignore", "pipe", "ignore"],
    env: { ...process.env, SHELL: "/bin/sh" },
  });
  const port = await new Promise((resolve, reject) => {
    let said = "";
    server.stdout.on("data", (piece) => {
      said += piece;
      const found = /Web UI available at http:\/\/[^:]+:(\d+)/.exec(said);
      if (found) {
        resolve(found[1]);
      }
    });
    server.on("exit", () => reject(new Error(`the editor's server has ended: ${said}`)));
  });
  const program = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  const browser = await chromium.launch({ executablePath: program, args: ["--no-sandbox", "--disable-gpu"] });
  const page = await browser.newPage({ viewport: { width, height } });
  page.setDefaultTimeout(60_000);
  await page.goto(`http://127.0.0.1:${port}/?folder=${encodeURIComponent(workspace)}`);
  await page.getByText("Yes, I trust the authors").click();
  await page.waitForSelector(".explorer-folders-view .monaco-list-row");
  return new Editor(page, workspace, async () => {
    await browser.close();
    const ended = new Promise((resolve) => server.on("exit", resolve));
    server.kill();
    await ended;
    rmSync(home, { recursive: true, force: true });
  });
}

/** An editor, used as a person does: by keys and the mouse. */
class Editor {
  constructor(page, workspace, end) {
    this.page = page;
    this.workspace = workspace;
    this.end = end;
  }

  /** Opens a file of the workspace's folder. */
  async open(name) {
    await this.page.locator(".explorer-folders-view .monaco-list-row", { hasText: name }).first().dblclick();
    await this.page.locator(`.tab.active[data-resource-name="${name}"]`).waitFor();
    await this.page.locator(".editor-instance .monaco-editor .view-line").first().waitFor();
  }

  /** Runs a command of the palette. */
  async command(title) {
    await this.page.keyboard.press("F1");
    await this.page.locator(".quick-input-box input").fill(`>${title}`);
    await this.page.locator(".quick-input-list .monaco-list-row", { hasText: title }).first().waitFor();
    await this.page.locator(".quick-input-box input").press("Enter");
  }

  /** Puts the cursor on a line and a column, from 1. */
  async go(line, column) {
    await this.page.keyboard.press("Control+G");
    await this.page.locator(".quick-input-box input").fill(`:${line}:${column}`);
    await this.page.locator(".quick-input-list", { hasText: `line ${line} and character ${column}` }).waitFor();
    await this.page.locator(".quick-input-box input").press("Enter");
    await this.page.locator(".quick-input-widget").waitFor({ state: "hidden" });
  }

  /** Returns a line of the text in the editor, as it is shown. */
  line(text) {
    return this.page.locator(".view-line", { hasText: text }).first();
  }

  async screenshot(file) {
    await this.page.screenshot({ path: file });
  }
}
