// SPDX-License-Identifier: Apache-2.0
//! Checks what transient federates are sent and what they send through the RTI, and what they hand over.

use lf_coordination::rti::Outcome;
use lf_model::time::Tag;

use super::Violation;
use crate::run::Report;
use crate::scenario::Scenario;

/// Checks that the RTI has forwarded every message to those that were there at its tag: from their first tag to the
/// last one at which a reaction ran.
pub(crate) fn passed(scenario: &Scenario, report: &Report) -> Option<Violation> {
    report.unpassed.iter().find_map(|message| {
        let to = scenario.instances_of(message.to).find(|instance| {
            let last = report.traces[*instance].last().map_or(Tag::NEVER, |record| record.tag);
            let first = report.first[*instance].unwrap_or(Tag::NEVER);
            let was_over = report.over[*instance].is_some_and(|over| over < message.read);
            (first..=last).contains(&message.tag) && !was_over
        })?;
        Some(Violation::NotPassed { from: message.from, to, tag: message.tag })
    })
}

/// Checks that an instance which takes the place of another one begins with the state of that, if the federate hands it
/// over.
pub(crate) fn handed_over(scenario: &Scenario, report: &Report) -> Option<Violation> {
    let instances = 0..scenario.instances.len();
    let invented = instances.clone().find(|instance| {
        let mut others = scenario.instances_of(scenario.instances[*instance]).filter(|other| other != instance);
        let taken = report.handovers[*instance].taken;
        taken.is_some() && !others.any(|other| report.handovers[other].last == taken)
    });
    let lost = instances.clone().find(|instance| {
        let has_begun = !report.traces[*instance].is_empty();
        let is_next = report.handovers[*instance].is_next && has_begun && report.first[*instance].is_some();
        // With exchanges of clocks, those that wait for their places are not known from the outside.
        is_next && scenario.target.clock_sync.is_none() && report.handovers[*instance].taken.is_none()
    });
    invented.or(lost).map(|instance| Violation::State { instance, taken: report.handovers[instance].taken })
}

/// Checks that an instance which leaves in order has a reason: its program or the RTI has ended it, or the federation
/// ends. An RTI that gives the federation up ends all.
pub(crate) fn reasons(scenario: &Scenario, report: &Report) -> Option<Violation> {
    let stop = report.stop_tag(scenario).filter(|_| report.rti == Some(Outcome::Complete))?;
    let leaves = |instance: &usize| {
        report.has_ended(*instance)
            && scenario.is_transient(*instance)
            && report.first[*instance].is_some()
            && !report.is_struck(*instance)
    };
    let mut instances = (0..scenario.instances.len()).filter(leaves);
    let left = instances.find(|instance| !report.may_leave[*instance] && report.completed[*instance] < stop)?;
    Some(Violation::Left { instance: left, completed: report.completed[left] })
}
