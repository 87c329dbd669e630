// SPDX-License-Identifier: Apache-2.0
// Pages in views of the editor: what `lfz` prints, in the colours of the editor.

/** Returns a text as a page shows it. */
export function escaped(text: string): string {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/"/g, "&quot;");
}

/** Returns a page, of which no other page's script runs. */
export function page(style: string, body: string, script: string): string {
  const nonce = Array.from({ length: 4 }, () => Math.random().toString(36).slice(2)).join("");
  const policy = `default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'nonce-${nonce}'`;
  return `<!DOCTYPE html>
<html><head><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="${policy}">
<style>${style}</style></head>
<body>${body}<script nonce="${nonce}">${script}</script></body></html>`;
}

/** The style of pages that consist of words. */
export const WORDS = `
  body { font-family: var(--vscode-font-family); color: var(--vscode-foreground); padding: 12px; }
  h2 { font-size: 1.1em; margin: 1em 0 0.4em; }
  pre, code { font-family: var(--vscode-editor-font-family); font-size: var(--vscode-editor-font-size); }
  pre { overflow: auto; }
  a { color: var(--vscode-textLink-foreground); cursor: pointer; }
  table { border-collapse: collapse; }
  td { padding: 3px 16px 3px 0; }
  button {
    color: var(--vscode-button-foreground); background: var(--vscode-button-background);
    border: none; border-radius: 2px; padding: 3px 10px; margin-right: 6px; cursor: pointer;
  }
  .runs { color: var(--vscode-testing-iconPassed); }
  .off { color: var(--vscode-descriptionForeground); }
`;

/** A script by which elements with \`data-say\` send that to the extension when they are clicked. */
export const CLICKS = `
  const editor = acquireVsCodeApi();
  addEventListener("click", (event) => {
    const found = event.target.closest("[data-say]");
    if (found) {
      editor.postMessage(JSON.parse(found.dataset.say));
    }
  });
`;

/** Returns the attribute of an element that says something when it is clicked. */
export function says(message: unknown): string {
  return `data-say="${escaped(JSON.stringify(message))}"`;
}
