// Starts the language server and the preview.
import * as vscode from "vscode";
import { ExecuteCommandSignature, LanguageClient, RevealOutputChannelOn, State } from "vscode-languageclient/node";
import snippets from "../snippets.json";
import { Preview } from "./preview";
import { findPython, Search, serverArguments } from "./python";

let client: LanguageClient | undefined;
let log: vscode.LogOutputChannel;
/** What commands of the server's printed, by the path of the text that shows it. */
const printed = new Map<string, string>();
const printedAgain = new vscode.EventEmitter<vscode.Uri>();
let preview: Preview;
/** Starts and stops follow each other: two at once would leave a server behind. */
let turn: Promise<void> = Promise.resolve();

export function activate(context: vscode.ExtensionContext): void {
  log = vscode.window.createOutputChannel("fuzzyctl", { log: true });
  preview = new Preview(context.extensionUri, () => (client?.state === State.Running ? client : undefined));
  context.subscriptions.push(
    log,
    preview,
    printedAgain,
    vscode.workspace.registerTextDocumentContentProvider("fuzzyctl", {
      onDidChange: printedAgain.event,
      provideTextDocumentContent: ({ path }) => printed.get(path) ?? "",
    }),
    vscode.languages.registerCompletionItemProvider("fz", { provideCompletionItems: snippetsAt }),
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

/** Snippets are lines, so they are offered for the first word of a line, and not inside a rule. */
function snippetsAt(document: vscode.TextDocument, position: vscode.Position): vscode.CompletionItem[] {
  if (!/^\w*$/.test(document.lineAt(position).text.slice(0, position.character))) {
    return [];
  }
  return Object.entries(snippets).map(([name, { prefix, description, body }]) => {
    const item = new vscode.CompletionItem({ label: prefix, description: name }, vscode.CompletionItemKind.Snippet);
    item.insertText = new vscode.SnippetString(body.join("\n"));
    item.documentation = description;
    return item;
  });
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
      middleware: { executeCommand: run },
    },
  );
  client.onDidChangeState(({ newState }) => newState === State.Running && preview.update());
  await client.start();
}

/** Run a command of the server's; what it shows by messages and files of its own is shown beside the text here. */
async function run(command: string, words: unknown[], next: ExecuteCommandSignature): Promise<unknown> {
  const [uri, block, point] = words as [string, string?, Record<string, number>?];
  if (command === "fuzzyctl.surface") {
    return preview.open(block);
  }
  if (command === "fuzzyctl.why") {
    return preview.open(block, point);
  }
  const answer = await vscode.window.withProgress(
    { location: vscode.ProgressLocation.Window, title: command.replace(".", " ") },
    async () => (await next(command, [uri, block, point, true])) as { text: string },
  );
  const shown = vscode.Uri.from({ scheme: "fuzzyctl", path: `/${command.replace("fuzzyctl.", "")} ${block}` });
  printed.set(shown.path, answer.text.replaceAll("<stdin>", vscode.workspace.asRelativePath(vscode.Uri.parse(uri))));
  printedAgain.fire(shown);
  await vscode.window.showTextDocument(shown, { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true });
  return answer;
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
