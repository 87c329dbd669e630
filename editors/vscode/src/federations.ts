// SPDX-License-Identifier: Apache-2.0
// The federations that run on this computer: what `lfz ctl` prints, with its commands as buttons.

import * as vscode from "vscode";
import { captured, findLfz } from "./lfz";
import { CLICKS, escaped, page, says, WORDS } from "./page";

/** The time between two questions of a visible view, in milliseconds. */
const PERIOD = 1000;

let panel: vscode.WebviewPanel | undefined;
/** The content of the view, so that it is drawn only after a change. */
let shown = "";

export function registerFederations(context: vscode.ExtensionContext): void {
  context.subscriptions.push(vscode.commands.registerCommand("lfz.showFederations", () => show()));
}

function show(): void {
  if (panel !== undefined) {
    panel.reveal(undefined, true);
    return;
  }
  const column = { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true };
  const own = vscode.window.createWebviewPanel("lfz.federations", "Federations", column, { enableScripts: true });
  panel = own;
  shown = "";
  own.webview.onDidReceiveMessage((words: string[]) => command(words));
  const timer = setInterval(() => void (own.visible && draw()), PERIOD);
  own.onDidDispose(() => {
    clearInterval(timer);
    panel = undefined;
  });
  void draw();
}

/** Runs a command of `lfz ctl`, and shows its error. */
async function command(words: string[]): Promise<void> {
  const lfz = findLfz();
  if (lfz === undefined) {
    return;
  }
  try {
    await captured(lfz, ["ctl", ...words], ".");
  } catch (error) {
    void vscode.window.showErrorMessage(`Lingua Franca: ${error instanceof Error ? error.message : String(error)}`);
  }
  await draw();
}

async function draw(): Promise<void> {
  const lfz = findLfz();
  if (lfz === undefined) {
    return;
  }
  let body: string;
  try {
    body = runs(await captured(lfz, ["ctl"], "."));
  } catch (error) {
    body = `<pre>${escaped(error instanceof Error ? error.message : String(error))}</pre>`;
  }
  if (panel !== undefined && body !== shown) {
    shown = body;
    panel.webview.html = page(WORDS, body, CLICKS);
  }
}

/** Returns a table of the runs that `lfz ctl` lists, each with its federates. */
function runs(printed: string): string {
  let rows = "";
  let run = "";
  for (const line of printed.split("\n")) {
    run = /^run (\d+)$/.exec(line)?.[1] ?? run;
    const federate = /^ {2}(\S+): (runs|does not run|is being swapped)(, transient)?$/.exec(line);
    if (federate === null) {
      rows += line === "" ? "" : `<tr><td colspan="4"><h2>${escaped(line)}</h2></td></tr>`;
      continue;
    }
    const [, name = "", state = "", transient] = federate;
    const verbs = state === "does not run" ? ["start"] : transient === undefined ? [] : ["stop", "swap"];
    const buttons = verbs.map((verb) => {
      const title = verb[0]?.toUpperCase() + verb.slice(1);
      return `<button ${says([verb, name, "--run", run])} title="lfz ctl ${verb} ${escaped(name)}">${title}</button>`;
    });
    const kind = transient === undefined ? "" : "transient";
    const colour = state === "does not run" ? "off" : "runs";
    rows += `<tr><td>${escaped(name)}</td><td class="${colour}">${state}</td><td>${kind}</td>`;
    rows += `<td>${buttons.join("")}</td></tr>`;
  }
  return rows === "" ? "<p>No federation of yours runs on this computer.</p>" : `<table>${rows}</table>`;
}
