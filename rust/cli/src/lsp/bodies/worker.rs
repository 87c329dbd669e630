// SPDX-License-Identifier: Apache-2.0
//! The thread that keeps the tools and what they read, so that nothing that they do keeps the editor waiting.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::rc::Rc;

use crossbeam_channel::{Receiver, Sender, select, unbounded};
use lsp_server::{Message, Notification, Response};
use lsp_types::{Diagnostic, NumberOrString, Position, PublishDiagnosticsParams};
use serde_json::{Value, json};
use url::Url;

use super::answers::{self, BodyQuestion, Translation};
use super::project::{CodeProject, GeneratedPlace};
use super::tool::{Tool, ToolEvent, ToolKind};
use crate::compile::ReadableCode;
use crate::lsp::buffers::Buffers;

/// Work for the thread.
pub(super) enum BodyJob {
    /// The texts of the editor have changed.
    Changed(Buffers),
    /// A place in a code block is asked about.
    Ask {
        /// The number by which the answer is known.
        number: u64,
        kind: BodyQuestion,
        /// The method of the protocol, and the rest of what the editor says with the place.
        method: String,
        params: Value,
        /// The LF file.
        path: String,
        position: Position,
        buffers: Buffers,
    },
}

/// The result of a job.
pub(in crate::lsp) enum BodyReply {
    /// The answer to a question, if there is one.
    Answer(u64, Option<Value>),
    /// The diagnostics that tools have for LF files, all of them.
    Diagnostics(Vec<(String, Diagnostic)>),
    /// A message that the editor shows.
    ShowMessage(String),
    /// A message for the editor's log.
    LogMessage(String),
}

/// A question that a tool has not answered yet.
struct OpenQuestion {
    number: u64,
    kind: BodyQuestion,
    project: Rc<CodeProject>,
    file: String,
    is_exact: bool,
}

/// The state of the thread.
pub(super) struct ToolKeeper {
    replies: Sender<BodyReply>,
    events: Sender<ToolEvent>,
    buffers: Buffers,
    /// The tools that run; `None` for one that is missing or has ended.
    tools: BTreeMap<ToolKind, Option<Tool>>,
    /// The programs that were asked about, by their main files; `None` while one has errors outside of bodies.
    projects: BTreeMap<String, Option<Rc<CodeProject>>>,
    /// The folders that rust-analyzer knows.
    folders: BTreeSet<PathBuf>,
    questions: BTreeMap<(ToolKind, i32), OpenQuestion>,
    /// The diagnostics of tools about generated files, at the places of the program.
    diagnostics: BTreeMap<String, Vec<(String, Diagnostic)>>,
}

impl ToolKeeper {
    /// Works until there can be no more jobs.
    pub(super) fn run(jobs: &Receiver<BodyJob>, replies: Sender<BodyReply>) {
        let (sender, events) = unbounded();
        let mut keeper = Self {
            replies,
            events: sender,
            buffers: Buffers::default(),
            tools: BTreeMap::new(),
            projects: BTreeMap::new(),
            folders: BTreeSet::new(),
            questions: BTreeMap::new(),
            diagnostics: BTreeMap::new(),
        };
        loop {
            select! {
                recv(jobs) -> job => match job {
                    Ok(job) => keeper.work(job, jobs),
                    Err(_) => return,
                },
                recv(events) -> event => match event {
                    Ok(ToolEvent::Said(kind, message)) => keeper.hear(kind, message),
                    Ok(ToolEvent::Ended(kind, words)) => keeper.lose(kind, &words),
                    Err(_) => return,
                },
            }
        }
    }

    /// Does a job, and those that have come meanwhile: of texts the last ones count.
    fn work(&mut self, job: BodyJob, jobs: &Receiver<BodyJob>) {
        let mut changed = None;
        for job in std::iter::once(job).chain(jobs.try_iter()) {
            match job {
                BodyJob::Changed(buffers) => changed = Some(buffers),
                BodyJob::Ask { number, kind, method, params, path, position, buffers } => {
                    if let Some(texts) = changed.take() {
                        self.change(texts);
                    }
                    self.buffers = buffers;
                    if self.ask(number, kind, &method, params, &path, position).is_none() {
                        self.reply(BodyReply::Answer(number, None));
                    }
                }
            }
        }
        if let Some(texts) = changed {
            self.change(texts);
        }
    }

    fn reply(&self, reply: BodyReply) {
        // Without an editor, there will be no further jobs.
        let _ = self.replies.send(reply);
    }

    /// Lets the tools read the programs anew.
    fn change(&mut self, buffers: Buffers) {
        self.buffers = buffers;
        let mains: Vec<String> = self.projects.keys().cloned().collect();
        for main in mains {
            self.read(&main);
        }
    }

    /// Generates a program anew, and tells the tools what they have open of it.
    fn read(&mut self, main: &str) -> Option<Rc<CodeProject>> {
        let project = CodeProject::new(&self.buffers, main).map(Rc::new);
        self.projects.insert(main.to_owned(), project.clone());
        let project = project?;
        if let Err(error) = project.write() {
            self.reply(BodyReply::LogMessage(format!("the generated code cannot be written: {error}")));
            return None;
        }
        for tool in self.tools.values_mut().flatten() {
            for uri in tool.open() {
                if let Some(file) = file_of(&project, &uri)
                    && let Some(text) = project.text(&file)
                {
                    tool.send_text(&uri, &file, text);
                }
            }
        }
        Some(project)
    }

    /// Returns the program with a file: its own, or else another open one that imports it.
    fn project_with(&mut self, path: &str) -> Option<Rc<CodeProject>> {
        let is_known = |(_, project): &(&String, &Option<Rc<CodeProject>>)| {
            project.as_ref().is_some_and(|project| project.has(path))
        };
        if let Some((main, Some(project))) = self.projects.iter().find(is_known) {
            // The question may come before the news of the texts that it is about.
            return if project.is_of(&self.buffers) { Some(project.clone()) } else { self.read(&main.clone()) };
        }
        let others = self.buffers.paths().filter(|other| *other != path);
        let mut mains = std::iter::once(path).chain(others).map(str::to_owned).collect::<Vec<_>>().into_iter();
        let main = mains.find(|main| CodeProject::new(&self.buffers, main).is_some_and(|project| project.has(path)))?;
        self.read(&main)
    }

    /// Asks a tool about a place in a code block. Returns `None` if there will be no answer.
    fn ask(
        &mut self,
        number: u64,
        kind: BodyQuestion,
        method: &str,
        mut params: Value,
        path: &str,
        position: Position,
    ) -> Option<()> {
        let project = self.project_with(path)?;
        let GeneratedPlace { file, position, is_exact } = project.to_generated(path, position)?;
        let uri = Url::from_file_path(project.folder().join(&file)).ok()?.to_string();
        let of = ToolKind::of(&file)?;
        let text = project.text(&file)?.to_owned();
        let tool = self.tool(of, &project)?;
        tool.send_text(&uri, &file, &text);
        if !tool.is_ready {
            return None;
        }
        params["textDocument"] = json!({ "uri": uri });
        params["position"] = json!(position);
        let asked = tool.ask(method, params);
        self.forget(of, kind);
        self.questions.insert((of, asked), OpenQuestion { number, kind, project, file, is_exact });
        Some(())
    }

    /// Forgets the questions of a kind: nobody waits for their answers, as there is a newer one.
    fn forget(&mut self, of: ToolKind, kind: BodyQuestion) {
        let older = self.questions.iter().filter(|((asked, _), open)| *asked == of && open.kind == kind);
        for id in older.map(|(id, _)| *id).collect::<Vec<_>>() {
            if let (Some(open), Some(Some(tool))) = (self.questions.remove(&id), self.tools.get_mut(&of)) {
                tool.forget(id.1);
                self.reply(BodyReply::Answer(open.number, None));
            }
        }
    }

    /// Returns a tool that knows the folder of a program; starts it if it has not been started.
    fn tool(&mut self, kind: ToolKind, project: &CodeProject) -> Option<&mut Tool> {
        let folder = project.folder();
        if !self.tools.contains_key(&kind) {
            let cargo_folder = (kind == ToolKind::RustAnalyzer).then(ReadableCode::cargo_folder);
            let cargo_folder = cargo_folder.and_then(Result::ok);
            let started = Tool::start(kind, folder, cargo_folder.as_deref(), &self.events);
            if let Err(error) = &started {
                self.reply(BodyReply::ShowMessage(missing(kind, &error.to_string())));
            } else if kind == ToolKind::RustAnalyzer {
                self.folders.insert(folder.to_owned());
            }
            self.tools.insert(kind, started.ok());
        }
        let tool = self.tools.get_mut(&kind)?.as_mut()?;
        if kind == ToolKind::RustAnalyzer && self.folders.insert(folder.to_owned()) {
            tool.is_ready = false;
            tool.add_folder(folder);
        }
        Some(tool)
    }

    /// Understands what a tool says.
    fn hear(&mut self, kind: ToolKind, message: Message) {
        let Some(Some(tool)) = self.tools.get_mut(&kind) else { return };
        match message {
            Message::Request(request) => tool.answer(request.id),
            Message::Response(Response { id, response_result }) => {
                let Ok(number) = id.to_string().parse::<i32>() else { return };
                if number == 0 {
                    tool.begin();
                    if tool.is_ready {
                        self.ready(kind);
                    }
                } else if let Some(open) = self.questions.remove(&(kind, number)) {
                    let OpenQuestion { number, kind, project, file, is_exact } = open;
                    let (buffers, is_exact) = (&self.buffers, is_exact);
                    let translation = Translation { project: &project, buffers, file: &file, is_exact };
                    let answer = response_result.ok().and_then(|answer| translation.answer(kind, answer));
                    self.reply(BodyReply::Answer(number, answer));
                }
            }
            Message::Notification(notification) => self.note(kind, notification),
        }
    }

    /// Understands what a tool says unasked.
    fn note(&mut self, kind: ToolKind, notification: Notification) {
        let Notification { method, params } = notification;
        match method.as_str() {
            "textDocument/publishDiagnostics" => {
                if let Ok(told) = serde_json::from_value(params) {
                    self.diagnose(kind, told);
                }
            }
            "experimental/serverStatus" => {
                let (is_quiet, is_well) = (params["quiescent"] == true, params["health"] == "ok");
                let Some(Some(tool)) = self.tools.get_mut(&kind) else { return };
                let was_ready = std::mem::replace(&mut tool.is_ready, is_quiet);
                tool.is_well = is_well;
                if is_quiet && !was_ready {
                    self.ready(kind);
                    let message = params["message"].as_str().unwrap_or_default();
                    if !is_well && !message.is_empty() {
                        let (program, message) = (kind.program(), message.trim());
                        self.reply(BodyReply::ShowMessage(format!("{program} does not know everything: {message}")));
                    }
                }
            }
            _ => {}
        }
    }

    fn ready(&self, kind: ToolKind) {
        self.reply(BodyReply::LogMessage(format!("{} answers in bodies", kind.program())));
    }

    /// Tells the diagnostics of a generated file with all others.
    fn diagnose(&mut self, kind: ToolKind, told: PublishDiagnosticsParams) {
        let uri = told.uri.to_string();
        let found = self.projects.values().flatten().find_map(|project| Some((project, file_of(project, &uri)?)));
        let Some((project, file)) = found else { return };
        let is_well = self.tools.get(&kind).and_then(Option::as_ref).is_some_and(|tool| tool.is_well);
        // Our own compiler tells these, and a tool without its library takes right code for wrong.
        let is_own = |one: &Diagnostic| one.code == Some(NumberOrString::String("syntax-error".to_owned()));
        let all = told.diagnostics.into_iter().filter(|one| is_well && !is_own(one)).collect();
        let all = answers::diagnostics(project, &file, all);
        let old = self.diagnostics.insert(uri, all.clone()).unwrap_or_default();
        if old != all {
            let mut merged: Vec<(String, Diagnostic)> = Vec::new();
            // Several federates may have one reactor.
            for one in self.diagnostics.values().flatten() {
                if !merged.contains(one) {
                    merged.push(one.clone());
                }
            }
            self.reply(BodyReply::Diagnostics(merged));
        }
    }

    /// Goes on without a tool.
    fn lose(&mut self, kind: ToolKind, words: &str) {
        self.tools.insert(kind, None);
        let (lost, rest) = std::mem::take(&mut self.questions).into_iter().partition(|((of, _), _)| *of == kind);
        self.questions = rest;
        let lost: BTreeMap<(ToolKind, i32), OpenQuestion> = lost;
        for open in lost.into_values() {
            self.reply(BodyReply::Answer(open.number, None));
        }
        if !std::mem::take(&mut self.diagnostics).is_empty() {
            self.reply(BodyReply::Diagnostics(Vec::new()));
        }
        self.reply(BodyReply::ShowMessage(missing(kind, words)));
    }
}

/// Returns the generated file of a program that a tool names.
fn file_of(project: &CodeProject, uri: &str) -> Option<String> {
    let file = project.inside(&Url::parse(uri).ok()?.to_file_path().ok()?)?;
    project.text(&file).map(|_| file)
}

/// Returns what is missing without a tool, why, and what to do.
fn missing(kind: ToolKind, why: &str) -> String {
    let (program, why, remedy) = (kind.program(), why.trim_start_matches("error: "), kind.remedy());
    let why = if why.is_empty() { String::new() } else { format!(" ({why})") };
    format!("{program} does not run{why}, so lfz answers alone in bodies: {remedy}, and restart the language server")
}
