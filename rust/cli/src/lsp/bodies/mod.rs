// SPDX-License-Identifier: Apache-2.0
//! Answers of rust-analyzer and clangd about bodies, where the user has these: they read the generated crates, and
//! their answers appear at the places of the program, together with our own.
//!
//! A thread of its own generates the crates and speaks with the tools, which it starts when the editor asks about a
//! place in a body. An answer that takes longer than [`ANSWER_TIME_OUT`] is our own one.

mod answers;
mod parts;
mod project;
mod tool;
mod worker;

use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, never, unbounded};
use lf_compiler::syntax::{LexemeKind, lexemes};
use lsp_server::{RequestId, Response};
use lsp_types::TextDocumentPositionParams;
use serde_json::Value;

pub(super) use answers::BodyQuestion;
pub(super) use worker::BodyReply;

use super::buffers::Buffers;
use super::positions::byte;
use worker::{BodyJob, ToolKeeper};

/// The time for which the editor waits for more than our own answer: people notice a longer one.
const ANSWER_TIME_OUT: Duration = Duration::from_secs(1);

/// The tools, as the server knows them.
#[derive(Default)]
pub(super) struct BodyTools {
    thread: Option<ToolThread>,
    waiting: Vec<WaitingAnswer>,
    asked: u64,
}

struct ToolThread {
    jobs: Sender<BodyJob>,
    replies: Receiver<BodyReply>,
    thread: JoinHandle<()>,
}

/// An answer of ours to which a tool may add something.
struct WaitingAnswer {
    number: u64,
    id: RequestId,
    kind: BodyQuestion,
    own: Value,
    until: Instant,
}

impl BodyTools {
    /// Asks the tools about a place in a code block; returns the answer where there is nothing to wait for.
    pub(super) fn ask(
        &mut self,
        buffers: &Buffers,
        kind: BodyQuestion,
        (id, method, params): (RequestId, String, Value),
        own: Value,
    ) -> Option<Response> {
        let has_all = kind == BodyQuestion::Definition && !own.is_null();
        let place = serde_json::from_value::<TextDocumentPositionParams>(params.clone()).ok();
        let found = place.as_ref().and_then(|place| Some((place, buffers.get(&place.text_document.uri)?)));
        let Some((place, (path, _))) =
            found.filter(|(place, (_, text))| !has_all && is_in_code(text, byte(text, place.position)))
        else {
            return Some(Response::new_ok(id, own));
        };
        self.asked += 1;
        let (number, until) = (self.asked, Instant::now() + ANSWER_TIME_OUT);
        let (path, position, buffers) = (path.to_owned(), place.position, buffers.clone());
        let job = BodyJob::Ask { number, kind, method, params, path, position, buffers };
        let thread = self.thread.get_or_insert_with(ToolThread::start);
        if thread.jobs.send(job).is_err() {
            return Some(Response::new_ok(id, own));
        }
        self.waiting.push(WaitingAnswer { number, id, kind, own, until });
        None
    }

    /// Tells the tools that texts have changed.
    pub(super) fn change(&self, buffers: &Buffers) {
        if let Some(thread) = &self.thread {
            // A thread that has ended answers nothing more, and we answer alone.
            let _ = thread.jobs.send(BodyJob::Changed(buffers.clone()));
        }
    }

    /// Returns what comes of the questions.
    pub(super) fn replies(&self) -> Receiver<BodyReply> {
        self.thread.as_ref().map_or_else(never, |thread| thread.replies.clone())
    }

    /// Forgets the thread, which has ended.
    pub(super) fn forget(&mut self) {
        self.thread = None;
        let now = Instant::now();
        self.waiting.iter_mut().for_each(|waiting| waiting.until = now);
    }

    /// Returns the whole answer to a question; `None` if it came too late.
    pub(super) fn answered(&mut self, number: u64, other: Option<Value>) -> Option<Response> {
        let index = self.waiting.iter().position(|waiting| waiting.number == number)?;
        let WaitingAnswer { id, kind, own, .. } = self.waiting.remove(index);
        let answer = match other {
            Some(other) => answers::together(kind, own, other),
            None => own,
        };
        Some(Response::new_ok(id, answer))
    }

    /// Returns when the next question has waited long enough.
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.waiting.iter().map(|waiting| waiting.until).min()
    }

    /// Returns our own answers to the questions that have waited long enough.
    pub(super) fn late(&mut self) -> Vec<Response> {
        let now = Instant::now();
        let (late, waiting) = std::mem::take(&mut self.waiting).into_iter().partition(|waiting| waiting.until <= now);
        self.waiting = waiting;
        let late: Vec<WaitingAnswer> = late;
        late.into_iter().map(|waiting| Response::new_ok(waiting.id, waiting.own)).collect()
    }

    /// Ends the tools.
    pub(super) fn end(self) {
        if let Some(ToolThread { jobs, replies, thread }) = self.thread {
            drop((jobs, replies));
            // A panic of the thread has been told on standard error.
            let _ = thread.join();
        }
    }
}

impl ToolThread {
    fn start() -> Self {
        let (jobs, work) = unbounded();
        let (sender, replies) = unbounded();
        let thread = thread::spawn(move || ToolKeeper::run(&work, sender));
        Self { jobs, replies, thread }
    }
}

/// Returns whether a place is within the marks of a code block.
fn is_in_code(text: &str, byte: usize) -> bool {
    let holds = |start: usize, end: usize| start + 2 <= byte && byte + 2 <= end;
    lexemes(text).iter().any(|one| one.kind == LexemeKind::Code && holds(one.start, one.end))
}
