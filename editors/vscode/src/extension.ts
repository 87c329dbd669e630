// SPDX-License-Identifier: Apache-2.0
// The extension: a client of `lfz lsp`, and commands that run `lfz`.

import * as vscode from "vscode";
import { registerDebugging } from "./debug";
import { registerFederations } from "./federations";
import { registerGraph } from "./graph";
import { registerPrograms } from "./programs";
import { Server } from "./server";
import { registerTrace } from "./trace";

let server: Server | undefined;

/** Starts the language server, and registers the commands. */
export async function activate(context: vscode.ExtensionContext): Promise<void> {
  server = new Server(context);
  registerPrograms(context);
  registerGraph(context);
  registerTrace(context);
  registerFederations(context);
  registerDebugging(context);
  await server.start();
}

/** Ends the language server. */
export async function deactivate(): Promise<void> {
  await server?.stop();
}
