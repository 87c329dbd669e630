// SPDX-License-Identifier: Apache-2.0
// Runs Neovim with the lines of the guide: it shows the server's diagnostics, and gets an answer, and its colours are
// those of the grammar in `editors/tree-sitter-lf`.

import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

const repository = path.join(path.dirname(fileURLToPath(import.meta.url)), "../../..");
const lfz = path.resolve(process.env.LFZ ?? path.join(repository, "target/debug/lfz"));
const grammar = path.resolve(process.env.TREE_SITTER_LF ?? path.join(repository, "target/debug/tree-sitter-lf"));
const guide = readFileSync(path.join(repository, "docs/guide/src/editors.md"), "utf8");
const configuration = /```lua\n([^]*?)```/.exec(guide)?.[1];
assert.ok(configuration, "the guide has no lines for Neovim");

/** The features of later versions: Debian's is older than the guide asks for. */
const OLDER = `
vim.g.do_filetype_lua = 1
if not vim.lsp.start then
  vim.lsp.start = function(config)
    vim.lsp.buf_attach_client(0, vim.lsp.start_client(config))
  end
  vim.fs = { dirname = function(file) return vim.fn.fnamemodify(file, ":h") end }
end
if not vim.treesitter.start then
  vim.treesitter.start = function(buffer, language)
    vim.treesitter.require_language(language)
    vim.treesitter.highlighter.new(vim.treesitter.get_parser(buffer, language))
  end
end
`;
const QUESTIONS = `
vim.wait(60000, function() return #vim.diagnostic.get(0) > 0 end, 20)
for _, one in ipairs(vim.diagnostic.get(0)) do io.stdout:write(one.message .. "\\n") end
vim.api.nvim_win_set_cursor(0, { 3, 10 })
local asked = vim.lsp.util.make_position_params(0, "utf-16")
for _, one in pairs(vim.lsp.buf_request_sync(0, "textDocument/hover", asked, 60000) or {}) do
  io.stdout:write(one.result.contents.value .. "\\n")
end
io.stdout:write(vim.treesitter.highlighter.active[vim.api.nvim_get_current_buf()] and "coloured\\n" or "colourless\\n")
local root = vim.treesitter.get_parser(0, "lf"):parse()[1]:root()
local get = vim.treesitter.query.get or vim.treesitter.query.get_query
local query = get("lf", "highlights")
for at, node in query:iter_captures(root, 0, 2, 3) do
  local row, from, _, to = node:range()
  local line = vim.api.nvim_buf_get_lines(0, row, row + 1, true)[1]
  io.stdout:write(query.captures[at] .. ": " .. line:sub(from + 1, to) .. "\\n")
end
vim.cmd("qall!")
`;

const folder = mkdtempSync(path.join(tmpdir(), "lf-neovim-"));
try {
  writeFileSync(path.join(folder, "init.lua"), OLDER + configuration);
  writeFileSync(path.join(folder, "questions.lua"), QUESTIONS);
  const wrong = "target Rust { timout: 1 s }\nmain reactor {\n  timer tick(0, 10 ms)\n}\n";
  writeFileSync(path.join(folder, "Wrong.lf"), wrong);
  symlinkSync(lfz, path.join(folder, "lfz"));
  const words = ["--headless", "-u", "init.lua", "Wrong.lf", "-c", "luafile questions.lua"];
  const env = { ...process.env, HOME: folder, PATH: `${folder}:${process.env.PATH}` };
  delete env.XDG_CONFIG_HOME;
  execFileSync(grammar, ["neovim"], { env });
  const { stdout, stderr, error } = spawnSync("nvim", words, { cwd: folder, env, encoding: "utf8", timeout: 120_000 });
  assert.ok(error === undefined, String(error));
  assert.match(stdout, /did you mean `timeout`\?/, stderr);
  assert.match(stdout, /timer tick/, stderr);
  for (const seen of ["coloured", "keyword.storage.type: timer", "constant.numeric.integer: 10", "keyword: ms"]) {
    assert.ok(stdout.split(/\r?\n/).includes(seen), `${seen} is not in:\n${stdout}${stderr}`);
  }
  console.log("Neovim shows diagnostics, asks and has colours");
} finally {
  rmSync(folder, { recursive: true, force: true });
}
