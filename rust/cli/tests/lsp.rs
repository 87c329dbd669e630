// SPDX-License-Identifier: Apache-2.0
//! The language server, asked as editors do: over the standard input and output of the program.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

const LIBRARY: &str =
    "target Rust\n// Counts.\nreactor Counter(start: u32 = 0) {\n  // How many.\n  output count: u32\n}\n";
const MAIN: &str = "target Rust
import Counter from \"lib.lf\"
reactor Show {
  input x: u32
  state greeting: {= &'static str =} = {= \"ü\" =} /* 𝄞 */ state last: u32 = 0
  reaction(x) {= =}
}
main reactor {
  counter = new Counter(start = 2)
  show = new Show()
  counter.count -> show.x
}
";

/// An editor, and the server that it has started.
pub(crate) struct Editor {
    server: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    folder: tempfile::TempDir,
    asked: u64,
    /// The methods by which the server has told something.
    pub(crate) heard: Vec<String>,
}

impl Editor {
    /// Returns an editor in a folder, whose name needs escapes in a URI, with the files of the tests.
    /// No tool for bodies is there: what they say differs from computer to computer.
    pub(crate) fn start() -> Self {
        Self::start_with_tools(OsStr::new("/nowhere"))
    }

    /// Returns such an editor with tools in these folders.
    pub(crate) fn start_with_tools(path: &OsStr) -> Self {
        let folder = tempfile::Builder::new().prefix("a b%ü").tempdir().expect("a temporary folder");
        fs::write(folder.path().join("lib.lf"), LIBRARY).expect("it can be written");
        fs::write(folder.path().join("Main.lf"), "target Rust // older\n").expect("it can be written");
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.arg("lsp").env("PATH", path).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut server = command.spawn().expect("lfz can be started");
        let (input, output) = (server.stdin.take().unwrap(), BufReader::new(server.stdout.take().unwrap()));
        let mut editor = Self { server, input, output, folder, asked: 0, heard: Vec::new() };
        let commands = ["lfz.run", "lfz.runFederation", "lfz.debug", "lfz.buildForBoard", "lfz.showGraph"];
        let capabilities = json!({ "experimental": { "commands": { "commands": commands } } });
        let initialized =
            editor.ask("initialize", &json!({ "capabilities": capabilities, "processId": null, "rootUri": null }));
        assert_eq!(initialized["serverInfo"]["name"], "lfz");
        editor.notify("initialized", &json!({}));
        editor
    }

    pub(crate) fn uri(&self, name: &str) -> String {
        let path = fs::canonicalize(self.folder.path()).unwrap().join(name);
        url::Url::from_file_path(path).unwrap().to_string()
    }

    fn write(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("the server reads");
        self.input.flush().expect("the server reads");
    }

    pub(crate) fn notify(&mut self, method: &str, params: &Value) {
        self.write(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    pub(crate) fn open(&mut self, name: &str, text: &str) {
        let document = json!({ "uri": self.uri(name), "languageId": "lf", "version": 1, "text": text });
        self.notify("textDocument/didOpen", &json!({ "textDocument": document }));
    }

    pub(crate) fn change(&mut self, name: &str, text: &str) {
        let document = json!({ "uri": self.uri(name), "version": 2 });
        let changes = json!([{ "text": text }]);
        self.notify("textDocument/didChange", &json!({ "textDocument": document, "contentChanges": changes }));
    }

    fn read(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(self.output.read_line(&mut line).expect("it is text") > 0, "the server has ended");
            match line.trim().split_once(": ") {
                Some(("Content-Length", number)) => length = number.parse().unwrap(),
                Some(_) => {}
                None => break,
            }
        }
        let mut bytes = vec![0; length];
        self.output.read_exact(&mut bytes).expect("it is as long as it says");
        let message: Value = serde_json::from_slice(&bytes).expect("it is JSON");
        self.heard.extend(message["method"].as_str().map(str::to_owned));
        message
    }

    /// Asks, and returns the answer; what is told meanwhile is forgotten.
    pub(crate) fn ask_for(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        self.write(&json!({ "jsonrpc": "2.0", "id": self.asked, "method": method, "params": params }));
        loop {
            let message = self.read();
            if message["id"] == self.asked {
                return message;
            }
        }
    }

    pub(crate) fn ask(&mut self, method: &str, params: &Value) -> Value {
        self.ask_for(method, params)["result"].clone()
    }

    /// Returns the first place of a text in a file with these contents, this many characters behind its beginning.
    pub(crate) fn place(&self, name: &str, contents: &str, text: &str, behind: usize) -> Value {
        let at = contents.find(text).expect("it is there");
        let line = contents[..at].matches('\n').count();
        let column = contents[..at].rsplit('\n').next().unwrap_or_default().encode_utf16().count() + behind;
        let document = json!({ "uri": self.uri(name) });
        json!({ "textDocument": document, "position": { "line": line, "character": column } })
    }

    /// Asks about such a place.
    pub(crate) fn ask_in(&mut self, name: &str, contents: &str, method: &str, text: &str, behind: usize) -> Value {
        let mut place = self.place(name, contents, text, behind);
        if method == "textDocument/references" {
            place["context"] = json!({ "includeDeclaration": true });
        }
        self.ask(method, &place)
    }

    /// Asks about the first place of a text in `Main.lf`.
    fn ask_at(&mut self, method: &str, text: &str, behind: usize) -> Value {
        self.ask_in("Main.lf", MAIN, method, text, behind)
    }

    /// Writes a file beside the others.
    pub(crate) fn write_file(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).expect("it can be written");
    }

    /// Returns what is told next by a method that begins so.
    pub(crate) fn told(&mut self, method: &str) -> Value {
        loop {
            let message = self.read();
            if message["method"].as_str().is_some_and(|told| told.starts_with(method)) {
                return message["params"].clone();
            }
        }
    }

    /// Returns the diagnostics that are told next, of a file.
    pub(crate) fn diagnostics(&mut self, name: &str) -> Value {
        let uri = self.uri(name);
        loop {
            let message = self.read();
            if message["method"] == "textDocument/publishDiagnostics" && message["params"]["uri"] == uri.as_str() {
                return message["params"]["diagnostics"].clone();
            }
        }
    }

    pub(crate) fn end(mut self) {
        assert_eq!(self.ask("shutdown", &Value::Null), Value::Null);
        self.notify("exit", &Value::Null);
        assert!(self.server.wait().expect("it ends").success());
    }

    /// Returns a text in which the folder has no name of its own.
    fn shown(&self, value: &Value) -> String {
        let folder = self.uri("");
        format!("{value:#}\n").replace(folder.trim_end_matches('/'), "FOLDER")
    }
}

#[test]
fn errors_are_told_while_a_program_is_typed() {
    let mut editor = Editor::start();
    editor.open("Main.lf", MAIN);
    assert_eq!(editor.diagnostics("Main.lf"), json!([]), "the text of the editor counts, not that on disk");
    editor.change("Main.lf", &MAIN.replace("state last: u32 = 0", "state last: time = 0 ns; state last: u8"));
    let twice = editor.diagnostics("Main.lf");
    insta::assert_snapshot!(editor.shown(&twice));
    editor.change("Main.lf", &MAIN.replace("show = new Show()\n", "show = new Sho"));
    assert_ne!(editor.diagnostics("Main.lf"), json!([]));
    editor.change("Main.lf", &MAIN.replace('\n', "\r\n"));
    assert_eq!(editor.diagnostics("Main.lf"), json!([]));
    // A library has no main reactor, and its changes are seen where it is imported.
    editor.open("lib.lf", LIBRARY);
    assert_eq!(editor.diagnostics("lib.lf"), json!([]));
    editor.change("lib.lf", &LIBRARY.replace("output count", "output number"));
    let unknown = editor.diagnostics("Main.lf");
    assert_eq!(unknown[0]["code"], "E047-unknown-port");
    let library = editor.uri("lib.lf");
    editor.notify("textDocument/didClose", &json!({ "textDocument": { "uri": library } }));
    assert_eq!(editor.diagnostics("Main.lf"), json!([]), "now the file on disk counts");
    editor.end();
}

#[test]
fn names_are_explained_and_found() {
    let mut editor = Editor::start();
    editor.open("Main.lf", MAIN);
    let mut answers = String::new();
    for (method, text, behind) in [
        ("textDocument/hover", "counter.count", 9),
        ("textDocument/hover", "last", 4),
        ("textDocument/hover", "main", 1),
        ("textDocument/definition", "Counter(start", 2),
        ("textDocument/definition", "show.x", 5),
        ("textDocument/references", "Counter from", 0),
        ("textDocument/completion", "count -> show", 0),
    ] {
        let answer = editor.ask_at(method, text, behind);
        write!(answers, "{method} {text} +{behind}: {}", editor.shown(&answer)).unwrap();
    }
    insta::assert_snapshot!(answers);
    let names = |answer: &Value| {
        let all = answer.as_array().expect("a list").iter();
        all.map(|item| item["label"].as_str().expect("a text").to_owned()).collect::<Vec<_>>()
    };
    let within = names(&editor.ask_at("textDocument/completion", "reaction(x)", 9));
    assert_eq!(within, ["startup", "shutdown", "reset", "x"]);
    let between = names(&editor.ask_at("textDocument/completion", "  reaction(x)", 2));
    assert!(["timer", "x"].iter().all(|name| between.iter().any(|one| one == name)), "{between:?}");
    assert!(!between.iter().any(|name| name == "counter"), "{between:?}");
    editor.end();
}

#[test]
fn a_file_has_an_outline_and_is_formatted() {
    let mut editor = Editor::start();
    editor.open("Main.lf", &MAIN.replace("  state", "      state"));
    let document = json!({ "textDocument": { "uri": editor.uri("Main.lf") },
        "options": { "tabSize": 2, "insertSpaces": true } });
    let edits = editor.ask("textDocument/formatting", &document);
    assert_eq!(edits[0]["newText"], MAIN);
    editor.change("Main.lf", MAIN);
    assert_eq!(editor.ask("textDocument/formatting", &document), Value::Null);
    editor.change("Main.lf", "target Rust\nreactor {");
    assert_eq!(editor.ask("textDocument/formatting", &document), Value::Null);
    editor.change("Main.lf", MAIN);
    let symbols = editor.ask("textDocument/documentSymbol", &document);
    let outline: Vec<String> = symbols
        .as_array()
        .unwrap()
        .iter()
        .map(|reactor| {
            let children = reactor["children"].as_array().unwrap().iter();
            let children: Vec<&str> = children.map(|child| child["detail"].as_str().unwrap()).collect();
            format!("{}: {}", reactor["name"].as_str().unwrap(), children.join(", "))
        })
        .collect();
    insta::assert_snapshot!(outline.join("\n"));
    editor.end();
}

/// Questions that no editor would ask end nothing, but get an error.
#[test]
fn strange_questions_are_answered() {
    let mut editor = Editor::start();
    assert_eq!(editor.ask_for("textDocument/strange", &json!({}))["error"]["code"], -32601);
    assert_eq!(editor.ask_for("textDocument/hover", &json!({ "position": 7 }))["error"]["code"], -32602);
    editor.notify("textDocument/didOpen", &json!("nonsense"));
    editor.notify(
        "textDocument/didOpen",
        &json!({ "textDocument":
        { "uri": "untitled:Untitled-1", "languageId": "lf", "version": 1, "text": "target" } }),
    );
    editor.notify("$/cancelRequest", &json!({ "id": 3 }));
    let unopened =
        json!({ "textDocument": { "uri": editor.uri("lib.lf") }, "position": { "line": 1, "character": 1 } });
    assert_eq!(editor.ask("textDocument/hover", &unopened), Value::Null);
    editor.open("Gone.lf", "target Rust\nmain reactor {\n}\n");
    assert_eq!(editor.diagnostics("Gone.lf"), json!([]), "a file that is not saved yet");
    editor.end();
}

/// An editor that is gone takes the server with it.
#[test]
fn the_server_ends_with_the_editor() {
    let Editor { mut server, input, .. } = Editor::start();
    drop(input);
    assert!(server.wait().is_ok());
    let folder = Path::new("/");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("lfz can be started");
    child.stdin.take().unwrap().write_all(b"hello\r\n\r\n").expect("it is read");
    let output = child.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && error.contains("error: "), "{error}");
}
