// SPDX-License-Identifier: Apache-2.0
//! A federate that keeps the protocol and is free otherwise: its reactions may do anything.

use std::fmt;

use lf_model::time::Tag;

use crate::bounds::Fault;
use crate::graph::FEDERATES_MAX;
use crate::messages::{ToFederate, ToRti, Violation};
use crate::small_tag::{Short, SmallTag, SmallTags, next_tag};
use crate::world::World;

/// The state of one federate.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Federate {
    /// Whether it is lost or absent, or not part of the graph.
    pub(crate) gone: bool,
    /// Its first tag. A transient federate that has come does not know it at once.
    first: Option<Tag>,
    /// Whether another instance is to take its place.
    is_told_to_stop: bool,
    /// Its next local event.
    own: Option<SmallTag>,
    /// The tags of messages that have arrived and wait for their reactions.
    inputs: SmallTags,
    /// The last completed tag.
    completed: Option<SmallTag>,
    /// The open tag: reactions that may cause messages within the cycle have run, others wait.
    open: Option<SmallTag>,
    /// The last granted tag; a PTAG implies a grant of all tags before it.
    granted: Tag,
    provisional: Tag,
    /// For each federate whose inputs are awaited, the tag up to which its messages are known.
    known: [Tag; FEDERATES_MAX],
    next: NextEventRules,
}

/// The state of the rules for NET: the announced next event, and the RTI's answer in DNET.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct NextEventRules {
    /// The last NET, as the RTI knows it.
    sent: Tag,
    /// Whether the RTI still knows it as it was sent.
    certain: bool,
    skipped: Option<Tag>,
    downstream: Option<Tag>,
}

/// The reactions that are about to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Phase {
    /// At a provisionally granted tag: those that cause messages within the cycle.
    Within,
    /// All others; then the tag is complete.
    Rest,
}

impl Federate {
    /// Returns a federate that has announced its first event, at the start.
    pub(crate) fn new(gone: bool) -> Self {
        let first = SmallTag::FIRST;
        Self {
            gone,
            first: Some(first.tag()),
            is_told_to_stop: false,
            own: (!gone).then_some(first),
            inputs: SmallTags::default(),
            completed: None,
            open: None,
            granted: Tag::NEVER,
            provisional: Tag::NEVER,
            known: [Tag::NEVER; FEDERATES_MAX],
            next: NextEventRules { sent: first.tag(), certain: true, skipped: None, downstream: None },
        }
    }

    /// Returns a transient federate that has come, and does not know its first tag yet.
    pub(crate) fn joining() -> Self {
        let next = NextEventRules { sent: Tag::NEVER, certain: false, skipped: None, downstream: None };
        Self { gone: false, first: None, own: None, next, ..Self::new(true) }
    }

    /// Notes that a transient federate is absent.
    pub(crate) fn misses(&mut self, transient: usize) {
        self.known[transient] = Tag::FOREVER;
    }

    /// Returns whether it is between two tags.
    pub(crate) fn may_leave(&self) -> bool {
        self.open.is_none()
    }

    /// Returns whether it has to leave, because another instance is to take its place.
    pub(crate) fn is_told_to_stop(&self) -> bool {
        self.is_told_to_stop
    }

    /// Leaves in order, and says so. Returns the last tag that it has completed, too.
    pub(crate) fn leave(&mut self) -> (Option<SmallTag>, Vec<ToRti>) {
        let completed = self.completed.filter(|done| self.first.is_some_and(|first| done.tag() >= first));
        *self = Self::new(true);
        let said = completed.map(ToRti::Complete).into_iter().chain([ToRti::Next(Tag::FOREVER), ToRti::Resign]);
        (completed, said.collect())
    }

    /// Returns whether no event is left, no tag is open, and it need not leave.
    pub(crate) fn is_idle(&self) -> bool {
        let has_work = self.open.is_some() || self.own.is_some() || self.inputs.first().is_some();
        self.gone || !(has_work || self.is_told_to_stop)
    }

    /// Returns whether a reaction can schedule a further local event after this tag.
    pub(crate) fn may_plan(&self, at: SmallTag) -> bool {
        self.is_triggered(at) && self.own.is_none_or(|own| own <= at)
    }

    fn next(&self) -> Option<SmallTag> {
        match (self.own, self.inputs.first()) {
            (Some(own), Some(input)) => Some(own.min(input)),
            (own, input) => own.or(input),
        }
    }

    /// Returns the step that it can take by itself now, if any.
    pub(crate) fn can_run(&self, id: usize, world: &World) -> Option<(SmallTag, Phase)> {
        if self.gone {
            return None;
        }
        let next = self.next();
        let provisional = world.small_tag(self.provisional).filter(|tag| self.completed.is_none_or(|done| *tag > done));
        // It begins a provisionally granted tag even without an event, because others wait for its answer.
        let tag = self.open.or_else(|| provisional.filter(|tag| next.is_none_or(|next| *tag <= next))).or(next)?;
        if !world.has_upstream(id) || tag.tag() <= self.granted {
            return Some((tag, Phase::Rest));
        }
        // An open tag continues, even if a later one has been granted provisionally meanwhile.
        if self.open.is_none() && Some(tag) != provisional {
            return None;
        }
        let is_known = |from: &usize| self.known[*from] >= tag.tag();
        let mut awaited = world.awaited(id);
        if self.open.is_none() {
            // Reactions are in the order of the federates' ranks: these wait only for messages from lower ranks.
            let lower = |from: &usize| world.rank(*from) < world.rank(id);
            return awaited.filter(lower).all(|from| is_known(&from)).then_some((tag, Phase::Within));
        }
        awaited.all(|from| is_known(&from)).then_some((tag, Phase::Rest))
    }

    /// Returns whether something is known to be present at this tag. Otherwise no reaction runs, and the federate goes
    /// through the tag only to report that it sends nothing.
    pub(crate) fn is_triggered(&self, at: SmallTag) -> bool {
        self.own == Some(at) || self.inputs.contains(at)
    }

    /// Returns the federates to which the reactions of a phase may send messages.
    pub(crate) fn may_send(&self, id: usize, phase: Phase, world: &World, to: usize) -> bool {
        match (phase, world.is_awaited(id, to)) {
            (Phase::Within, awaited) => awaited,
            (Phase::Rest, true) => self.open.is_none(),
            (Phase::Rest, false) => true,
        }
    }

    /// Runs its reactions: `sends` are the federates that get a message, `plan` is its next local event.
    pub(crate) fn run(
        &mut self,
        id: usize,
        (at, phase): (SmallTag, Phase),
        sends: u8,
        plan: Option<SmallTag>,
        world: &World,
    ) -> Vec<ToRti> {
        let mut said = Vec::new();
        for (to, delay) in world.graph.downstream(id) {
            if !self.may_send(id, phase, world, to) {
                continue;
            }
            let number = u8::try_from(to).unwrap_or(u8::MAX);
            if sends >> to & 1 == 1 {
                let at = delay.after(at);
                said.push(ToRti::Message { to: number, at });
                self.next.downstream = self.next.downstream.map(|tag| tag.min(at.tag()));
            } else if world.is_awaited(id, to) && world.bounds.fault != Some(Fault::NoAbsence) {
                said.push(ToRti::Absent { to: number, at });
            }
        }
        match phase {
            Phase::Within => self.open = Some(at),
            Phase::Rest => {
                let messages = std::mem::take(&mut said);
                let late = world.bounds.fault == Some(Fault::LateMessages);
                if !late {
                    said.extend(&messages);
                }
                said.extend(self.complete(id, at, plan, world));
                if late {
                    said.extend(&messages);
                }
            }
        }
        said
    }

    fn complete(&mut self, id: usize, at: SmallTag, plan: Option<SmallTag>, world: &World) -> Vec<ToRti> {
        let mut said = Vec::new();
        self.open = None;
        self.completed = Some(at);
        // Inputs at completed tags no longer make a difference.
        self.known = self.known.map(|known| if known <= at.tag() { Tag::NEVER } else { known });
        let had_input = self.inputs.remove(at);
        self.own = self.own.filter(|own| *own != at);
        if plan.is_some() {
            self.own = plan;
        }
        if (had_input || self.provisional == at.tag()) && world.bounds.fault != Some(Fault::NoCompletion) {
            said.push(ToRti::Complete(at));
        }
        said.extend(self.announce(id, world));
        said
    }

    /// Handles a message from the RTI.
    pub(crate) fn hear(&mut self, id: usize, message: ToFederate, world: &World) -> (Vec<ToRti>, Option<Violation>) {
        if self.gone {
            return (Vec::new(), None);
        }
        let federate = u8::try_from(id).unwrap_or(u8::MAX);
        if self.first.is_none() && !matches!(message, ToFederate::Begins(_) | ToFederate::Stop) {
            return (Vec::new(), Some(Violation::BeforeFirst { federate }));
        }
        let mut said = Vec::new();
        let violation = match message {
            ToFederate::Grant(tag) => {
                let old = tag <= self.granted || tag < self.provisional;
                self.granted = tag.min(world.end());
                old.then_some(Violation::OldGrant { federate, tag })
            }
            ToFederate::Provisional(tag) => {
                let old = tag <= self.granted || tag <= self.provisional;
                self.provisional = tag;
                // No earlier message can arrive any more.
                self.granted = self.granted.max(tag.before());
                if let Some(past) = world.small_tag(tag).filter(|tag| self.completed.is_some_and(|done| *tag <= done)) {
                    said.push(ToRti::Complete(past));
                }
                let needless = world.awaited(id).next().is_none();
                needless
                    .then_some(Violation::NeedlessProvisional { federate, tag })
                    .or(old.then_some(Violation::OldGrant { federate, tag }))
            }
            ToFederate::DownstreamNext(tag) => {
                self.next.downstream = Some(tag).filter(|tag| *tag > Tag::NEVER);
                if let Some(skipped) = self.next.skipped.filter(|skipped| tag < *skipped) {
                    said.extend(self.next.announce(skipped));
                }
                None
            }
            ToFederate::Message { from, tag } => {
                let violation = self.too_late(id, from, tag, world);
                if let (None, Some(small)) = (violation, world.small_tag(tag)) {
                    self.inputs.insert(small);
                    self.now_known(id, from, tag, world);
                    self.next.lowered(tag);
                }
                violation
            }
            ToFederate::Absent { from, tag } => {
                self.now_known(id, from, tag, world);
                None
            }
            ToFederate::Begins(tag) => {
                (self.own, self.first) = (world.small_tag(tag), Some(tag));
                self.completed = world.last_before(tag);
                None
            }
            ToFederate::Came(from) => {
                // Its first tag is later than everything that has been granted.
                self.known[usize::from(from)] = self.granted.max(self.provisional);
                None
            }
            ToFederate::Left(from) => {
                self.known[usize::from(from)] = Tag::FOREVER;
                None
            }
            ToFederate::Stop => {
                self.is_told_to_stop = world.bounds.fault != Some(Fault::Stays);
                None
            }
        };
        if self.open.is_none() {
            said.extend(self.announce(id, world));
        }
        (said, violation)
    }

    fn too_late(&self, id: usize, from: u8, tag: Tag, world: &World) -> Option<Violation> {
        let federate = u8::try_from(id).unwrap_or(u8::MAX);
        if tag <= self.granted || self.completed.is_some_and(|done| tag <= done.tag()) {
            return Some(Violation::AfterGrant { federate, from, tag });
        }
        let from_index = usize::from(from);
        let expected = tag == self.provisional && world.is_awaited(from_index, id) && self.known[from_index] < tag;
        (tag <= self.provisional && !expected).then_some(Violation::AfterProvisional { federate, from, tag })
    }

    fn now_known(&mut self, id: usize, from: u8, tag: Tag, world: &World) {
        let from = usize::from(from);
        if world.is_awaited(from, id) {
            self.known[from] = self.known[from].max(tag);
        }
    }

    /// Returns a NET for its next event, if the rules demand one.
    fn announce(&mut self, id: usize, world: &World) -> Option<ToRti> {
        let next = next_tag(self.next());
        let needed = match self.next.downstream {
            downstream if next <= self.granted => {
                downstream.is_none_or(|downstream| downstream < next && downstream >= self.next.sent)
            }
            downstream => world.has_upstream(id) || downstream.is_none_or(|downstream| downstream < next),
        };
        if needed {
            return self.next.announce(next);
        }
        let told = self.next.certain && self.next.sent == next;
        self.next.skipped = (!told).then_some(next);
        None
    }
}

impl fmt::Debug for Federate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.gone {
            return f.write_str("gone");
        }
        let Self { own, inputs, completed, open, granted, provisional, known, next, is_told_to_stop, .. } = self;
        let known = known.map(Short);
        let (granted, provisional, sent) = (Short(*granted), Short(*provisional), Short(next.sent));
        write!(
            f,
            "own event {own:?}, inputs at {inputs:?}, completed {completed:?}, open {open:?}, TAG {granted:?}, "
        )?;
        write!(f, "PTAG {provisional:?}, inputs known up to {known:?}, NET {sent:?}")?;
        if *is_told_to_stop { f.write_str(", has to leave") } else { Ok(()) }
    }
}

impl NextEventRules {
    fn announce(&mut self, next: Tag) -> Option<ToRti> {
        self.skipped = None;
        let told = self.certain && self.sent == next;
        (self.sent, self.certain) = (next, true);
        (!told).then_some(ToRti::Next(next))
    }

    /// Notes a received message: the RTI takes its tag for the next event, if it is earlier.
    fn lowered(&mut self, tag: Tag) {
        if tag < self.sent {
            (self.sent, self.certain) = (tag, false);
        }
    }
}
