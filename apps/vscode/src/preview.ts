// The pane beside the text: pictures of the system at the cursor, which follow the cursor and the edits.
import { randomBytes } from "node:crypto";
import * as vscode from "vscode";
import type { LanguageClient } from "vscode-languageclient/node";

/** Milliseconds that the text and the cursor rest before pictures are asked for. */
const REST = 150;

const DARK = new Set([vscode.ColorThemeKind.Dark, vscode.ColorThemeKind.HighContrast]);

interface Place {
  start: { line: number; character: number };
  end: { line: number; character: number };
}
type Point = { name: string; value: number }[];

/** The part of an answer to `fuzzyctl/preview` that is read here; see docs/reference/language-server.md. */
interface Answer {
  message: string;
  title: string;
  rule: Place | null;
  region: { rule: Place; text: string; point: Point | null } | null;
}

/** What the pane sends: a point of the inputs, null for none; `select` where the rule there is to be selected. */
interface Asked {
  point: Point | null;
  select: boolean;
  /** Counts what the pane sends: an answer to an older one does not move its sliders. */
  serial: number;
}

export class Preview implements vscode.Disposable {
  private panel: vscode.WebviewPanel | undefined;
  private editor: vscode.TextEditor | undefined;
  private asked: Asked = { point: null, select: false, serial: 0 };
  private region: string | undefined;
  private timer: NodeJS.Timeout | undefined;
  private running = false;
  private again = false;
  private readonly listeners: vscode.Disposable[];

  constructor(
    private readonly folder: vscode.Uri,
    private readonly client: () => LanguageClient | undefined,
  ) {
    this.listeners = [
      vscode.window.onDidChangeActiveTextEditor((editor) => this.follow(editor)),
      vscode.window.onDidChangeTextEditorSelection((e) => this.follow(e.textEditor)),
      vscode.window.onDidChangeActiveColorTheme(() => this.update()),
      vscode.workspace.onDidChangeTextDocument((e) => e.document === this.editor?.document && this.update()),
    ];
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.panel?.dispose();
    this.listeners.forEach((l) => l.dispose());
  }

  /** Show the pane beside the text; where a system is named, with the cursor in it; where a point is given, with its rules. */
  open(system?: string, point?: Record<string, number>): void {
    const editor = vscode.window.activeTextEditor;
    if (editor?.document.languageId === "fz") {
      this.editor = editor;
      if (system) {
        enterSystem(editor, system);
      }
    }
    if (point !== undefined) {
      this.asked.point = Object.entries(point).map(([name, value]) => ({ name, value }));
    }
    if (this.panel !== undefined) {
      this.panel.reveal(undefined, true);
      this.update();
    } else {
      const media = vscode.Uri.joinPath(this.folder, "media");
      this.panel = vscode.window.createWebviewPanel(
        "fuzzyctl.preview",
        "Surface",
        { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true },
        { enableScripts: true, localResourceRoots: [media], retainContextWhenHidden: true },
      );
      this.panel.onDidDispose(() => (this.panel = undefined));
      this.panel.webview.onDidReceiveMessage((asked: Partial<Asked>) => {
        this.asked = { ...this.asked, ...asked };
        void this.draw();
      });
      // It asks for pictures itself, whenever it is loaded.
      this.panel.webview.html = page(this.panel.webview, media);
    }
  }

  /** Ask for the pictures once text and cursor rest. */
  update(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.draw(), REST);
  }

  private follow(editor: vscode.TextEditor | undefined): void {
    if (editor?.document.languageId === "fz") {
      this.editor = editor;
      this.update();
    }
  }

  /** One request at a time: a server that draws is not asked for the pictures of each key. */
  private async draw(): Promise<void> {
    if (this.panel === undefined || this.editor === undefined) {
      return;
    }
    if (this.running) {
      this.again = true;
      return;
    }
    this.running = true;
    do {
      this.again = false;
      await this.request(this.editor);
    } while (this.again);
    this.running = false;
  }

  private async request(editor: vscode.TextEditor): Promise<void> {
    const client = this.client();
    if (client === undefined) {
      this.show({ message: "the language server is not running" });
      return;
    }
    const { point, select, serial } = this.asked;
    this.asked.select = false;
    const version = editor.document.version;
    try {
      const answer = await client.sendRequest<Answer>("fuzzyctl/preview", {
        textDocument: { uri: client.code2ProtocolConverter.asUri(editor.document.uri) },
        position: client.code2ProtocolConverter.asPosition(editor.selection.active),
        point,
        dark: DARK.has(vscode.window.activeColorTheme.kind),
      });
      this.show({ ...answer, serial, pointed: point !== null });
      if (!select) {
        this.enter(answer, point);
      } else if (answer.rule !== null && editor.document.version === version) {
        const { start, end } = answer.rule;
        const range = new vscode.Range(start.line, start.character, end.line, end.character);
        editor.selection = new vscode.Selection(range.start, range.end);
        editor.revealRange(range, vscode.TextEditorRevealType.InCenterIfOutsideViewport);
      }
    } catch (error) {
      this.show({ message: error instanceof Error ? error.message : String(error) });
    }
  }

  /** Move the point, unless it has moved since, into the region of the cell that the cursor has come into. */
  private enter({ region, rule }: Answer, point: Point | null): void {
    const inside = JSON.stringify(region?.rule) === JSON.stringify(rule);
    const same = point !== null && this.asked.point === point;
    if (region?.point && region.text !== this.region && same && !inside) {
      this.asked.point = region.point;
      this.again = true;
    }
    this.region = region?.text;
  }

  private show(answer: Partial<Answer> & { serial?: number; pointed?: boolean }): void {
    if (this.panel !== undefined) {
      if (answer.title) {
        this.panel.title = answer.title;
      }
      void this.panel.webview.postMessage(answer);
    }
  }
}

/** Put the cursor at the head of a system, unless it is in that system. */
function enterSystem(editor: vscode.TextEditor, name: string): void {
  const cursor = editor.document.offsetAt(editor.selection.active);
  const heads = [...editor.document.getText().matchAll(/^[ \t]*(system|controller|plant|loop)[ \t]+(\S+)/gm)];
  const around = heads.filter(({ index }) => index <= cursor).at(-1);
  const head = heads.find(([, kind, written]) => kind === "system" && written === name);
  if (head !== undefined && around?.[2] !== name) {
    const place = editor.document.positionAt(head.index);
    editor.selection = new vscode.Selection(place, place);
  }
}

function page(webview: vscode.Webview, media: vscode.Uri): string {
  const nonce = randomBytes(16).toString("hex");
  const file = (name: string) => webview.asWebviewUri(vscode.Uri.joinPath(media, name)).toString();
  // Pictures are images, in which no script runs, whatever the labels of the text are.
  const policy = `default-src 'none'; img-src blob:; style-src ${webview.cspSource}; script-src 'nonce-${nonce}'`;
  return `<!DOCTYPE html>
<html lang="en">
<head>
  <meta charset="utf-8">
  <meta http-equiv="Content-Security-Policy" content="${policy}">
  <link rel="stylesheet" href="${file("preview.css")}">
</head>
<body>
  <p id="message" role="status">The pictures are being drawn.</p>
  <main id="pictures">
    <div id="map"><img id="surface" alt="" hidden><span id="mark" hidden></span></div>
    <label id="choice"><input type="checkbox" id="with-point"> Rules at a point (a click into the map is one)</label>
    <div id="inputs" hidden></div>
    <div id="wide"><img id="rules" class="lines" alt="" hidden></div>
    <img id="terms" class="lines" alt="Terms of the variables" hidden>
  </main>
  <script nonce="${nonce}" src="${file("preview.js")}"></script>
</body>
</html>`;
}
