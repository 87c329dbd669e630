// SPDX-License-Identifier: Apache-2.0
//! The language server: what an editor asks about LF files, and tells of them, over standard input and output.
//!
//! Checking a large program takes less time than a key stroke, so nothing is kept between two questions but the texts
//! that the editor has open. After a change all open files are checked, each as the main file of a program, with the
//! texts of the editor in the place of those on disk. The tools that answer in bodies, too, have a thread of their own.

mod asked;
mod bodies;
mod buffers;
mod completion;
mod diagnostics;
mod facts;
mod hover;
mod lenses;
mod outline;
mod places;
mod positions;
mod tokens;

use std::collections::{BTreeMap, BTreeSet};

use crossbeam_channel::{at, never, select};
use lsp_server::{Connection, ErrorCode, Message, Notification, ProtocolError, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, LogMessage, Notification as _,
    PublishDiagnostics, ShowMessage,
};
use lsp_types::request::{
    CodeActionRequest, CodeLensRequest, Completion, DocumentSymbolRequest, FoldingRangeRequest, Formatting,
    GotoDefinition, HoverRequest, InlayHintRequest, PrepareRenameRequest, References, Rename, Request as _,
    SemanticTokensFullRequest, SignatureHelpRequest,
};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeLensOptions, CompletionOptions, Diagnostic, FoldingRangeProviderCapability,
    HoverProviderCapability, LogMessageParams, MessageType, OneOf, PublishDiagnosticsParams, RenameOptions,
    SemanticTokensFullOptions, SemanticTokensLegend, SemanticTokensOptions, ServerCapabilities, ShowMessageParams,
    SignatureHelpOptions, TextDocumentSyncCapability, TextDocumentSyncKind, Uri, WorkDoneProgressOptions,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::failure::Failure;
use bodies::{BodyQuestion, BodyReply, BodyTools};
use buffers::Buffers;

/// Serves an editor until it asks for the end.
///
/// # Errors
/// When what comes is no language server protocol, or ends without a word.
pub(crate) fn serve() -> Result<(), Failure> {
    let (connection, threads) = Connection::stdio();
    let mut server = Server::new(&connection);
    let result = server.run();
    server.tools.end();
    drop(connection);
    let joined = threads.join();
    result.map_err(|error| Failure::message(format!("the editor's messages cannot be understood: {error}")))?;
    joined.map_err(|error| Failure::message(format!("the editor is gone: {error}")))
}

struct Server<'c> {
    connection: &'c Connection,
    buffers: Buffers,
    /// The files of which the editor shows diagnostics.
    published: BTreeSet<String>,
    /// The commands that the editor has for code lenses.
    commands: Vec<String>,
    tools: BodyTools,
    /// The diagnostics of the compiler, and those of the tools, by the editor's names of the files.
    own: BTreeMap<String, Vec<Diagnostic>>,
    of_tools: BTreeMap<String, Vec<Diagnostic>>,
}

impl<'c> Server<'c> {
    fn new(connection: &'c Connection) -> Self {
        Self {
            connection,
            buffers: Buffers::default(),
            published: BTreeSet::new(),
            commands: Vec::new(),
            tools: BodyTools::default(),
            own: BTreeMap::new(),
            of_tools: BTreeMap::new(),
        }
    }

    fn run(&mut self) -> Result<(), ProtocolError> {
        let (id, params) = self.connection.initialize_start()?;
        self.commands = lenses::commands_of(&params["capabilities"]);
        let capabilities = capabilities();
        let about = json!({ "name": "lfz", "version": env!("CARGO_PKG_VERSION") });
        self.connection.initialize_finish(id, json!({ "capabilities": capabilities, "serverInfo": about }))?;
        loop {
            let message = select! {
                recv(self.connection.receiver) -> message => message,
                recv(self.tools.replies()) -> reply => {
                    match reply {
                        Ok(reply) => self.hear(reply),
                        Err(_) => self.tools.forget(),
                    }
                    continue;
                }
                recv(self.tools.deadline().map_or_else(never, at)) -> _ => {
                    self.tools.late().into_iter().for_each(|response| self.send(Message::Response(response)));
                    continue;
                }
            };
            let Ok(message) = message else { return Ok(()) };
            let mut next = Some(message);
            let mut has_changed = false;
            // What was typed meanwhile is checked once.
            while let Some(message) = next {
                match message {
                    Message::Request(request) => {
                        if self.connection.handle_shutdown(&request)? {
                            return Ok(());
                        }
                        if let Some(response) = self.respond(request) {
                            self.send(Message::Response(response));
                        }
                    }
                    Message::Notification(notification) => has_changed |= self.note(notification),
                    Message::Response(_) => {}
                }
                next = self.connection.receiver.try_recv().ok();
            }
            if has_changed {
                self.own = diagnostics::diagnostics(&self.buffers);
                self.publish_diagnostics();
                self.tools.change(&self.buffers);
            }
        }
    }

    /// Answers a question, unless a tool may add something to the answer.
    fn respond(&mut self, request: Request) -> Option<Response> {
        let kind = match request.method.as_str() {
            HoverRequest::METHOD => Some(BodyQuestion::Hover),
            GotoDefinition::METHOD => Some(BodyQuestion::Definition),
            Completion::METHOD => Some(BodyQuestion::Completion),
            SignatureHelpRequest::METHOD => Some(BodyQuestion::Signature),
            _ => None,
        };
        let Some(kind) = kind else { return Some(self.answer(request)) };
        let question = (request.id.clone(), request.method.clone(), request.params.clone());
        let response = self.answer(request);
        match response.response_result {
            Ok(own) => self.tools.ask(&self.buffers, kind, question, own),
            Err(_) => Some(response),
        }
    }

    /// Passes on what comes of the tools.
    fn hear(&mut self, reply: BodyReply) {
        match reply {
            BodyReply::Answer(number, answer) => {
                if let Some(response) = self.tools.answered(number, answer) {
                    self.send(Message::Response(response));
                }
            }
            BodyReply::Diagnostics(all) => {
                self.of_tools.clear();
                for (path, diagnostic) in all {
                    if let Some(uri) = self.buffers.uri(&path) {
                        self.of_tools.entry(uri).or_default().push(diagnostic);
                    }
                }
                self.publish_diagnostics();
            }
            BodyReply::ShowMessage(message) => {
                let told = ShowMessageParams { typ: MessageType::INFO, message };
                self.send(Message::Notification(Notification::new(ShowMessage::METHOD.to_owned(), told)));
            }
            BodyReply::LogMessage(message) => {
                let told = LogMessageParams { typ: MessageType::INFO, message };
                self.send(Message::Notification(Notification::new(LogMessage::METHOD.to_owned(), told)));
            }
        }
    }

    /// Sends a message. When the editor is gone, the next one cannot be received.
    fn send(&self, message: Message) {
        let _ = self.connection.sender.send(message);
    }

    /// Takes note of what the editor tells, and returns whether a text is another one now.
    fn note(&mut self, notification: Notification) -> bool {
        match notification.method.as_str() {
            DidOpenTextDocument::METHOD => {
                let Some(told) =
                    read::<<DidOpenTextDocument as lsp_types::notification::Notification>::Params>(notification.params)
                else {
                    return false;
                };
                self.buffers.set(&told.text_document.uri, told.text_document.text)
            }
            DidChangeTextDocument::METHOD => {
                let Some(told) = read::<lsp_types::DidChangeTextDocumentParams>(notification.params) else {
                    return false;
                };
                let whole = told.content_changes.into_iter().rfind(|change| change.range.is_none());
                whole.is_some_and(|change| self.buffers.set(&told.text_document.uri, change.text))
            }
            DidCloseTextDocument::METHOD => {
                let Some(told) = read::<lsp_types::DidCloseTextDocumentParams>(notification.params) else {
                    return false;
                };
                self.buffers.close(&told.text_document.uri)
            }
            _ => false,
        }
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params, .. } = request;
        let buffers = &self.buffers;
        let answer = match method.as_str() {
            HoverRequest::METHOD => answered(params, |asked| hover::hover(buffers, &asked)),
            GotoDefinition::METHOD => answered(params, |asked| places::definition(buffers, &asked)),
            References::METHOD => answered(params, |asked| places::references(buffers, &asked)),
            PrepareRenameRequest::METHOD => answered(params, |asked| places::prepare_rename(buffers, &asked)),
            Rename::METHOD => match read(params) {
                Some(asked) => match places::rename(buffers, &asked) {
                    Ok(edit) => serde_json::to_value(edit),
                    Err(text) => return Response::new_err(id, ErrorCode::RequestFailed as i32, text),
                },
                None => return Response::new_err(id, ErrorCode::InvalidParams as i32, NO_RENAME.to_owned()),
            },
            CodeActionRequest::METHOD => answered(params, |asked| diagnostics::fixes(buffers, &asked)),
            DocumentSymbolRequest::METHOD => answered(params, |asked| outline::symbols(buffers, &asked)),
            FoldingRangeRequest::METHOD => answered(params, |asked| outline::folding(buffers, &asked)),
            Formatting::METHOD => answered(params, |asked| outline::formatting(buffers, &asked)),
            SemanticTokensFullRequest::METHOD => answered(params, |asked| tokens::tokens(buffers, &asked)),
            CodeLensRequest::METHOD => answered(params, |asked| lenses::lenses(buffers, &self.commands, &asked)),
            InlayHintRequest::METHOD => answered(params, |asked| lenses::hints(buffers, &asked)),
            Completion::METHOD => answered(params, |asked| completion::completion(buffers, &asked)),
            // Only bodies have functions, and only tools know them.
            SignatureHelpRequest::METHOD => Ok(Value::Null),
            _ => {
                let text = format!("lfz does not answer `{method}`");
                return Response::new_err(id, ErrorCode::MethodNotFound as i32, text);
            }
        };
        match answer {
            Ok(value) => Response::new_ok(id, value),
            Err(error) => Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string()),
        }
    }

    /// Publishes the diagnostics of all open files, and of those that they import.
    fn publish_diagnostics(&mut self) {
        let mut all = self.own.clone();
        for (uri, diagnostics) in &self.of_tools {
            all.entry(uri.clone()).or_default().extend(diagnostics.iter().cloned());
        }
        for uri in std::mem::take(&mut self.published) {
            all.entry(uri).or_default();
        }
        for (uri, diagnostics) in all {
            let Ok(parsed) = uri.parse::<Uri>() else { continue };
            if !diagnostics.is_empty() {
                self.published.insert(uri);
            }
            let told = PublishDiagnosticsParams::new(parsed, diagnostics, None);
            self.send(Message::Notification(Notification::new(PublishDiagnostics::METHOD.to_owned(), told)));
        }
    }
}

/// The error of a question that has no new name.
const NO_RENAME: &str = "a rename needs a place and a new name";

/// Returns what the server can do.
fn capabilities() -> ServerCapabilities {
    let work_done_progress_options = WorkDoneProgressOptions::default();
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions { prepare_provider: Some(true), work_done_progress_options })),
        code_action_provider: Some(
            CodeActionOptions {
                code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]),
                ..CodeActionOptions::default()
            }
            .into(),
        ),
        document_symbol_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        folding_range_provider: Some(FoldingRangeProviderCapability::Simple(true)),
        semantic_tokens_provider: Some(
            SemanticTokensOptions {
                legend: SemanticTokensLegend { token_types: tokens::KINDS.to_vec(), token_modifiers: Vec::new() },
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            }
            .into(),
        ),
        code_lens_provider: Some(CodeLensOptions { resolve_provider: Some(false) }),
        inlay_hint_provider: Some(OneOf::Left(true)),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some([".", ">", "@", "\"", ":"].map(str::to_owned).into()),
            ..CompletionOptions::default()
        }),
        signature_help_provider: Some(SignatureHelpOptions {
            trigger_characters: Some(["(", ",", "<"].map(str::to_owned).into()),
            ..SignatureHelpOptions::default()
        }),
        ..ServerCapabilities::default()
    }
}

fn read<P: DeserializeOwned>(params: Value) -> Option<P> {
    serde_json::from_value(params).ok()
}

/// Answers a question; one that cannot be understood is an error.
fn answered<P: DeserializeOwned, A: Serialize>(
    params: Value,
    answer: impl FnOnce(P) -> A,
) -> Result<Value, serde_json::Error> {
    serde_json::to_value(answer(serde_json::from_value(params)?))
}
