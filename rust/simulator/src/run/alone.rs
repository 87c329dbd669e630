// SPDX-License-Identifier: Apache-2.0
//! Runs the same program unfederated, as the reference of all federates.

use std::collections::BTreeMap;

use lf_compiler::plan::Plan;
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Env, ModelError, Outgoing, Outside, Program as _, Progress, SendError, Settings};

use super::federate::{EngineMemory, first_state};
use crate::program::{Played, Record, Runs, Scripted};
use crate::scenario::Scenario;
use lf_testkit::world::Side;

/// A program that runs this many tags does not end.
const TAGS_MAX: u32 = 10_000_000;

/// The decisions of the federated run, which are random to the program.
pub(crate) struct Decided<'a> {
    pub(crate) start: Instant,
    /// The instance that the program stands for, if it is one of a transient federate.
    pub(crate) joined: Option<Joined>,
    /// The granted stop.
    pub(crate) stop: Option<Tag>,
    /// The times of physical actions.
    pub(crate) played: &'a Played,
    /// The tag from which on nothing counts.
    pub(crate) until: Tag,
}

/// The beginning of an instance of a transient federate.
#[derive(Clone, Copy)]
pub(crate) struct Joined {
    pub(crate) instance: usize,
    pub(crate) first: Tag,
    /// The state that it has taken over.
    pub(crate) state: Option<u64>,
}

/// Runs the program with this plan, and returns the records of its reactions; `None` if a connection with `after` had
/// to hold more than it can.
pub(crate) fn run_alone(
    scenario: &Scenario,
    plan: &Plan,
    decided: &Decided<'_>,
    runs: Runs,
) -> Result<Option<Vec<Record>>, String> {
    let side = Side::keep(0, 0);
    let main = &plan.federates[0];
    let mut program =
        Scripted::new(scenario, plan, main, side, Some(decided.played), runs).map_err(|error| error.to_string())?;
    if let Some(Joined { instance, state, .. }) = decided.joined {
        program.set_states(first_state(scenario, instance));
        let name = format!("f{}", scenario.instances[instance]);
        let place = main.instances.iter().position(|instance| instance.path == name);
        if let (Some(place), Some(state)) = (place, state) {
            program.set_state(place, state);
        }
    }
    let settings = Settings {
        federated: false,
        timeout: plan.target.timeout_ns.map(Interval::from_nanos),
        keepalive: false,
        fast: true,
    };
    let tables = program.tables();
    let mut memory = EngineMemory::new(tables);
    let mut engine = memory.engine(tables, settings);
    let mut world = Still(side);
    match decided.joined {
        Some(Joined { first, .. }) => engine.join(decided.start, first),
        None => engine.start(decided.start),
    }
    if let Some(stop) = decided.stop {
        engine.set_stop_tag(stop);
    }
    for _ in 0..TAGS_MAX {
        if engine.is_done() {
            return Ok(Some(program.trace));
        }
        engine.drain_physical(&mut program, &world);
        let Some(tag) = engine.next_tag() else {
            engine.stop_if_idle(&world);
            continue;
        };
        if tag >= decided.until {
            return Ok(Some(program.trace));
        }
        engine.begin(&mut program, tag).map_err(|error| error.to_string())?;
        match engine.advance(&mut program, &mut world, None) {
            // The values that federates hold in their buffers are all in one queue in this run.
            Progress::Failed(ModelError::DelayFull { .. }) => return Ok(None),
            Progress::Failed(error) => return Err(error.to_string()),
            Progress::Complete | Progress::OutputFull { .. } | Progress::LevelLimit { .. } => {}
        }
    }
    Err(format!("unfederated the program goes on after {TAGS_MAX} tags"))
}

/// The host of a program without neighbors, in which time does not matter.
struct Still(&'static Side);

impl Env for Still {
    fn outside(&self) -> &'static dyn Outside {
        self.0
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        Ok(())
    }
}

/// Returns the work of each federate's reactions, in nanoseconds: by time after the start, of each tag at that time.
/// Physical actions happen as they did after this start. Returns `None` if the program cannot be run.
pub(crate) fn work_alone(
    scenario: &Scenario,
    plan: &Plan,
    start: Instant,
    played: &Played,
) -> Option<Vec<BTreeMap<i64, Vec<i64>>>> {
    let decided = Decided { start, joined: None, stop: None, played, until: Tag::FOREVER };
    let trace = run_alone(scenario, plan, &decided, Runs::OneByOne).ok()??;
    work(scenario, start, trace.iter())
}

/// Returns the work in these records in the same form.
pub(super) fn work<'r>(
    scenario: &Scenario,
    start: Instant,
    trace: impl Iterator<Item = &'r Record>,
) -> Option<Vec<BTreeMap<i64, Vec<i64>>>> {
    let mut tags: Vec<BTreeMap<Tag, i64>> = vec![BTreeMap::new(); scenario.federates.len()];
    for record in trace {
        *tags.get_mut(record.instance.federate)?.entry(record.tag).or_default() +=
            i64::try_from(record.work_ns).ok()?;
    }
    let by_time = move |tags: BTreeMap<Tag, i64>| {
        let mut work: BTreeMap<i64, Vec<i64>> = BTreeMap::new();
        for (tag, ns) in tags {
            work.entry(tag.time.as_nanos() - start.as_nanos()).or_default().push(ns);
        }
        work
    };
    Some(tags.into_iter().map(by_time).collect())
}
