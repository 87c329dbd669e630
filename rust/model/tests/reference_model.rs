// SPDX-License-Identifier: Apache-2.0
//! Proves that the engine runs random programs as a reference model does, event by event.
//!
//! The reference is a simulator in a few lines of std: one sorted map of events, looked at with no cleverness. The
//! programs have timers, logical actions with all spacing policies, ports, delayed connections, network inputs and
//! outputs; what their reactions do is a function of a seed, so that both run the same. Queues are small, so that some
//! fill up.
//!
//! The same programs run in pieces too: messages come while their tag is open, and reactions wait for them by level.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "small numbers"
)]
use std::collections::BTreeMap;

use crate::reference::program::RandomProgram;
use crate::reference::{
    ACTIONS, AT_INPUTS, ActionPlan, INPUTS, NetworkMessage, Outcome, PORTS, Plan, QUEUE_CAPACITY, START, TIMERS,
    TagPair,
};
use lf_model::{Engine, EngineStorage, InputId, Instant, Interval, Microstep, Progress, Settings, Storage, Tag};
use lf_testkit::host::{Clock, Host};
use proptest::prelude::*;

/// As many tags as are compared; random programs can go on without end.
const TAGS_MAX: usize = 200;

fn tag_of((time, microstep): TagPair) -> Tag {
    Tag::new(Instant::from_nanos(START + time), Microstep(microstep))
}

fn pair_of(tag: Tag) -> TagPair {
    (tag.time.as_nanos() - START, tag.microstep.0)
}

/// An engine in the middle of a run.
struct Run {
    program: RandomProgram,
    engine: Engine<'static>,
    host: Host,
    failed: bool,
}

impl Run {
    fn new(plan: &Plan) -> Self {
        let program = RandomProgram::new(plan.clone());
        let storage: &'static mut Storage<16, 1, 1, 1> = Box::leak(Box::new(EngineStorage::new()));
        assert_eq!(program.tables.triggers.len(), 16, "the storage is that of the tables");
        let settings = Settings { timeout: plan.timeout.map(Interval::from_nanos), ..Settings::DEFAULT };
        let mut engine = Engine::new(program.tables, storage, settings);
        engine.start(Instant::from_nanos(START));
        Self { program, engine, host: Host::new(Clock::new_static(START)), failed: false }
    }

    /// Delivers a message; returns whether the queue was full.
    fn deliver(&mut self, &(input, tag, value): &(usize, TagPair, u32)) -> bool {
        let input = InputId(input as u16);
        self.engine.deliver(&mut self.program, input, tag_of(tag), &u32::to_le_bytes(value)).is_err()
    }

    fn begin(&mut self, tag: Tag) {
        self.engine.begin(&mut self.program, tag).unwrap();
    }

    /// Runs the open tag to its end.
    fn complete(&mut self) {
        match self.engine.advance(&mut self.program, &mut self.host, None) {
            Progress::Complete => {}
            Progress::Failed(_) => self.failed = true,
            other => panic!("{other:?}"),
        }
    }

    /// Runs reactions below a level. Whether the tag is still open.
    fn advance_below(&mut self, level: u16) -> bool {
        match self.engine.advance(&mut self.program, &mut self.host, Some(level)) {
            Progress::LevelLimit { level: limit } => {
                assert_eq!(limit, level);
                true
            }
            Progress::Failed(_) => {
                self.failed = true;
                false
            }
            other => panic!("{other:?}"),
        }
    }

    fn outcome(self, full: Vec<bool>) -> Outcome {
        let value = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
        let sent = self.host.sent.iter().map(|(_, port, tag, bytes)| (*tag, *port, Some(value(bytes))));
        let mut told: Vec<_> = sent.chain(self.host.absent.iter().map(|(_, port, tag)| (*tag, *port, None))).collect();
        told.sort_unstable();
        let told = told.into_iter().map(|(tag, port, value)| (pair_of(tag), usize::from(port), value)).collect();
        Outcome { trace: self.program.trace, told, full, failed: self.failed, done: self.engine.is_done() }
    }
}

/// Delivers all messages first, then runs tag by tag.
fn run_whole(plan: &Plan) -> Outcome {
    let mut run = Run::new(plan);
    let full = plan.messages.iter().map(|message| run.deliver(message)).collect();
    for _ in 0..TAGS_MAX {
        let Some(tag) = run.engine.next_tag() else { break };
        run.begin(tag);
        run.complete();
    }
    run.outcome(full)
}

/// The free choices of a run in pieces.
#[derive(Clone, Debug)]
struct Pieces {
    /// By input: its messages come while their tag is open.
    late: Vec<bool>,
    /// In this order, those that come while the tag is open.
    order: Vec<usize>,
    /// Tags at which nothing happens, but which are run: as many ns after the start.
    empty: Vec<i64>,
}

/// Delivers the messages of some inputs while their tag is open, each before the reactions that see it, as a federation
/// does: reactions from the lowest level of an unknown input on have to wait.
fn run_in_pieces(plan: &Plan, pieces: &Pieces) -> Outcome {
    let mut run = Run::new(plan);
    let mut coming: BTreeMap<TagPair, Vec<&(usize, TagPair, u32)>> = BTreeMap::new();
    for message in &plan.messages {
        if pieces.late[message.0] {
            coming.entry(message.1).or_default().push(message);
        } else {
            assert!(!run.deliver(message), "the strategy gives no more than fit");
        }
    }
    let mut empty = pieces.empty.clone();
    let mut emptied = Vec::new();
    let mut count = 0;
    while count < TAGS_MAX && !run.engine.is_done() {
        let next = run.engine.next_tag().unwrap_or(Tag::FOREVER);
        let message = coming.first_key_value().map_or(Tag::FOREVER, |(tag, _)| tag_of(*tag));
        let event = next.min(message);
        empty.retain(|time| tag_of((*time, 7)) > run.engine.current_tag());
        let nothing = empty.iter().map(|time| tag_of((*time, 7))).min().filter(|tag| *tag < event);
        let tag = nothing.unwrap_or(event);
        if tag > run.engine.stop_tag() || tag == Tag::FOREVER {
            break;
        }
        if nothing.is_some() {
            emptied.push(pair_of(tag));
        } else {
            count += 1;
        }
        run.begin(tag);
        let mut messages = coming.remove(&pair_of(tag)).unwrap_or_default();
        let mut unknown: Vec<usize> = pieces.order.iter().copied().filter(|input| pieces.late[*input]).collect();
        let mut open = true;
        while open && !unknown.is_empty() {
            open = run.advance_below((AT_INPUTS + unknown.iter().min().unwrap()) as u16);
            let known = unknown.remove(0);
            if let Some(at) = messages.iter().position(|message| open && message.0 == known) {
                assert!(!run.deliver(messages.remove(at)), "there is room, and it is in time");
            }
        }
        if open {
            run.complete();
        }
    }
    let full = vec![false; plan.messages.len()];
    let mut outcome = run.outcome(full);
    let at_empty = |told: &NetworkMessage| emptied.contains(&told.0);
    assert!(outcome.told.iter().filter(|told| at_empty(told)).all(|told| told.2.is_none()));
    assert_eq!(outcome.told.iter().filter(|told| at_empty(told)).count(), emptied.len() * PORTS);
    outcome.told.retain(|told| !at_empty(told));
    outcome
}

fn action() -> impl Strategy<Value = ActionPlan> {
    (0..4i64, prop_oneof![Just(None), (0..6i64).prop_map(Some)], 0..4usize)
        .prop_map(|(min_delay, spacing, policy)| ActionPlan { min_delay, spacing, policy })
}

fn tag() -> impl Strategy<Value = TagPair> {
    (0..30i64, 0..3u32)
}

fn plan() -> impl Strategy<Value = Plan> {
    (
        any::<u64>(),
        prop::collection::vec((0..20i64, 0..9i64), TIMERS),
        prop::collection::vec(action(), ACTIONS),
        prop::collection::vec(0..7i64, PORTS),
        prop::collection::vec((0..INPUTS, tag(), any::<u32>()), 0..12),
        prop_oneof![Just(None), (0..60i64).prop_map(Some)],
    )
        .prop_map(|(seed, timers, actions, delays, messages, timeout)| Plan {
            seed,
            timers,
            actions,
            delays,
            messages,
            timeout,
        })
}

/// Returns a plan in which all messages fit into their queues, and no two are for one input and tag, as with one
/// sender.
fn quiet_plan() -> impl Strategy<Value = Plan> {
    plan().prop_map(|mut plan| {
        let mut kept: Vec<(usize, TagPair, u32)> = Vec::new();
        for message in plan.messages {
            let same = kept.iter().filter(|other| other.0 == message.0);
            if same.clone().count() < QUEUE_CAPACITY && !same.clone().any(|other| other.1 == message.1) {
                kept.push(message);
            }
        }
        plan.messages = kept;
        plan
    })
}

fn pieces() -> impl Strategy<Value = Pieces> {
    let order = Just((0..INPUTS).collect::<Vec<_>>()).prop_shuffle();
    (prop::collection::vec(any::<bool>(), INPUTS), order, prop::collection::vec(0..40i64, 0..6))
        .prop_map(|(late, order, empty)| Pieces { late, order, empty })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_engine_runs_random_programs_as_the_reference_does(plan in plan()) {
        prop_assert_eq!(run_whole(&plan), crate::reference::run(&plan, TAGS_MAX));
    }

    /// The events before the stop do not depend on when the stop becomes known.
    #[test]
    fn messages_after_the_stop_change_nothing_before_it(plan in quiet_plan(), timeout in 0..60i64) {
        let late = run_whole(&Plan { timeout: None, ..plan.clone() });
        let early = run_whole(&Plan { timeout: Some(timeout), ..plan });
        let Some(last) = early.trace.last().map(|step| step.0).filter(|_| !late.failed) else { return Ok(()) };
        // At the stop itself more may happen.
        let before = |outcome: &Outcome| outcome.trace.iter().copied().filter(|step| step.0 < last).collect::<Vec<_>>();
        prop_assert_eq!(before(&early), before(&late));
    }

    /// A tag that runs in pieces leaves the same trace as one for which all messages were there from the beginning.
    #[test]
    fn tags_in_pieces_are_as_whole_ones(plan in quiet_plan(), pieces in pieces()) {
        prop_assert_eq!(run_in_pieces(&plan, &pieces), crate::reference::run(&plan, TAGS_MAX));
    }
}
