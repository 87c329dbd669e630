// SPDX-License-Identifier: Apache-2.0
//! Checks decentralized coordination: a federate counts and reports every message that it handles later than intended,
//! no message that arrived in time is late, none is lost, and the messages of one connection are handled in order.

use std::collections::{BTreeMap, VecDeque};

use lf_compiler::plan::{Federate, Plan};
use lf_model::time::{Interval, Tag};

use super::Violation;
use super::direct::Sent;
use crate::program::Handled;
use crate::run::{Lateness, Report};
use crate::scenario::Scenario;

/// The numbers of messages of a run by outcome.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LateCounts {
    /// Messages in time.
    pub(crate) in_time: u64,
    /// Messages in time, a microstep after another one with the same tag.
    pub(crate) bursts: u64,
    /// Late messages.
    pub(crate) late: u64,
    /// Messages that were late because the previous one was.
    pub(crate) behind: u64,
    /// Messages so late that they were not handled.
    pub(crate) lost: u64,
    /// Messages whose senders report that the receivers had left.
    pub(crate) undelivered: u64,
    /// Messages that were not handled because they arrived after their receiver had announced its end.
    pub(crate) after_end: u64,
}

/// Checks the outcomes of all messages between federates.
pub(crate) fn late(scenario: &Scenario, plan: &Plan, report: &Report) -> (LateCounts, Option<Violation>) {
    let mut counts = LateCounts::default();
    let mut violation = None;
    for (federate, lateness) in report.lateness.iter().enumerate() {
        // A transient receiver may leave at any time.
        let of = scenario.instances[federate];
        let mut sent = scenario.connections.iter().filter(|connection| connection.from.0 == of);
        let may_lose = sent.any(|connection| scenario.federates[connection.to.0].transient);
        if lateness.lost > 0
            && !may_lose
            && (0..report.ends.len()).all(|one| report.has_ended(one))
            && report.struck.is_empty()
        {
            violation = violation.or(Some(Violation::Lost { federate, messages: lateness.lost }));
        }
        counts.undelivered += lateness.lost;
        if report.has_ended(federate) {
            let mut receiver = Receiver { scenario, plan, report, federate, lateness, counts: &mut counts };
            violation = violation.or_else(|| receiver.check());
        }
    }
    (counts, violation)
}

/// Returns whether no message was late that a transient federate has sent or received, as is allowed when it comes or
/// goes. What such a message causes is late, too.
pub(crate) fn comings_are_in_time(scenario: &Scenario, report: &Report) -> bool {
    report.lateness.iter().enumerate().all(|(instance, lateness)| {
        let mut inputs = lateness.handled.iter().zip(&report.senders[instance]);
        inputs.all(|(handled, sender)| {
            let is_fleeting = scenario.is_transient(instance) || scenario.is_transient(*sender);
            !is_fleeting || handled.iter().all(|message| message.intended.is_none())
        })
    })
}

struct Receiver<'a> {
    scenario: &'a Scenario,
    plan: &'a Plan,
    report: &'a Report,
    federate: usize,
    lateness: &'a Lateness,
    counts: &'a mut LateCounts,
}

/// The number of messages that have to be counted, and of further ones that may be.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    must: u64,
    may: u64,
    /// Those for which some reaction has no handler.
    unhandled: u64,
}

/// The outcome of the previous message.
#[derive(Clone, Copy)]
struct Before {
    expected: Tag,
    is_late: bool,
}

/// The messages to an input, of each instance of the sender in the order in which it has sent them. One that does not
/// wait for physical time can have sent messages for tags that the next one reaches, too, so either can be the first.
struct Incarnations<'r> {
    messages: Vec<VecDeque<&'r Sent>>,
}

impl<'r> Incarnations<'r> {
    fn new(sent: impl Iterator<Item = &'r Sent>, first: impl Fn(&Sent) -> Option<Tag>) -> Self {
        let mut incarnations: BTreeMap<_, VecDeque<&Sent>> = BTreeMap::new();
        for message in sent {
            incarnations.entry((first(message), message.from)).or_default().push_back(message);
        }
        Self { messages: incarnations.into_values().collect() }
    }

    /// Takes the message that was handled next, if one of the instances has sent that as its next one; else the next
    /// one of the first instance, which was not handled.
    fn next(&mut self, handled: Option<&Handled>) -> Option<(&'r Sent, Option<Handled>)> {
        self.messages.retain(|incarnation| !incarnation.is_empty());
        let is_handled = |incarnation: &VecDeque<&Sent>| {
            let number = incarnation.front().map(|message| message.number);
            handled.is_some_and(|handled| Some(handled.value.number()) == number)
        };
        let index = self.messages.iter().position(is_handled);
        let found = handled.filter(|_| index.is_some()).copied();
        let message = self.messages.get_mut(index.unwrap_or_default())?.pop_front()?;
        Some((message, found))
    }
}

impl Receiver<'_> {
    fn check(&mut self) -> Option<Violation> {
        let federate = self.federate;
        if let Some(tag) = self.lateness.mishandled {
            return Some(Violation::Mishandled { federate, tag });
        }
        let mut due = Due::default();
        for port in 0..self.lateness.handled.len() {
            match self.check_input(port) {
                Ok(more) => {
                    due.must += more.must;
                    due.may += more.may;
                    due.unhandled += more.unhandled;
                }
                Err(violation) => return Some(violation),
            }
        }
        let (counted, reports) = (self.lateness.counted, self.lateness.reports);
        let fits = (due.must..=due.must + due.may).contains(&counted);
        // The first message is reported as a warning, the tenth, the hundredth, and so on.
        let warnings = due.unhandled.checked_ilog10().map_or(0, |digits| u64::from(digits) + 1);
        let is_logged = reports.all == counted && reports.warnings >= warnings;
        (!fits || !is_logged).then_some(Violation::Unreported {
            federate,
            late: due.must,
            counted,
            reported: reports.all,
            warnings: reports.warnings,
        })
    }

    fn check_input(&mut self, port: usize) -> Result<Due, Violation> {
        let (federate, report) = (self.federate, self.report);
        let handled = &self.lateness.handled[port];
        let mut happened = handled.iter();
        let mut due = Due::default();
        let mut before: Option<Before> = None;
        let sent = report.sent.iter().filter(|sent| sent.to == federate && sent.port == port);
        let mut incarnations = Incarnations::new(sent, |message| report.first[message.from]);
        while let Some((message, found)) = incarnations.next(happened.as_slice().first()) {
            let after_last = before.map(|before| before.expected).filter(|expected| *expected >= message.tag);
            let expected = after_last.map_or(message.tag, Tag::next_microstep);
            let is_fleeting = self.scenario.is_transient(federate) || self.scenario.is_transient(message.from);
            let may_miss = report.is_struck(message.from) || report.is_struck(federate) || is_fleeting;
            if found.is_none() && may_miss {
                // The message was in transit, or had been written in part, or came when nobody was there.
                due.may += 1;
                continue;
            }
            let was_late = before.is_some_and(|before| before.is_late);
            let is_late = match found {
                Some(found) => {
                    happened.next();
                    self.place(port, message, &found, expected)?
                }
                None => self.missing(port, message, expected, &mut due)?,
            };
            if is_late && !was_late && !is_fleeting && expected == message.tag && self.is_timely(port, message) {
                let (sent, happened) = (message.tag, found.map(|found| found.tag));
                return Err(Violation::LateThoughInTime { federate, port, sent, happened });
            }
            if let Some(found) = found {
                due.must += u64::from(is_late);
                due.unhandled += u64::from(is_late && !self.has_handlers(port));
                self.counts.late += u64::from(is_late);
                self.counts.behind += u64::from(is_late && was_late);
                self.counts.in_time += u64::from(!is_late);
                self.counts.bursts += u64::from(!is_late && found.tag > message.tag);
            }
            before = Some(Before { expected, is_late });
        }
        match happened.next() {
            Some(other) => Err(Violation::Order { federate, port, tag: other.tag }),
            None => Ok(due),
        }
    }

    /// Checks a message that was handled. Returns whether it was late.
    fn place(&self, port: usize, message: &Sent, found: &Handled, expected: Tag) -> Result<bool, Violation> {
        let federate = self.federate;
        let is_late = found.tag > expected;
        let is_said = match found.intended {
            Some(intended) => is_late && (message.tag..=expected).contains(&intended),
            None => !is_late,
        };
        if found.tag < expected || !is_said {
            let (sent, happened, intended) = (message.tag, found.tag, found.intended);
            return Err(Violation::Misplaced { federate, port, sent, happened, intended });
        }
        if is_late && self.is_safe_from(message.from) {
            let (sent, happened) = (message.tag, Some(found.tag));
            return Err(Violation::LateThoughBounded { federate, port, sent, happened });
        }
        Ok(is_late)
    }

    /// Checks a message that was not handled. Returns whether it was late.
    fn missing(&mut self, port: usize, message: &Sent, expected: Tag, due: &mut Due) -> Result<bool, Violation> {
        let federate = self.federate;
        let stop = self.report.stop_tag(self.scenario).unwrap_or(Tag::FOREVER);
        if expected > stop {
            due.may += 1;
            return Ok(true);
        }
        if self.is_safe() {
            return Err(Violation::LateThoughBounded { federate, port, sent: message.tag, happened: None });
        }
        self.counts.lost += 1;
        self.counts.after_end += u64::from(self.report.left[federate].is_some_and(|left| message.arrives > left));
        due.must += 1;
        // A message that was to be handled late, but for a stop in between, counts as handled where it would have been.
        due.unhandled += u64::from(!self.has_handlers(port));
        Ok(true)
    }

    /// Returns whether no message of an instance may be late, at any tag. One that comes is not waited for before.
    fn is_safe_from(&self, sender: usize) -> bool {
        self.is_safe() && !self.scenario.is_transient(self.federate) && !self.scenario.is_transient(sender)
    }

    /// Returns whether all waits are long enough.
    fn is_safe(&self) -> bool {
        self.scenario.decentralized.is_some_and(|it| it.is_safe)
    }

    /// Returns whether a message arrived before the wait for it could end. No reaction handles it beyond the last tag.
    fn is_timely(&self, port: usize, message: &Sent) -> bool {
        let is_beyond = self.report.stop_tag(self.scenario).is_some_and(|stop| message.tag > stop);
        let input = &self.planned().inputs[port];
        // Bytes that stay in a socket because a buffer is full may be read too late.
        let ample = self.scenario.decentralized.is_some_and(|it| it.peer_spare >= 1 << 16);
        let Some(there) = (if ample { Some(message.arrives) } else { message.read }) else { return false };
        let there = self.report.sides[self.federate + 1].physical_at(there);
        let wait = Interval::from_nanos(input.max_wait_ns);
        !is_beyond && (wait == Interval::FOREVER || there <= message.tag.time + wait)
    }

    fn planned(&self) -> &Federate {
        &self.plan.federates[self.scenario.instances[self.federate]]
    }

    /// Returns whether every reaction that an input triggers has a handler.
    fn has_handlers(&self, port: usize) -> bool {
        let federate = self.planned();
        let trigger = &federate.triggers[federate.inputs[port].trigger.0];
        let lf_compiler::plan::TriggerKind::NetworkInput { fills, .. } = trigger.kind else { return false };
        let reactions = &federate.ports[fills.0].reactions;
        !reactions.is_empty()
            && reactions.iter().all(|it| self.plan.tardy(federate, &federate.reactions[it.0]).is_some())
    }
}
