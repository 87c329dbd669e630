// SPDX-License-Identifier: Apache-2.0
// Commands that run programs and build images, as tasks in a terminal.

import { existsSync, readdirSync } from "node:fs";
import * as path from "node:path";
import * as vscode from "vscode";
import { findLfz, folderOf, programFile, setting } from "./lfz";

/** The tasks that this extension has started and that have not ended. */
const running = new Set<vscode.TaskExecution>();

export function registerPrograms(context: vscode.ExtensionContext): void {
  context.subscriptions.push(
    vscode.commands.registerCommand("lfz.run", (file) => run(file)),
    vscode.commands.registerCommand("lfz.runFederation", (file) => run(file)),
    vscode.commands.registerCommand("lfz.buildForBoard", (file) => buildForBoard(file)),
    vscode.commands.registerCommand("lfz.stop", () => running.forEach((task) => task.terminate())),
    vscode.tasks.onDidEndTask((event) => {
      running.delete(event.execution);
      noteRunning();
    }),
  );
}

function noteRunning(): void {
  void vscode.commands.executeCommand("setContext", "lfz.isRunning", running.size > 0);
}

async function run(given: unknown): Promise<void> {
  const file = await programFile(given);
  if (file !== undefined) {
    await execute(file, "run", ["run", file.fsPath]);
  }
}

/** Builds the image of a program, or those of a federation for the boards of a deployment file. */
async function buildForBoard(given: unknown): Promise<void> {
  const file = await programFile(given);
  if (file === undefined) {
    return;
  }
  const text = (await vscode.workspace.openTextDocument(file)).getText();
  if (/^\s*federated\s+reactor\b/m.test(text)) {
    const deployment = await chooseDeployment(file);
    if (deployment !== undefined) {
      const places = deployment === "" ? [] : ["--deployment", deployment];
      await execute(file, "build", ["west", "lf-fed-build", file.fsPath, ...places]);
    }
    return;
  }
  const board = await vscode.window.showInputBox({
    prompt: "The board, as west knows it",
    value: setting("board"),
    validateInput: (value) => (/^[\w@/.-]+$/.test(value) ? undefined : "A name such as qemu_cortex_m3"),
  });
  if (board !== undefined) {
    await execute(file, "build", ["west", "lf-build", file.fsPath, "-w", `-b ${board}`]);
  }
}

/** Returns the path of a deployment file, or nothing for none; undefined when nobody chooses. */
async function chooseDeployment(file: vscode.Uri): Promise<string | undefined> {
  const none = { label: "No deployment file", description: "places and boards of the program itself", value: "" };
  const choices = deployments(file).map((one) => ({ label: vscode.workspace.asRelativePath(one), value: one }));
  const title = "Where the federates run";
  return (await vscode.window.showQuickPick([...choices, none], { title }))?.value;
}

/** Returns the files in folders `deployment` beside a program, or beside a folder that it is in. */
function deployments(file: vscode.Uri): string[] {
  const top = folderOf(file);
  const found: string[] = [];
  for (let folder = path.dirname(file.fsPath); folder.startsWith(top); folder = path.dirname(folder)) {
    const inside = path.join(folder, "deployment");
    const names = existsSync(inside) ? readdirSync(inside).sort() : [];
    found.push(...names.filter((name) => /\.ya?ml$/.test(name)).map((name) => path.join(inside, name)));
    if (folder === path.dirname(folder)) {
      break;
    }
  }
  return found;
}

/** Runs `lfz` in a terminal of its own. */
async function execute(file: vscode.Uri, what: string, words: string[]): Promise<void> {
  const lfz = findLfz();
  if (lfz === undefined) {
    return;
  }
  const name = `${what} ${path.basename(file.fsPath)}`;
  const process = new vscode.ProcessExecution(lfz, words, { cwd: folderOf(file) });
  const scope = vscode.workspace.getWorkspaceFolder(file) ?? vscode.TaskScope.Workspace;
  const task = new vscode.Task({ type: "lfz", task: name }, scope, name, "lfz", process);
  task.presentationOptions = { panel: vscode.TaskPanelKind.Dedicated, clear: true };
  running.add(await vscode.tasks.executeTask(task));
  noteRunning();
}
