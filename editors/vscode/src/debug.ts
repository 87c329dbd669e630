// SPDX-License-Identifier: Apache-2.0
// Debug configurations: a program or a federate that `lfz` builds, under an adapter that the computer has.

import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import * as path from "node:path";
import * as vscode from "vscode";
import { captured, findLfz, findProgram, folderOf, programFile, setting } from "./lfz";

/** The versions that distributions have in names of programs, the latest first. */
const VERSIONS = Array.from({ length: 12 }, (_, index) => 25 - index);

/** The debug adapters that are looked for; before version 18 that of LLDB had another name. */
const ADAPTERS = [
  "lldb-dap",
  ...VERSIONS.map((version) => (version < 18 ? `lldb-vscode-${version}` : `lldb-dap-${version}`)),
  "gdb",
];

/** The least version of gdb that is a debug adapter. */
const GDB_VERSION = 14;

export function registerDebugging(context: vscode.ExtensionContext): void {
  context.subscriptions.push(
    vscode.commands.registerCommand("lfz.debug", (file) => debug(file)),
    vscode.debug.registerDebugConfigurationProvider("lfz", new Configurations()),
    vscode.debug.registerDebugAdapterDescriptorFactory("lfz", { createDebugAdapterDescriptor: () => adapter() }),
    vscode.debug.onDidTerminateDebugSession((session) => {
      if (session.type === "lfz") {
        others.forEach((federation) => federation.kill("SIGINT"));
      }
    }),
  );
}

async function debug(given: unknown): Promise<void> {
  const file = await programFile(given);
  if (file !== undefined) {
    await vscode.debug.startDebugging(vscode.workspace.getWorkspaceFolder(file), configurationOf(file));
  }
}

function configurationOf(file: vscode.Uri): vscode.DebugConfiguration {
  return { type: "lfz", request: "launch", name: `Debug ${path.basename(file.fsPath)}`, program: file.fsPath };
}

class Configurations implements vscode.DebugConfigurationProvider {
  /** Fills in the file of the editor where nothing is configured. */
  async resolveDebugConfiguration(
    _folder: vscode.WorkspaceFolder | undefined,
    configuration: vscode.DebugConfiguration,
  ): Promise<vscode.DebugConfiguration | undefined> {
    if (configuration.type) {
      return configuration;
    }
    const file = await programFile(undefined);
    return file && configurationOf(file);
  }

  /** Builds the program, and puts the executable in the place of the LF file. */
  async resolveDebugConfigurationWithSubstitutedVariables(
    _folder: vscode.WorkspaceFolder | undefined,
    configuration: vscode.DebugConfiguration,
  ): Promise<vscode.DebugConfiguration | undefined> {
    const lfz = findLfz();
    const file = vscode.Uri.file(String(configuration["program"] ?? ""));
    if (lfz === undefined) {
      return undefined;
    }
    const cwd = String(configuration["cwd"] ?? folderOf(file));
    try {
      const federate = await federateOf(lfz, file, cwd, configuration["federate"]);
      if (federate === undefined) {
        return undefined;
      }
      const title = `Building ${path.basename(file.fsPath)}`;
      const location = vscode.ProgressLocation.Notification;
      const built = await vscode.window.withProgress({ location, title }, async () => {
        const program = await build(lfz, file, cwd, federate);
        return { program, args: federate === "" ? [] : await startOthers(lfz, file, cwd, federate) };
      });
      const own = Array.isArray(configuration["args"]) ? (configuration["args"] as string[]) : [];
      // gdb has another word for it.
      const stopAtBeginningOfMainSubprogram = configuration["stopOnEntry"] === true;
      const args = [...built.args, ...own];
      return { ...configuration, program: built.program, args, cwd, stopAtBeginningOfMainSubprogram };
    } catch (error) {
      const text = error instanceof Error ? error.message : String(error);
      await vscode.window.showErrorMessage(`Lingua Franca: ${text}`, { modal: true });
      return undefined;
    }
  }
}

/** Builds a federate, or a program that is not federated, for this computer; returns the executable. */
async function build(lfz: string, file: vscode.Uri, cwd: string, federate: string): Promise<string> {
  const only = federate === "" ? [] : ["--federate", federate];
  const printed = await captured(lfz, ["build", file.fsPath, "--platform", "host", "--json", ...only], cwd);
  const { participants } = JSON.parse(printed) as { participants: { program?: string | null }[] };
  const program = participants.map((one) => one.program).find((one) => typeof one === "string");
  if (typeof program !== "string") {
    throw new Error("lfz has built no program for this computer");
  }
  return program;
}

/** The federations whose other federates run beside the debugger. */
const others = new Set<ChildProcess>();

/** Runs a federation without a federate; returns the arguments with which that one takes part. */
function startOthers(lfz: string, file: vscode.Uri, cwd: string, federate: string): Promise<string[]> {
  const output = vscode.window.createOutputChannel(`Federation ${path.basename(file.fsPath)}`);
  output.show(true);
  const child = spawn(lfz, ["run", file.fsPath, "--without", federate], { cwd });
  others.add(child);
  return new Promise((resolve, reject) => {
    let said = "";
    const hear = (piece: Buffer): void => {
      output.append(piece.toString());
      said += piece.toString();
      const found = /takes part when you start it: (.*)\n/.exec(said);
      if (found?.[1] !== undefined) {
        said = "";
        resolve(words(found[1]).slice(1));
      }
    };
    child.stdout.on("data", hear);
    child.stderr.on("data", hear);
    child.on("error", reject);
    child.on("close", (status) => {
      others.delete(child);
      reject(new Error(`the other federates have ended with status ${status}: see the output`));
    });
  });
}

/** Returns the words of a line as a shell splits them, which has single quotes only. */
function words(line: string): string[] {
  const found = line.match(/(?:'[^']*'|\\.|[^\s'\\])+/g) ?? [];
  return found.map((word) => word.replace(/'([^']*)'|\\(.)/g, (_, quoted, escaped) => quoted ?? escaped));
}

/** Returns the federate to debug, nothing for a program that is not federated, and undefined when nobody chooses. */
async function federateOf(lfz: string, file: vscode.Uri, cwd: string, given: unknown): Promise<string | undefined> {
  if (typeof given === "string") {
    return given;
  }
  const plan = JSON.parse(await captured(lfz, ["plan", file.fsPath, "--json"], cwd)) as {
    rti: unknown;
    federates: { name: string }[];
  };
  if (plan.rti === null) {
    return "";
  }
  const names = plan.federates.map((federate) => federate.name);
  return await vscode.window.showQuickPick(names, { title: "The federate to debug" });
}

/** Returns the first debug adapter that this computer has. */
function adapter(): vscode.DebugAdapterDescriptor {
  const wanted = setting("debugAdapter");
  const names = wanted === "" ? ADAPTERS : [wanted];
  for (const name of names) {
    const program = findProgram(name);
    if (program === undefined) {
      continue;
    }
    if (!path.basename(name).includes("gdb")) {
      return new vscode.DebugAdapterExecutable(program, []);
    }
    if (gdbVersion(program) >= GDB_VERSION) {
      return new vscode.DebugAdapterExecutable(program, ["--quiet", "--interpreter=dap"]);
    }
  }
  const known = wanted === "" ? "lldb-dap and gdb of version 14 or later" : wanted;
  throw new Error(`there is no debug adapter in PATH (${known}): install one, or name it in lfz.debugAdapter`);
}

function gdbVersion(program: string): number {
  try {
    return Number(/(\d+)\.\d+/.exec(execFileSync(program, ["--version"], { encoding: "utf8" }))?.[1] ?? 0);
  } catch {
    return 0;
  }
}
