// SPDX-License-Identifier: Apache-2.0
//! Proves that the engine runs random programs as a reference model does, event by event.
//!
//! The reference is a simulator in a few lines of std: one sorted map of events, looked at with no cleverness. The
//! programs have timers, logical actions with all spacing policies, ports, delayed connections, and network inputs;
//! what their reactions do is a function of a seed, so that both run the same. Queues are small, so that some fill up.
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, reason = "a test program has no users")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "small numbers"
)]
mod common;
mod reference;

use common::{Clock, Host};
use lf_model::{Engine, InputId, Interval, Progress, Settings, Storage, Tag};
use proptest::prelude::*;
use reference::program::RandomProgram;
use reference::{ACTIONS, ActionPlan, INPUTS, Outcome, PORTS, Plan, START, TIMERS, TagPair};

/// As many tags as are compared; random programs can go on without end.
const TAGS_MAX: usize = 200;

fn run_engine(plan: &Plan) -> Outcome {
    let mut program = RandomProgram::new(plan.clone());
    let mut host = Host::new(Clock::new_static(START));
    let mut storage: Storage<16, 1, 1, 1> = Storage::new();
    assert_eq!(program.tables.triggers.len(), 16, "the storage is that of the tables");
    let settings = Settings { timeout: plan.timeout.map(Interval), ..Settings::DEFAULT };
    let mut engine = Engine::new(program.tables, &mut storage, settings);
    engine.start(lf_model::Instant(START));
    let mut full = Vec::new();
    for &(input, (time, microstep), value) in &plan.messages {
        let tag = Tag::new(lf_model::Instant(START + time), lf_model::Microstep(microstep));
        let result = engine.deliver(&mut program, InputId(input as u16), tag, &u32::to_le_bytes(value));
        full.push(result.is_err());
    }
    let mut failed = false;
    for _ in 0..TAGS_MAX {
        let Some(tag) = engine.next_tag() else { break };
        engine.begin(&mut program, tag).unwrap();
        match engine.advance(&mut program, &mut host, None) {
            Progress::Complete => {}
            Progress::Failed(_) => failed = true,
            other => panic!("{other:?}"),
        }
    }
    Outcome { trace: program.trace, full, failed, done: engine.is_done() }
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_engine_runs_random_programs_as_the_reference_does(plan in plan()) {
        prop_assert_eq!(run_engine(&plan), reference::run(&plan, TAGS_MAX));
    }
}
