// SPDX-License-Identifier: Apache-2.0
// The graph of a program beside its text: the SVG that `lfz graph` prints.

import * as path from "node:path";
import * as vscode from "vscode";
import { captured, findLfz, folderOf, programFile } from "./lfz";
import { escaped, page } from "./page";

/** The open graphs, by the paths of their programs. */
const graphs = new Map<string, vscode.WebviewPanel>();

export function registerGraph(context: vscode.ExtensionContext): void {
  context.subscriptions.push(
    vscode.commands.registerCommand("lfz.showGraph", (file) => showGraph(file)),
    // A file may be imported by the program of any graph.
    vscode.workspace.onDidSaveTextDocument(async (document) => {
      if (document.languageId === "lf") {
        await Promise.all([...graphs].map(([file, panel]) => draw(vscode.Uri.file(file), panel)));
      }
    }),
  );
}

async function showGraph(given: unknown): Promise<void> {
  const file = await programFile(given);
  if (file === undefined) {
    return;
  }
  let panel = graphs.get(file.fsPath);
  if (panel === undefined) {
    const column = { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true };
    const title = `Graph of ${path.basename(file.fsPath)}`;
    panel = vscode.window.createWebviewPanel("lfz.graph", title, column, { enableScripts: true });
    graphs.set(file.fsPath, panel);
    panel.onDidDispose(() => graphs.delete(file.fsPath));
  } else {
    panel.reveal(undefined, true);
  }
  await draw(file, panel);
}

async function draw(file: vscode.Uri, panel: vscode.WebviewPanel): Promise<void> {
  const lfz = findLfz();
  if (lfz === undefined) {
    return;
  }
  try {
    panel.webview.html = pictured(await captured(lfz, ["graph", file.fsPath], folderOf(file)));
  } catch (error) {
    const text = error instanceof Error ? error.message : String(error);
    panel.webview.html = pictured(`<pre>${escaped(text)}</pre>`);
  }
}

const STYLE = `
  body { margin: 0; height: 100vh; overflow: auto; background: #fff; color: #000; }
  #graph { transform-origin: 0 0; width: max-content; padding: 8px; }
  #graph svg { display: block; }
  pre { white-space: pre-wrap; font-family: monospace; }
`;

const ZOOM = `
  const graph = document.getElementById("graph");
  const picture = graph.querySelector("svg");
  let scale = picture ? Math.min(1, (innerWidth - 24) / picture.getBoundingClientRect().width) : 1;
  const show = () => { graph.style.transform = "scale(" + scale + ")"; };
  show();
  addEventListener("wheel", (event) => {
    if (event.ctrlKey) {
      event.preventDefault();
      scale = Math.min(8, Math.max(0.05, scale * (event.deltaY < 0 ? 1.15 : 1 / 1.15)));
      show();
    }
  }, { passive: false });
  addEventListener("mousemove", (event) => {
    if (event.buttons === 1) {
      document.body.scrollBy(-event.movementX, -event.movementY);
      scrollBy(-event.movementX, -event.movementY);
    }
  });
`;

/** Returns a page with a picture that the wheel zooms with Ctrl, and the mouse moves. */
function pictured(content: string): string {
  return page(STYLE, `<div id="graph">${content.replace(/^\s*<\?xml[^>]*\?>/, "")}</div>`, ZOOM);
}
