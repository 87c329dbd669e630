// SPDX-License-Identifier: Apache-2.0
//! Checks what transient federates are sent and what they send through the RTI.

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
