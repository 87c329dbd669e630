// SPDX-License-Identifier: Apache-2.0
// The program `lfz`: where it is, and what it prints.

import { execFile } from "node:child_process";
import { accessSync, constants, statSync } from "node:fs";
import { homedir } from "node:os";
import * as path from "node:path";
import * as vscode from "vscode";

const INSTALLATION = "https://github.com/lf-zephyr-rs/lf-zephyr-rs#try-it";

/** Returns a setting of this extension. */
export function setting(name: string): string {
  return vscode.workspace.getConfiguration("lfz").get<string>(name, "").trim();
}

/** Returns the path of a program: a path itself, or a name in `PATH`. */
export function findProgram(name: string): string | undefined {
  const expanded = name.startsWith("~/") ? path.join(homedir(), name.slice(2)) : name;
  const folders = expanded.includes(path.sep) ? [""] : (process.env["PATH"] ?? "").split(path.delimiter);
  // A desktop may not know the shell's PATH, so the folder of `cargo install` is searched, too.
  folders.push(path.join(homedir(), ".cargo", "bin"), path.join(homedir(), ".local", "bin"));
  return folders.map((folder) => path.join(folder, expanded)).find(isExecutable);
}

function isExecutable(file: string): boolean {
  try {
    accessSync(file, constants.X_OK);
    return statSync(file).isFile();
  } catch {
    return false;
  }
}

/** Returns the path of `lfz`; where there is none, says so, and what to do. */
export function findLfz(): string | undefined {
  const name = setting("path") || "lfz";
  const found = findProgram(name);
  if (found === undefined) {
    void sayMissing(name);
  }
  return found;
}

async function sayMissing(name: string): Promise<void> {
  const where = name.includes(path.sep) ? `there is no program ${name}` : `there is no program \`${name}\` in PATH`;
  const message = `Lingua Franca: ${where}. Install lfz, or name it in the setting lfz.path.`;
  const choice = await vscode.window.showErrorMessage(message, "Open Setting", "How to Install");
  if (choice === "Open Setting") {
    await vscode.commands.executeCommand("workbench.action.openSettings", "lfz.path");
  } else if (choice === "How to Install") {
    await vscode.env.openExternal(vscode.Uri.parse(INSTALLATION));
  }
}

/** Runs `lfz`, and returns its standard output; an error has what it said. */
export function captured(lfz: string, words: string[], cwd: string): Promise<string> {
  return new Promise((resolve, reject) => {
    execFile(lfz, words, { cwd, maxBuffer: 64 * 1024 * 1024 }, (error, output, complaint) => {
      if (error === null) {
        resolve(output);
      } else {
        reject(new Error(complaint.trim() || error.message));
      }
    });
  });
}

/** Returns the LF file that a command is about: its argument, or the one in the editor. It is saved before. */
export async function programFile(given: unknown): Promise<vscode.Uri | undefined> {
  const document = vscode.window.activeTextEditor?.document;
  let uri = document?.languageId === "lf" ? document.uri : undefined;
  if (typeof given === "string") {
    uri = vscode.Uri.file(given);
  } else if (given instanceof vscode.Uri) {
    uri = given;
  }
  if (uri?.scheme !== "file") {
    void vscode.window.showErrorMessage("Lingua Franca: open a saved LF file first.");
    return undefined;
  }
  const open = vscode.workspace.textDocuments.filter((one) => one.languageId === "lf" && one.isDirty);
  for (const one of open) {
    await one.save();
  }
  return uri;
}

/** Returns the folder in which commands about a file run. */
export function folderOf(file: vscode.Uri): string {
  return vscode.workspace.getWorkspaceFolder(file)?.uri.fsPath ?? path.dirname(file.fsPath);
}
