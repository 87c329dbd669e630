// SPDX-License-Identifier: Apache-2.0
//! The waits of the federates of a scenario: long enough for all delays of a message there, or not.
//!
//! The bounds are those of the scenario's world, and a run of the unfederated program shows the work of reactions. The
//! waits follow as in `lf_compiler::maxwait`, except for the lag of a federate with much work.

use std::collections::BTreeMap;

use lf_model::time::Instant;
use lf_runtime::platform::Platform as _;
use lf_testkit::random::{Random, combine};

use crate::compile::compile_text;
use crate::program::CAPACITY_MAX;
use crate::run::{OutputOptions, Report, run, work_alone};
use crate::scenario::{Connection, Form, Host, MS, Nanos, SEC, Scenario, US, source};
use crate::world::Virtual;

/// The longest duration of a scenario, in virtual time.
const LONGEST: Nanos = 5 * SEC;
/// A time later than the end of any wait.
const FOREVER: Nanos = Nanos::MAX / 4;
/// Turns of the event loop for one tag: the time has come, input was read, no more input was read.
const TURNS_PER_TAG: Nanos = 6;
/// The number of turns for all other work at one time.
const TURNS_BESIDES: Nanos = 40;
/// The maximum number of bytes of a message, and the number of messages without room in their queues that the buffers
/// between two federates hold in scenarios whose waits suffice.
const MESSAGE: usize = 360;
const BUFFERED: usize = 1 << 16;
/// The maximum number of bytes in one write.
const PIECE: Nanos = 6_000;

/// Sets the waits of a scenario. If none are long enough, it becomes one with waits that are too short.
pub(crate) fn assign(scenario: &mut Scenario) {
    let before = scenario.clone();
    assign_with(scenario, None);
    // A run shows the times of physical actions, though they may differ in the next run.
    if scenario.decentralized.is_some_and(|it| it.is_safe)
        && scenario.work_depends_on_the_run()
        && let Ok(plan) = compile_text(&source(scenario, Form::Federated))
        && let Ok(report) = run(scenario, &plan, OutputOptions::default())
    {
        *scenario = before;
        assign_with(scenario, Some(&report));
    }
}

/// Returns whether the waits of a scenario sufficed for the physical actions of its run.
pub(crate) fn suffice(scenario: &Scenario, report: &Report) -> bool {
    Bounds::of(scenario, Some(report)).is_some_and(|bounds| {
        let mut roomy = scenario.clone();
        bounds.are_kept(scenario) && bounds.make_room(&mut roomy) && roomy == *scenario
    })
}

fn assign_with(scenario: &mut Scenario, report: Option<&Report>) {
    let Some(mut decentralized) = scenario.decentralized else { return };
    let mut random = Random::new(combine(scenario.seed, 22));
    let absences: Vec<_> = scenario
        .connections
        .iter()
        .map(|_| if random.percent(40) { Some(random.one_of(&[0, 1, 100 * US, MS])) } else { None })
        .collect();
    for (connection, absent_after) in scenario.connections.iter_mut().zip(absences) {
        connection.absent_after = absent_after;
    }
    let grouped: Vec<_> = scenario.federates.iter().map(|_| random.percent(50)).collect();
    let (mut needed, mut bounds) = (None, None);
    for _ in 0..4 {
        bounds = Bounds::of(scenario, report);
        let Some(bounds) = &mut bounds else { break };
        if report.is_some() {
            bounds.widen();
        }
        needed = bounds.needed(scenario, &grouped);
        if needed.is_some() || !decentralized.is_safe {
            break;
        }
        bounds.lengthen_cycles(scenario, &mut random);
    }
    decentralized.is_safe &= needed.is_some();
    let needed = needed.unwrap_or_else(|| vec![random.one_of(&[100 * US, MS, 5 * MS]); scenario.connections.len()]);
    if decentralized.is_safe {
        wait_enough(scenario, &needed, &grouped, &mut random);
        decentralized.is_safe = bounds.is_some_and(|bounds| bounds.make_room(scenario));
    } else {
        for (connection, needed) in scenario.connections.iter_mut().zip(&needed) {
            let share = random.one_of(&[0, 0, 1, 10, 50, 90]);
            connection.max_wait = Some(needed / 100 * share);
        }
        scenario.align_waits();
    }
    scenario.decentralized = Some(decentralized);
}

/// Makes all waits as long as needed, and some infinite where no message has to arrive.
fn wait_enough(scenario: &mut Scenario, needed: &[Nanos], grouped: &[bool], random: &mut Random) {
    let count = scenario.federates.len();
    let mut forever: Vec<_> = (0..count).map(|_| random.percent(4)).collect();
    if crate::scenario::has_cycle(count, &scenario.connections, false) {
        forever.fill(false);
    }
    // A receiver of a federate that waits without end has to wait without end, too.
    for _ in 0..count {
        for one in &scenario.connections {
            forever[one.to.0] |= forever[one.from.0];
        }
    }
    for (connection, needed) in scenario.connections.iter_mut().zip(needed) {
        let to = connection.to.0;
        if forever[to] {
            continue;
        }
        if grouped[to] {
            scenario.federates[to].max_wait = scenario.federates[to].max_wait.max(Some(*needed));
        } else {
            connection.max_wait = Some(*needed);
        }
    }
}

/// The bounds of all delays of a message in a scenario.
struct Bounds {
    /// By federate: the time from the earliest begin of a tag until it has sent the messages of the tag.
    lag: Vec<Nanos>,
    /// By connection: the time from sending until the receiver sees the message, and the difference between the clocks.
    flight: Vec<Nanos>,
    /// By federate: the number of its tags at each time after the start.
    tags: Vec<BTreeMap<Nanos, usize>>,
}

impl Bounds {
    /// Returns the bounds; `None` if the program cannot be run.
    fn of(scenario: &Scenario, report: Option<&Report>) -> Option<Self> {
        let hosts = &scenario.conditions.hosts;
        let work = match report {
            // Those who come and go do their work at other times.
            Some(report) if scenario.has_transients() => report.work(scenario)?,
            _ => {
                let plan = compile_text(&source(scenario, Form::Alone)).ok()?;
                let start = report.map_or(Some(Instant::from_nanos(0)), Report::started);
                work_alone(scenario, &plan, start?, &report.map(Report::all_played).unwrap_or_default())?
            }
        };
        let lags: Vec<_> = work.iter().zip(&hosts[1..]).map(|(work, host)| behind(work, host)).collect();
        let busy: Vec<_> = work.iter().zip(&lags).map(|(work, lag)| longest_turn(work).max(*lag)).collect();
        let asks = |federate: &crate::scenario::Reactor| {
            federate.reactions.iter().any(|reaction| reaction.script.stop_at.is_some())
        };
        // A federate that has proposed a stop tag waits for the answers of all others, which may be busy.
        let answer = |host: &Host| 4 * (flight(host) + TURNS_BESIDES * turn(host));
        let stop = if scenario.federates.iter().any(asks) {
            hosts.iter().map(answer).max().unwrap_or(0) + 2 * lags.iter().copied().max().unwrap_or(0)
        } else {
            0
        };
        let between = |one: &Connection| {
            let (from, to) = (&hosts[one.from.0 + 1], &hosts[one.to.0 + 1]);
            flight(from) + clock_error(scenario, from, to) + busy[one.to.0]
        };
        let flight = scenario.connections.iter().map(between).collect();
        let count = |work: &BTreeMap<Nanos, Vec<Nanos>>| work.iter().map(|(time, tags)| (*time, tags.len())).collect();
        let tags = work.iter().map(count).collect();
        Some(Self { lag: lags.iter().map(|lag| lag + stop).collect(), flight, tags })
    }

    /// Allows for other physical actions in the next run.
    fn widen(&mut self) {
        for time in self.lag.iter_mut().chain(&mut self.flight) {
            *time += *time / 2;
        }
    }

    /// Returns whether all waits are long enough.
    fn are_kept(&self, scenario: &Scenario) -> bool {
        let wait = |one: &Connection| one.max_wait.or(scenario.federates[one.to.0].max_wait).unwrap_or(FOREVER);
        let release = |federate: usize| {
            let into = scenario.connections.iter().filter(|one| one.to.0 == federate);
            let absent = |one: &Connection| (one.absent_after.unwrap_or(0) - one.after.unwrap_or(0)).max(0);
            into.map(|one| wait(one) + absent(one)).max().unwrap_or(0)
        };
        scenario.connections.iter().zip(&self.flight).all(|(one, flight)| {
            let sent = release(one.from.0) + self.lag[one.from.0] - one.after.unwrap_or(0);
            wait(one) == FOREVER || wait(one) >= sent + flight
        })
    }

    /// Returns, by connection, the wait that its receiver needs; `None` if a cycle makes it infinite.
    fn needed(&self, scenario: &Scenario, grouped: &[bool]) -> Option<Vec<Nanos>> {
        let connections = &scenario.connections;
        let count = scenario.federates.len();
        let mut waits = vec![0; connections.len()];
        // By federate: the longest time after a tag's time that the last reaction may have to wait.
        let mut release = vec![0; count];
        for _ in 0..=count {
            let before = (waits.clone(), release.clone());
            for (index, one) in connections.iter().enumerate() {
                let sent = release[one.from.0] + self.lag[one.from.0] - one.after.unwrap_or(0);
                waits[index] = (sent + self.flight[index]).max(0);
            }
            for to in (0..count).filter(|to| grouped[*to]) {
                let into = || connections.iter().enumerate().filter(|(_, one)| one.to.0 == to).map(|(index, _)| index);
                let most = into().map(|index| waits[index]).max().unwrap_or(0);
                into().for_each(|index| waits[index] = most);
            }
            for (index, one) in connections.iter().enumerate() {
                let absent = (one.absent_after.unwrap_or(0) - one.after.unwrap_or(0)).max(0);
                release[one.to.0] = release[one.to.0].max(waits[index] + absent);
            }
            if before == (waits.clone(), release.clone()) {
                return Some(waits);
            }
        }
        None
    }

    /// Makes the queues large enough for the messages that arrive while a federate waits. Messages that exceed its
    /// queues and buffers would block their senders, whose other messages would then be late. Returns `false` if the
    /// queues would become too large.
    fn make_room(&self, scenario: &mut Scenario) -> bool {
        let count = scenario.federates.len();
        for (from, to) in (0..count).flat_map(|from| (0..count).map(move |to| (from, to))) {
            let wait = longest_wait(scenario, to) + self.lag[to];
            let coming = |one: &Connection| most_within(&self.tags[from], wait + one.after.unwrap_or(0));
            let joining = || scenario.connections.iter().filter(|one| (one.from.0, one.to.0) == (from, to));
            if joining().map(coming).sum::<usize>() * MESSAGE <= BUFFERED {
                continue;
            }
            if joining().map(coming).any(|messages| messages > CAPACITY_MAX) {
                return false;
            }
            for one in scenario.connections.iter_mut().filter(|one| (one.from.0, one.to.0) == (from, to)) {
                one.capacity = one.capacity.max(Some(coming(one)));
            }
        }
        true
    }

    /// Adds to each connection with a delay as much as any cycle can need.
    fn lengthen_cycles(&self, scenario: &mut Scenario, random: &mut Random) {
        let absences = scenario.connections.iter().map(|one| one.absent_after.unwrap_or(0)).sum::<Nanos>();
        let needed = self.lag.iter().sum::<Nanos>() + self.flight.iter().sum::<Nanos>() + absences;
        for connection in &mut scenario.connections {
            if let Some(after) = connection.after.filter(|after| *after >= MS) {
                connection.after = Some(after.max(needed + random.one_of(&[0, 1, MS])));
                // The messages in transit during such a delay may exceed the default queue.
                connection.capacity = connection.capacity.or(Some(512));
            }
        }
    }
}

/// Returns the longest wait of a federate before a tag and in it.
fn longest_wait(scenario: &Scenario, federate: usize) -> Nanos {
    let into = scenario.connections.iter().filter(|one| one.to.0 == federate);
    let wait = |one: &Connection| {
        one.max_wait.or(scenario.federates[federate].max_wait).unwrap_or(LONGEST) + one.absent_after.unwrap_or(0)
    };
    into.map(wait).max().unwrap_or(0)
}

/// Returns the maximum number of these tags within a time.
fn most_within(tags: &BTreeMap<Nanos, usize>, within: Nanos) -> usize {
    let (mut most, mut held) = (0, 0);
    let mut first = tags.iter().peekable();
    for (time, count) in tags {
        held += count;
        while let Some((_, gone)) = first.next_if(|(earlier, _)| *time - **earlier > within) {
            held -= gone;
        }
        most = most.max(held);
    }
    most
}

/// Returns the duration of one turn of an event loop, with the delay of the wake-up.
fn turn(host: &Host) -> Nanos {
    host.turn_ns + host.wake_ns
}

/// Returns the time from a write to its arrival.
fn flight(host: &Host) -> Nanos {
    let link = &host.link;
    let jitter = if link.slow_percent > 0 { 10 * link.jitter } else { link.jitter };
    link.latency + jitter + link.ns_per_byte * PIECE
}

/// Returns the maximum difference between two clocks.
fn clock_error(scenario: &Scenario, one: &Host, other: &Host) -> Nanos {
    let drift = |host: &Host| host.clock_drift_ppb.abs() * (LONGEST / SEC);
    if scenario.target.clock_sync.is_none() {
        return (one.clock_offset - other.clock_offset).abs() + drift(one) + drift(other);
    }
    // The error of an exchange is half the difference of its two latencies, turns of both sides included.
    let rti = &scenario.conditions.hosts[0];
    let sync = |host: &Host| flight(host) + TURNS_PER_TAG * (turn(host) + turn(rti)) + drift(host) + drift(rti);
    // With continuous rounds, the extrapolated line through past exchanges may have a larger error.
    let line = if scenario.target.rounds.is_some() { 4 } else { 1 };
    line * (sync(one) + sync(other))
}

/// Returns the maximum lag of a federate that does this work at these times.
fn behind(work: &BTreeMap<Nanos, Vec<Nanos>>, host: &Host) -> Nanos {
    let (mut through, mut most) = (0, 0);
    for (time, tags) in work {
        for work in tags {
            through = through.max(*time) + work + TURNS_PER_TAG * turn(host);
            most = most.max(through - time);
        }
    }
    most + TURNS_BESIDES * turn(host)
}

/// Returns the longest turn of a federate's event loop that does this work at these times. It reads input that arrives
/// meanwhile only after the turn.
fn longest_turn(work: &BTreeMap<Nanos, Vec<Nanos>>) -> Nanos {
    Virtual::TURN_TIME.as_nanos() + work.values().flatten().max().unwrap_or(&0)
}
