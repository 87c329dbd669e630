// SPDX-License-Identifier: Apache-2.0
// The language server `lfz lsp`.

import * as vscode from "vscode";
import { LanguageClient, type ClientCapabilities, type StaticFeature } from "vscode-languageclient/node";
import { findLfz } from "./lfz";

/** The commands that code lenses may have. */
const COMMANDS = ["lfz.run", "lfz.runFederation", "lfz.debug", "lfz.buildForBoard", "lfz.showGraph"];

/** Tells the server that this editor has commands, in the way of rust-analyzer's clients. */
const commands: StaticFeature = {
  fillClientCapabilities(capabilities: ClientCapabilities): void {
    capabilities.experimental = { ...capabilities.experimental, commands: { commands: COMMANDS } };
  },
  initialize(): void {},
  getState: () => ({ kind: "static" }),
  clear(): void {},
};

/** The language server, which starts again when its path changes. */
export class Server {
  private client: LanguageClient | undefined;
  private readonly output = vscode.window.createOutputChannel("Lingua Franca");

  constructor(context: vscode.ExtensionContext) {
    context.subscriptions.push(
      this.output,
      vscode.commands.registerCommand("lfz.restartServer", () => this.restart()),
      vscode.workspace.onDidChangeConfiguration((event) => {
        if (event.affectsConfiguration("lfz.path")) {
          void this.restart();
        }
      }),
    );
  }

  async start(): Promise<void> {
    const lfz = findLfz();
    if (lfz === undefined) {
      return;
    }
    const client = new LanguageClient(
      "lfz",
      "Lingua Franca",
      { command: lfz, args: ["lsp"] },
      { documentSelector: [{ language: "lf" }], outputChannel: this.output },
    );
    client.registerFeature(commands);
    this.client = client;
    try {
      await client.start();
    } catch (error) {
      const text = error instanceof Error ? error.message : String(error);
      void vscode.window.showErrorMessage(`Lingua Franca: \`${lfz} lsp\` does not start: ${text}`);
    }
  }

  async stop(): Promise<void> {
    const client = this.client;
    this.client = undefined;
    if (client?.needsStop()) {
      await client.stop();
    }
  }

  private async restart(): Promise<void> {
    await this.stop();
    await this.start();
  }
}
