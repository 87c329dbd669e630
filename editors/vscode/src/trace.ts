// SPDX-License-Identifier: Apache-2.0
// The recordings of a run: the table of times that `lfz trace` prints, with its lines of LF, and the file for Perfetto.

import { readdirSync } from "node:fs";
import * as path from "node:path";
import * as vscode from "vscode";
import { captured, findLfz } from "./lfz";
import { CLICKS, escaped, page, says, WORDS } from "./page";

/** The page that shows a recording as a timeline; it keeps the file on this computer. */
const PERFETTO = "https://ui.perfetto.dev";

export function registerTrace(context: vscode.ExtensionContext): void {
  context.subscriptions.push(vscode.commands.registerCommand("lfz.showTrace", (folder) => showTrace(folder)));
}

async function showTrace(given: unknown): Promise<void> {
  const lfz = findLfz();
  const folder = given instanceof vscode.Uri ? given.fsPath : await chooseRecording();
  if (lfz === undefined || folder === undefined) {
    return;
  }
  const title = `Trace of ${vscode.workspace.asRelativePath(folder)}`;
  const column = { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true };
  const panel = vscode.window.createWebviewPanel("lfz.trace", title, column, { enableScripts: true });
  panel.webview.onDidReceiveMessage((message) => hear(folder, message));
  try {
    const table = await captured(lfz, ["trace", folder], path.dirname(folder));
    const open = `<button ${says({ perfetto: true })}>Timeline in Perfetto</button>`;
    panel.webview.html = page(WORDS, `${open}<pre>${linked(table)}</pre>`, CLICKS);
  } catch (error) {
    const text = error instanceof Error ? error.message : String(error);
    panel.webview.html = page(WORDS, `<pre>${escaped(text)}</pre>`, "");
  }
}

/** Returns a folder with recordings; undefined when there is none, or nobody chooses. */
async function chooseRecording(): Promise<string | undefined> {
  const folders = [...new Set(filesNamed(/\.lftrace$/).map((file) => path.dirname(file)))].sort();
  if (folders.length === 0) {
    void vscode.window.showInformationMessage(
      "Lingua Franca: nothing is recorded here. Record a run with `lfz run PROGRAM.lf --trace traces`.",
    );
    return undefined;
  }
  if (folders.length === 1) {
    return folders[0];
  }
  const choices = folders.map((folder) => ({ label: vscode.workspace.asRelativePath(folder), folder }));
  return (await vscode.window.showQuickPick(choices, { title: "The recorded run" }))?.folder;
}

/** Returns the table with links at its lines of LF. */
function linked(table: string): string {
  return escaped(table).replace(/\(([^()\s]+\.u?lf):(\d+)\)/g, (whole, file: string, line: string) => {
    return `(<a ${says({ file, line: Number(line) })}>${whole.slice(1, -1)}</a>)`;
  });
}

async function hear(folder: string, message: { perfetto?: boolean; file?: string; line?: number }): Promise<void> {
  if (message.perfetto === true) {
    await vscode.env.openExternal(vscode.Uri.parse(PERFETTO));
    await vscode.commands.executeCommand(
      "revealFileInOS",
      vscode.Uri.file(path.join(folder, "trace.perfetto-trace")),
    );
    return;
  }
  // Recordings name files without their folders.
  const name = path.basename(message.file ?? "");
  const file = filesNamed(/\.u?lf$/).find((one) => path.basename(one) === name);
  if (file !== undefined) {
    const at = new vscode.Position((message.line ?? 1) - 1, 0);
    const viewColumn = vscode.ViewColumn.One;
    await vscode.window.showTextDocument(vscode.Uri.file(file), { selection: new vscode.Range(at, at), viewColumn });
  }
}

/** The maximum depth of recordings and programs in the folders of the workspace. */
const DEPTH = 6;

/** Returns the files of the workspace with such names, but for those that builds make. */
function filesNamed(name: RegExp): string[] {
  const inside = (folder: string, depth: number): string[] =>
    readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
      const at = path.join(folder, entry.name);
      if (entry.isDirectory()) {
        const isMade = entry.name.startsWith(".") || ["build", "target", "node_modules"].includes(entry.name);
        return isMade || depth === 0 ? [] : inside(at, depth - 1);
      }
      return name.test(entry.name) ? [at] : [];
    });
  const folders = vscode.workspace.workspaceFolders ?? [];
  return folders.filter(({ uri }) => uri.scheme === "file").flatMap(({ uri }) => inside(uri.fsPath, DEPTH));
}
