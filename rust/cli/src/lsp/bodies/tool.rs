// SPDX-License-Identifier: Apache-2.0
//! A language server for the target language of bodies, as a child process.

use std::collections::BTreeMap;
use std::io::{self, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread;

use crossbeam_channel::{Sender, unbounded};
use lsp_server::{Message, Notification, Request, RequestId, Response};
use serde_json::{Value, json};

use crate::guard;

/// A kind of tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ToolKind {
    RustAnalyzer,
    Clangd,
}

impl ToolKind {
    /// Returns the tool that knows a generated file.
    pub(super) fn of(file: &str) -> Option<Self> {
        match Path::new(file).extension()?.to_str()? {
            "rs" => Some(Self::RustAnalyzer),
            "c" | "h" | "cpp" => Some(Self::Clangd),
            _ => None,
        }
    }

    /// Returns the name of the program.
    pub(super) fn program(self) -> &'static str {
        match self {
            Self::RustAnalyzer => "rust-analyzer",
            Self::Clangd => "clangd",
        }
    }

    /// Returns what to do where it is missing.
    pub(super) fn remedy(self) -> &'static str {
        match self {
            Self::RustAnalyzer => "install it with `rustup component add rust-analyzer rust-src`",
            Self::Clangd => "install the package clangd of your distribution",
        }
    }

    /// Returns its arguments.
    fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::RustAnalyzer => &[],
            // An include would stand elsewhere in the generated file, which nobody edits.
            Self::Clangd => &["--header-insertion=never"],
        }
    }

    fn language(self, file: &str) -> &'static str {
        match self {
            Self::RustAnalyzer => "rust",
            Self::Clangd if file.ends_with("cpp") => "cpp",
            Self::Clangd => "c",
        }
    }

    fn options(self) -> Value {
        match self {
            Self::RustAnalyzer => json!({
                "checkOnSave": false,
                // What these add would stand elsewhere, too.
                "completion": { "autoimport": { "enable": false }, "postfix": { "enable": false } },
            }),
            Self::Clangd => json!({ "clangdFileStatus": true }),
        }
    }
}

/// An event of a tool.
pub(super) enum ToolEvent {
    /// It says something.
    Said(ToolKind, Message),
    /// It has ended; these were its last words.
    Ended(ToolKind, String),
}

/// A running tool.
pub(super) struct Tool {
    kind: ToolKind,
    child: Child,
    input: Sender<Message>,
    /// The number of questions so far.
    asked: i32,
    /// The messages that wait until it has answered `initialize`.
    queue: Option<Vec<Message>>,
    /// The versions and the texts of the files that it has open.
    open: BTreeMap<String, (i32, String)>,
    /// Whether it has read what it is asked about.
    pub(super) is_ready: bool,
    /// Whether it knows all that its diagnostics depend on, such as the standard library.
    pub(super) is_well: bool,
}

impl Tool {
    /// Starts the program; what it says comes through a channel.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn start(
        kind: ToolKind,
        folder: &Path,
        cargo_folder: Option<&Path>,
        events: &Sender<ToolEvent>,
    ) -> io::Result<Self> {
        let mut command = guard::command(kind.program());
        command
            .args(kind.arguments())
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        if let Some(cargo_folder) = cargo_folder {
            command.env("CARGO_TARGET_DIR", cargo_folder).env_remove("CARGO_BUILD_BUILD_DIR");
        }
        let mut child = command.spawn()?;
        let (stdin, stdout, stderr) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (input, messages) = unbounded::<Message>();
        // A tool that reads nothing stops only this thread; it ends with the tool.
        thread::spawn(move || {
            let mut stdin = stdin?;
            messages.iter().try_for_each(|message| message.write(&mut stdin)).ok()
        });
        let events = events.clone();
        thread::spawn(move || {
            let words = stderr.map(|stderr| thread::spawn(move || last_words(BufReader::new(stderr))));
            let mut stdout = BufReader::new(stdout?);
            while let Ok(Some(message)) = Message::read(&mut stdout) {
                events.send(ToolEvent::Said(kind, message)).ok()?;
            }
            let words = words.and_then(|words| words.join().ok()).unwrap_or_default();
            events.send(ToolEvent::Ended(kind, words)).ok()
        });
        let tool = Self {
            kind,
            child,
            input,
            asked: 0,
            queue: Some(Vec::new()),
            open: BTreeMap::new(),
            is_ready: false,
            is_well: true,
        };
        tool.say(Message::Request(Request::new(RequestId::from(0), "initialize".to_owned(), begin(kind, folder))));
        Ok(tool)
    }

    /// Takes note of the answer to `initialize`, and says what has waited for it.
    pub(super) fn begin(&mut self) {
        self.say(note("initialized", json!({})));
        for message in self.queue.take().into_iter().flatten() {
            self.say(message);
        }
        // rust-analyzer says by itself when it has read everything.
        self.is_ready |= self.kind == ToolKind::Clangd;
    }

    /// Answers a question of the tool: no question of these matters to it.
    pub(super) fn answer(&mut self, id: RequestId) {
        self.say(Message::Response(Response::new_ok(id, Value::Null)));
    }

    /// Asks; returns the number of the question.
    pub(super) fn ask(&mut self, method: &str, params: Value) -> i32 {
        self.asked += 1;
        self.later(Message::Request(Request::new(RequestId::from(self.asked), method.to_owned(), params)));
        self.asked
    }

    /// Tells that nobody waits for an answer any more.
    pub(super) fn forget(&mut self, asked: i32) {
        self.later(note("$/cancelRequest", json!({ "id": asked })));
    }

    /// Has it look at a further folder.
    pub(super) fn add_folder(&mut self, folder: &Path) {
        let change = json!({ "event": { "added": [folder_of(folder)], "removed": [] } });
        self.later(note("workspace/didChangeWorkspaceFolders", change));
    }

    /// Sends the text of a file.
    pub(super) fn send_text(&mut self, uri: &str, file: &str, text: &str) {
        let message = match self.open.get_mut(uri) {
            None => {
                self.open.insert(uri.to_owned(), (1, text.to_owned()));
                let language = self.kind.language(file);
                let document = json!({ "uri": uri, "languageId": language, "version": 1, "text": text });
                note("textDocument/didOpen", json!({ "textDocument": document }))
            }
            Some((_, known)) if known == text => return,
            Some((version, known)) => {
                *version += 1;
                text.clone_into(known);
                let document = json!({ "uri": uri, "version": version });
                let changes = json!([{ "text": text }]);
                note("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }))
            }
        };
        self.later(message);
    }

    /// Returns the files that it has open.
    pub(super) fn open(&self) -> Vec<String> {
        self.open.keys().cloned().collect()
    }

    /// Says something as soon as the tool may be told.
    fn later(&mut self, message: Message) {
        match &mut self.queue {
            Some(queue) => queue.push(message),
            None => self.say(message),
        }
    }

    /// Says something; one that has ended hears nothing, and its end is told.
    fn say(&self, message: Message) {
        let _ = self.input.send(message);
    }
}

impl Drop for Tool {
    fn drop(&mut self) {
        // It keeps nothing that it would have to write.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn note(method: &str, params: Value) -> Message {
    Message::Notification(Notification::new(method.to_owned(), params))
}

fn folder_of(folder: &Path) -> Value {
    let uri = url::Url::from_file_path(folder).map(String::from).unwrap_or_default();
    json!({ "uri": uri, "name": folder.to_string_lossy() })
}

/// Returns the first question, with what the answers may be.
fn begin(kind: ToolKind, folder: &Path) -> Value {
    let folder = folder_of(folder);
    let document = json!({
        "synchronization": {},
        "completion": { "completionItem": { "documentationFormat": ["markdown"] } },
        "hover": { "contentFormat": ["markdown"] },
        "definition": { "linkSupport": false },
        "signatureHelp": { "signatureInformation": { "documentationFormat": ["markdown"],
            "parameterInformation": { "labelOffsetSupport": true }, "activeParameterSupport": true } },
        "publishDiagnostics": {},
    });
    json!({
        "processId": std::process::id(),
        "clientInfo": { "name": "lfz" },
        "rootUri": folder["uri"],
        "workspaceFolders": [folder],
        "initializationOptions": kind.options(),
        "capabilities": {
            "general": { "positionEncodings": ["utf-16"] },
            "workspace": { "workspaceFolders": true },
            "textDocument": document,
            "experimental": { "serverStatusNotification": true },
        },
    })
}

/// Returns the last line that tells something.
fn last_words(stderr: impl io::BufRead) -> String {
    let lines = stderr.lines().map_while(Result::ok).filter(|line| !line.trim().is_empty());
    let is_error = |line: &String| line.starts_with("error");
    lines.reduce(|last, line| if is_error(&last) { last } else { line }).unwrap_or_default()
}
