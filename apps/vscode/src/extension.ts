// Starts the language server and the preview.
import * as vscode from "vscode";
import { LanguageClient, RevealOutputChannelOn, State } from "vscode-languageclient/node";
import { Preview } from "./preview";
import { findPython, Search, serverArguments } from "./python";

let client: LanguageClient | undefined;
let log: vscode.LogOutputChannel;
let preview: Preview;
/** Starts and stops follow each other: two at once would leave a server behind. */
let turn: Promise<void> = Promise.resolve();

export function activate(context: vscode.ExtensionContext): void {
  log = vscode.window.createOutputChannel("fuzzyctl", { log: true });
  preview = new Preview(context.extensionUri, () => (client?.state === State.Running ? client : undefined));
  context.subscriptions.push(
    log,
    preview,
    vscode.commands.registerCommand("fuzzyctl.restart", restart),
    vscode.commands.registerCommand("fuzzyctl.log", () => log.show()),
    vscode.commands.registerCommand("fuzzyctl.preview", () => preview.open()),
    vscode.workspace.onDidGrantWorkspaceTrust(restart),
    vscode.workspace.onDidChangeConfiguration((e) => {
      if (e.affectsConfiguration("fuzzyctl.python")) {
        void restart();
      }
    }),
  );
  void restart();
}

export function deactivate(): Promise<void> {
  turn = turn.then(stop);
  return turn;
}

function restart(): Promise<void> {
  turn = turn.then(stop).then(start).catch((error: unknown) => {
    log.error(String(error));
    void failed(`The language server of fuzzyctl did not start: ${error instanceof Error ? error.message : error}`);
  });
  return turn;
}

async function stop(): Promise<void> {
  const running = client;
  client = undefined;
  // A server that is starting or has ended cannot be stopped; the client says so by an error.
  await running?.dispose().catch((error: unknown) => log.warn(String(error)));
}

async function start(): Promise<void> {
  const search = await findPython();
  for (const { python, lack } of search.tried) {
    log.info(`${python} ${lack}`);
  }
  if (search.python === undefined) {
    void missing(search);
    return;
  }
  log.info(`${search.python} ${serverArguments().join(" ")}`);
  client = new LanguageClient(
    "fuzzyctl",
    "fuzzyctl",
    { command: search.python, args: serverArguments() },
    {
      documentSelector: [
        { language: "fz", scheme: "file" },
        { language: "fz", scheme: "untitled" },
      ],
      outputChannel: log,
      // A key during a restart is an error of the client's that no user can do anything about.
      revealOutputChannelOn: RevealOutputChannelOn.Never,
      middleware: {
        // The server's own answer to "surface" is a file; here the pane shows it.
        executeCommand: (command, words, next) =>
          command === "fuzzyctl.surface" ? preview.open(words[1] as string | undefined) : next(command, words),
      },
    },
  );
  client.onDidChangeState(({ newState }) => newState === State.Running && preview.update());
  await client.start();
}

async function missing(search: Search): Promise<void> {
  const tried = search.tried.map(({ python, lack }) => `'${python}' ${lack}`).join("; ");
  const set = "Set the Python";
  const copy = "Copy the pip command";
  const again = "Try again";
  const text = `No Python with fuzzyctl: ${tried}. Without it there are colours only.`;
  const chosen = await vscode.window.showErrorMessage(text, set, copy, again);
  if (chosen === set) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "fuzzyctl.python");
  } else if (chosen === copy) {
    const present = search.tried.find(({ lack }) => lack.startsWith("has no"))?.python ?? "python3";
    await vscode.env.clipboard.writeText(`"${present}" -m pip install "fuzzyctl[lsp]"`);
  } else if (chosen === again) {
    await restart();
  }
}

async function failed(text: string): Promise<void> {
  const show = "Show the log";
  if ((await vscode.window.showErrorMessage(text, show)) === show) {
    log.show();
  }
}
