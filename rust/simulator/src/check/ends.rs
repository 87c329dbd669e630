// SPDX-License-Identifier: Apache-2.0
//! Checks that all participants end as they must: in order and at one tag, or, after a fault, as the RTI was configured
//! to handle it.

use lf_coordination::rti::Outcome;
use lf_model::ModelError;
use lf_model::time::Tag;
use lf_runtime::{PeerFault, RunError};

use super::{Sent, Violation};
use crate::run::{FederateEnd, Report};
use crate::scenario::{Connection, Reactor, Scenario};

/// A receive buffer beyond this size holds all that can arrive within the RTI's window.
const AMPLE: usize = 1 << 15;

/// The longest time that a failed federate tries to inform others, with a margin. They go on meanwhile.
const LAST_WORDS_NS: u64 = 2_000_000_000;

/// Checks the ends of all participants. Returns nothing if the program itself is at fault because it exceeds one of its
/// capacities.
pub(crate) fn ends(scenario: &Scenario, report: &Report) -> Option<Violation> {
    if own_fault(report) {
        return None;
    }
    stop_tags(scenario, report).or_else(|| results(scenario, report))
}

/// Returns whether a queue inside a federate was too small, which is independent of the federation.
pub(crate) fn own_fault(report: &Report) -> bool {
    report.ends.iter().any(|end| {
        matches!(
            end,
            FederateEnd::Ended(Err(RunError::Model(ModelError::ActionFull { .. } | ModelError::DelayFull { .. })))
        )
    })
}

/// Returns whether a run has no end because nothing ends it: the program ends by a stop only, and a queue was too small
/// in a federate that was to request it.
pub(crate) fn is_endless(scenario: &Scenario, report: &Report, violation: &Violation) -> bool {
    let asks = |instance: usize| {
        scenario.federates[scenario.instances[instance]].reactions.iter().any(|one| one.script.stop_at.is_some())
    };
    let is_full = |end: &FederateEnd| {
        let FederateEnd::Ended(Err(error)) = end else { return false };
        matches!(error, RunError::Model(_) | RunError::InputFull { .. } | RunError::TagFull { .. })
    };
    let has_lost_its_end = || (0..).zip(&report.ends).any(|(federate, end)| asks(federate) && is_full(end));
    matches!(violation, Violation::NoEnd { .. })
        && scenario.target.timeout.is_none()
        && report.granted_stop().is_none()
        && has_lost_its_end()
}

/// Returns whether some input's queue and buffer may be too small for its messages: the queue has a given capacity, or
/// the number of messages that its delay keeps in transit is unknown, because the rate of the source is.
fn is_tight(scenario: &Scenario) -> bool {
    let may_be_small = |connection: &Connection| {
        let source = &scenario.federates[connection.from.0];
        let is_rate_known = source.inputs.is_empty() && has_no_actions(source) && !source.transient;
        connection.capacity.is_some() || connection.after.is_some_and(|after| after > 0) && !is_rate_known
    };
    scenario.connections.iter().any(may_be_small) && scenario.conditions.receive_spare < AMPLE
}

fn has_no_actions(reactor: &Reactor) -> bool {
    let is_regular = reactor.actions.is_empty() && reactor.watchdogs.is_empty() && reactor.modes == 0;
    is_regular && reactor.children.iter().all(has_no_actions)
}

/// Returns whether a federate rightly gave up another one that had no room for a minute: because that one could not
/// send either, and so on in a circle, in which none can ever go on. Then all queues on the way are too small for the
/// program's messages.
fn waits_for_circle(scenario: &Scenario, report: &Report, federate: usize, blocked: usize) -> bool {
    let Some(ended) = report.ended[federate] else { return false };
    let before = ended.saturating_sub(LAST_WORDS_NS);
    let stop = report.stop_tag(scenario).unwrap_or(Tag::FOREVER);
    let is_full = |to: usize, port: usize| {
        let came = |sent: &&Sent| sent.to == to && sent.port == port && sent.arrives <= before && sent.tag <= stop;
        let handled = report.lateness[to].handled.get(port).map_or(&[][..], |handled| handled);
        let handled = handled.iter().filter(|it| it.at <= before).count();
        report.sent.iter().filter(came).count() >= handled + report.capacities[to][port]
    };
    let is_held_up = |from: usize, to: usize| {
        let senders = report.senders[to].iter().enumerate();
        senders.filter(|(_, sender)| **sender == from).any(|(port, _)| is_full(to, port))
    };
    // Follows the waits of the federates that others wait for.
    let reached = |first: usize| {
        let (mut open, mut seen) = (vec![first], Vec::new());
        while let Some(from) = open.pop() {
            for to in (0..report.ends.len()).filter(|to| is_held_up(from, *to)) {
                if !seen.contains(&to) {
                    seen.push(to);
                    open.push(to);
                }
            }
        }
        seen
    };
    is_held_up(federate, blocked) && reached(federate).iter().any(|one| reached(*one).contains(one))
}

/// Checks that every federate's last tag is that of the timeout or of the granted stop.
fn stop_tags(scenario: &Scenario, report: &Report) -> Option<Violation> {
    let expected = report.stop_tag(scenario)?;
    let early = scenario.target.timeout.is_none();
    for (federate, trace) in report.traces.iter().enumerate() {
        // A transient federate can stop alone, and one that comes after the end has one tag.
        if scenario.is_transient(federate) || report.left_before_stop(federate) {
            continue;
        }
        for record in trace.iter().filter(|record| record.last_tag) {
            let stopped = record.tag;
            // Without a timeout, a federate without events ends before the others stop.
            if stopped > expected || (stopped < expected && !early) {
                return Some(Violation::StopTag { federate, stopped, expected });
            }
        }
    }
    let asked = report.stops.iter().copied().min().unwrap_or(Tag::FOREVER);
    let granted = report.granted_stop()?;
    (granted < asked).then_some(Violation::StopTag { federate: 0, stopped: granted, expected: asked })
}

/// Returns whether the outcome is the failure of an instance of a transient federate that was struck before it ended,
/// so that its reason is unknown.
fn may_have_failed(scenario: &Scenario, report: &Report, outcome: &Outcome) -> bool {
    let Outcome::Lost { federate, .. } = outcome else { return false };
    let mut instances = scenario.instances_of(usize::from(federate.0));
    instances.any(|instance| scenario.is_transient(instance) && report.is_struck(instance))
}

fn results(scenario: &Scenario, report: &Report) -> Option<Violation> {
    let rti_is_struck = report.struck.iter().any(|(participant, _)| *participant == 0);
    let is_lost = report.struck_persistent(scenario).is_some();
    let stop_all = scenario.conditions.rti.stop_all_after_loss && is_lost;
    let mut full = false;
    for (federate, end) in report.ends.iter().enumerate() {
        let FederateEnd::Ended(Err(error)) = end else { continue };
        if let RunError::InputFull { .. } | RunError::TagFull { .. } = error {
            let burst = report.bursts[federate].iter().zip(&report.capacities[federate]).any(|(most, it)| most > it);
            let is_full = matches!(error, RunError::InputFull { .. });
            if !(burst || is_full && is_tight(scenario)) {
                return Some(Violation::InputFull { federate, how: error.to_string() });
            }
            full = true;
        }
        if let RunError::Peer { federate: blocked, fault: PeerFault::Blocked } = error {
            full |= waits_for_circle(scenario, report, federate, usize::from(*blocked));
        }
    }
    for (federate, end) in report.ends.iter().enumerate() {
        let struck = report.struck.iter().any(|(participant, _)| *participant == federate + 1);
        let FederateEnd::Ended(Err(error)) = end else { continue };
        // One that comes too late, or while too many others come, finds no place.
        let is_left_out = scenario.is_transient(federate) && report.first[federate].is_none();
        if !(struck || rti_is_struck || stop_all || full || is_left_out) {
            return Some(Violation::End { federate: Some(federate), how: error.to_string() });
        }
    }
    match &report.rti {
        Some(Outcome::Complete) | None => None,
        Some(outcome) if !is_lost && !full && !may_have_failed(scenario, report, outcome) => {
            Some(Violation::End { federate: None, how: format!("{outcome:?}") })
        }
        Some(_) => None,
    }
}
