// SPDX-License-Identifier: Apache-2.0
//! The rules of the RTI as they are written down, worked out anew from all that is known whenever they are asked for:
//! slow, and with nothing that could be out of date.

use std::collections::{BTreeMap, BTreeSet};

use lf_wire::Tag;

use lf_testkit::rti::dialogue::START;

/// Time and microsteps.
type Delay = (i64, u32);

/// A message of the RTI to a federate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RtiMessage {
    Tag(Tag),
    Ptag(Tag),
    Dnet(Tag),
    Message(Tag),
}

#[derive(Clone)]
#[expect(clippy::struct_excessive_bools, reason = "each says something else")]
struct Federate {
    present: bool,
    next: Tag,
    completed: Tag,
    granted: Tag,
    provisional: Tag,
    dnet: Tag,
    look: bool,
    in_transit: BTreeSet<Tag>,
    agreed: bool,
    /// Another one has left its cycle without delay.
    deserted: bool,
}

pub(crate) struct Plain {
    dnet: bool,
    federates: Vec<Federate>,
    /// Immediate connections: the least delay by destination and origin.
    immediate: BTreeMap<(usize, usize), Delay>,
    /// The least delay of all paths, by origin and destination.
    paths: BTreeMap<(usize, usize), Delay>,
    stop: Tag,
    stop_requested: bool,
    stop_granted: bool,
    pub(crate) said: Vec<Vec<RtiMessage>>,
}

fn then((time, microsteps): Delay, rest: Delay) -> Delay {
    (time + rest.0, rest.1 + if rest.0 > 0 { 0 } else { microsteps })
}

fn before_tag(tag: Tag) -> Tag {
    match tag.microstep {
        _ if tag == Tag::FOREVER || tag == Tag::NEVER => tag,
        0 => Tag::new(tag.time - 1, u32::MAX),
        microstep => Tag::new(tag.time, microstep - 1),
    }
}

fn after((time, microsteps): Delay, tag: Tag) -> Tag {
    match tag {
        Tag::NEVER | Tag::FOREVER => tag,
        Tag { time: base, .. } if time > 0 => Tag::new(base + time, microsteps),
        Tag { time, microstep } => Tag::new(time, microstep.saturating_add(microsteps)),
    }
}

fn after_strictly(delay: Delay, tag: Tag) -> Tag {
    let delayed = after(delay, tag);
    let finite = delayed != Tag::NEVER && delayed != Tag::FOREVER;
    if delay.0 > 0 && finite { before_tag(Tag::new(delayed.time, 0)) } else { delayed }
}

fn needed((time, microsteps): Delay, tag: Tag) -> Tag {
    if tag == Tag::FOREVER || tag == Tag::NEVER || tag < Tag::new(time, microsteps) {
        return if tag == Tag::FOREVER { tag } else { Tag::NEVER };
    }
    let earlier = tag.time - time;
    match tag.microstep.checked_sub(microsteps) {
        None => before_tag(Tag::new(earlier, 0)),
        Some(_) if time > 0 => Tag::new(earlier, u32::MAX),
        Some(microstep) => Tag::new(earlier, microstep),
    }
}

/// Returns the least delay of all paths, by origin and destination.
fn find_paths(count: usize, immediate: &BTreeMap<(usize, usize), Delay>) -> BTreeMap<(usize, usize), Delay> {
    let mut paths: BTreeMap<(usize, usize), Delay> = BTreeMap::new();
    for _ in 0..=count {
        for (&(to, from), &first) in immediate {
            for end in 0..count {
                let rest = if end == to { Some((0, 0)) } else { paths.get(&(to, end)).copied() };
                if let Some(delay) = rest.map(|rest| then(first, rest)) {
                    let least = paths.entry((from, end)).or_insert(delay);
                    *least = delay.min(*least);
                }
            }
        }
    }
    paths
}

impl Plain {
    /// Returns a started federation; `edges` are origin, destination and delay as on the wire.
    pub(crate) fn new(count: usize, edges: &[(u16, u16, i64)], dnet: bool) -> Self {
        let mut immediate = BTreeMap::new();
        for &(from, to, delay) in edges {
            let delay = match delay {
                i64::MIN => (0, 0),
                0 => (0, 1),
                time => (time, 0),
            };
            let least = immediate.entry((usize::from(to), usize::from(from))).or_insert(delay);
            *least = delay.min(*least);
        }
        let federate = Federate {
            present: true,
            next: Tag::NEVER,
            completed: Tag::NEVER,
            granted: Tag::NEVER,
            provisional: Tag::NEVER,
            dnet: Tag::NEVER,
            look: false,
            in_transit: BTreeSet::new(),
            agreed: false,
            deserted: false,
        };
        Self {
            dnet,
            federates: vec![federate; count],
            paths: find_paths(count, &immediate),
            immediate,
            stop: Tag::NEVER,
            stop_requested: false,
            stop_granted: false,
            said: vec![Vec::new(); count],
        }
    }

    fn upstream(&self, federate: usize) -> Vec<(usize, Delay)> {
        let own = self.immediate.range((federate, 0)..(federate + 1, 0));
        own.map(|((_, from), delay)| (*from, *delay)).collect()
    }

    fn cyclic(&self, federate: usize) -> bool {
        self.paths.get(&(federate, federate)) == Some(&(0, 0))
    }

    fn same_cycle(&self, one: usize, other: usize) -> bool {
        [(one, other), (other, one)].iter().all(|path| self.paths.get(path) == Some(&(0, 0)))
    }

    pub(crate) fn on_next_event(&mut self, federate: usize, tag: Tag) {
        let own = &mut self.federates[federate];
        own.next = own.in_transit.first().map_or(tag, |first| tag.min(*first));
        if self.upstream(federate).is_empty() {
            self.federates[federate].granted = self.federates[federate].next;
        } else {
            self.advance(federate);
        }
        self.advance_downstream(federate);
        for upstream in 0..self.federates.len() {
            if self.dnet && upstream != federate && self.paths.contains_key(&(upstream, federate)) {
                self.send_dnet(upstream);
            }
        }
    }

    pub(crate) fn on_complete(&mut self, federate: usize, tag: Tag) {
        let own = &mut self.federates[federate];
        own.completed = own.completed.max(tag);
        self.advance_downstream(federate);
        self.federates[federate].in_transit.retain(|message| *message > tag);
    }

    pub(crate) fn on_message(&mut self, to: usize, tag: Tag) {
        if !self.federates[to].present {
            return;
        }
        self.said[to].push(RtiMessage::Message(tag));
        if self.federates[to].completed < tag {
            self.federates[to].in_transit.insert(tag);
        }
        if tag < self.federates[to].next {
            self.on_next_event(to, tag);
        }
    }

    pub(crate) fn on_departure(&mut self, federate: usize) {
        self.federates[federate].present = false;
        self.federates[federate].next = Tag::FOREVER;
        if self.cyclic(federate) {
            for other in 0..self.federates.len() {
                self.federates[other].deserted |= self.same_cycle(other, federate);
            }
            self.immediate.retain(|(to, _), _| *to != federate);
            self.paths = find_paths(self.federates.len(), &self.immediate);
        }
        self.advance_downstream(federate);
        self.grant_stop();
    }

    pub(crate) fn on_stop(&mut self, federate: usize, tag: Tag) {
        if std::mem::replace(&mut self.federates[federate].agreed, true) {
            return;
        }
        self.stop_requested = true;
        self.stop = self.stop.max(tag);
        self.grant_stop();
    }

    fn grant_stop(&mut self) {
        let agreed = self.federates.iter().all(|federate| federate.agreed || !federate.present);
        if self.stop_requested && !self.stop_granted && agreed {
            self.stop_granted = true;
            for federate in self.federates.iter_mut().filter(|federate| federate.present) {
                federate.next = federate.next.min(self.stop);
            }
        }
    }

    fn advance_downstream(&mut self, federate: usize) {
        for downstream in 0..self.federates.len() {
            if self.paths.contains_key(&(federate, downstream)) {
                self.advance(downstream);
            }
        }
    }

    fn advance(&mut self, federate: usize) {
        let mut next = Some(federate);
        while let Some(federate) = next {
            if self.grant(federate) {
                for (from, _) in self.upstream(federate) {
                    self.federates[from].look = true;
                }
                self.federates[federate].look = true;
            }
            next = self.federates.iter().position(|federate| federate.look);
            if let Some(next) = next {
                self.federates[next].look = false;
            }
        }
    }

    /// Returns whether a PTAG was sent.
    fn grant(&mut self, federate: usize) -> bool {
        if !self.federates[federate].present {
            return false;
        }
        let Some((tag, provisional)) = self.what_to_grant(federate) else { return false };
        if provisional {
            self.said[federate].push(RtiMessage::Ptag(tag));
            self.federates[federate].provisional = tag;
        } else {
            self.said[federate].push(RtiMessage::Tag(tag));
            self.federates[federate].granted = tag;
        }
        // Another one may wait for a later tag.
        self.federates[federate].look |= self.demand(federate).is_some();
        provisional
    }

    /// Returns the earliest tag at which a federate immediately downstream waits, and that this one has not reached.
    fn demand(&self, federate: usize) -> Option<Tag> {
        let own = &self.federates[federate];
        let downstream =
            self.immediate.keys().filter(|(_, from)| *from == federate).map(|(to, _)| &self.federates[*to]);
        let waiting = downstream.filter(|other| {
            let tag = other.provisional;
            other.present && other.completed < tag && other.granted < tag
        });
        let tags = waiting.map(|other| other.provisional);
        tags.filter(|tag| own.completed < *tag && own.granted < *tag && own.provisional <= *tag).min()
    }

    /// Returns a tag to grant, and whether it is granted provisionally.
    fn what_to_grant(&mut self, federate: usize) -> Option<(Tag, bool)> {
        let Federate { granted, provisional, .. } = self.federates[federate];
        let new = |tag: Tag| tag > granted && tag >= provisional;
        let waits = !self.upstream(federate).is_empty();
        let present = self.upstream(federate).into_iter().filter(|(from, _)| self.federates[*from].present);
        let completed = present.map(|(from, delay)| after_strictly(delay, self.federates[from].completed)).min();
        let completed = completed.unwrap_or(Tag::FOREVER);
        if waits && completed >= self.federates[federate].next && new(completed) {
            return Some((completed, false));
        }
        let earliest = self.earliest_incoming(federate);
        let next = self.federates[federate].next;
        if waits && earliest > next && next != Tag::NEVER && new(before_tag(earliest)) {
            return Some((before_tag(earliest), false));
        }
        let later = |tag: Tag| tag > granted.max(provisional);
        if waits && earliest == next && self.cyclic(federate) && later(next) && self.strict(federate) > next {
            return Some((next, true));
        }
        if let Some(tag) = self.demand(federate) {
            if earliest > tag {
                return Some((tag, false));
            }
            if earliest == tag && later(tag) && self.strict(federate) > tag {
                return Some((tag, true));
            }
        }
        let waits_within = self.federates[federate].completed < provisional && granted < provisional;
        let upstream = self.upstream(federate).into_iter().filter(|(from, _)| self.same_cycle(*from, federate));
        let passes_by = upstream.into_iter().any(|(from, _)| self.federates[from].completed < provisional);
        let alone = passes_by || self.federates[federate].deserted;
        let may_wait_for_ever = waits_within && alone;
        let is_known = may_wait_for_ever && (earliest > provisional || self.upstream_is_past(federate, provisional));
        is_known.then_some((provisional, false))
    }

    fn upstream_is_past(&mut self, federate: usize, tag: Tag) -> bool {
        self.upstream(federate).into_iter().all(|(from, delay)| {
            let other = &self.federates[from];
            !other.present || after_strictly(delay, other.completed) >= tag || {
                let promised = after((0, 1), self.federates[from].granted);
                let incoming = self.earliest_incoming(from).max(promised);
                after(delay, self.federates[from].next.min(incoming)) > tag
            }
        })
    }

    fn earliest_incoming(&mut self, federate: usize) -> Tag {
        let mut earliest = Tag::FOREVER;
        for from in 0..self.federates.len() {
            let Some(delay) = self.paths.get(&(from, federate)) else { continue };
            if self.federates[from].next == Tag::NEVER {
                self.federates[from].next = Tag::new(START, 0);
            }
            earliest = earliest.min(after(*delay, self.federates[from].next));
        }
        earliest
    }

    fn strict(&mut self, federate: usize) -> Tag {
        let mut earliest = Tag::FOREVER;
        for (from, delay) in self.upstream(federate) {
            if !self.same_cycle(from, federate) {
                let incoming = self.earliest_incoming(from);
                earliest = earliest.min(after(delay, self.federates[from].next.min(incoming)));
            }
        }
        earliest
    }

    fn send_dnet(&mut self, federate: usize) {
        let others = (0..self.federates.len()).filter(|other| *other != federate);
        let paths: Vec<_> = others.filter_map(|other| Some((other, *self.paths.get(&(federate, other))?))).collect();
        let all_matter = self.cyclic(federate) || paths.iter().any(|(other, _)| self.cyclic(*other));
        let tag = paths.iter().map(|(other, delay)| needed(*delay, self.federates[*other].next)).min();
        let own = &mut self.federates[federate];
        let news = match tag {
            _ if all_matter => Tag::NEVER,
            Some(tag) if tag >= Tag::new(START, 0) && own.next <= tag => tag,
            _ => own.dnet,
        };
        if own.present && news != own.dnet {
            own.dnet = news;
            self.said[federate].push(RtiMessage::Dnet(news));
        }
    }
}
