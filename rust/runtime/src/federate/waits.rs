// SPDX-License-Identifier: Apache-2.0
//! The tags of a federate with decentralized coordination: when they begin, and where their reactions wait.
//!
//! Before a time is taken to be over, all that has come is read, so that no message is late that was there in time.

use lf_coordination::Deadline;
use lf_model::time::{Instant, Interval};
use lf_model::{InputId, Tables};

use super::FederateLoop;
use super::tags::Advance;
use crate::error::RunError;
use crate::platform::{Observation, Platform};

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Begins the next tag, if all that comes before it is known or has been waited for; else says what it waits for.
    pub(super) fn begin_when_known(&mut self) -> Result<Option<Advance>, RunError> {
        if self.peers.stale {
            self.take_messages()?;
        }
        let now = self.platform.now();
        let Some(tag) = self.engine.next_tag() else { return Ok(Some(self.idle_until_all_have_left())) };
        if !self.machine.may_advance(tag) || self.awaits_rest_before(tag) {
            return Ok(Some(Advance::NotGranted));
        }
        let tables = self.engine.tables();
        let is_known = self.awaited.knows_before(tag);
        let begins = self.awaited.begin_time(tag, |port| max_wait(tables, port));
        let is_free = is_known && self.engine.settings().fast;
        if !is_free && self.machine.clock().physical(now) < begins {
            return Ok(Some(self.wait_for(begins)));
        }
        if !is_known && self.sweep()? {
            return Ok(Some(Advance::Until(Deadline::Now)));
        }
        self.machine.begin(tag)?;
        self.platform.observe(Observation::Begins { tag, due: begins });
        self.engine.begin(self.program, tag)?;
        self.held.look_again();
        self.peers.look_again();
        Ok(None)
    }

    /// The level from which on reactions of the open tag have to wait, if any have to, and what they wait for.
    pub(super) fn level_limit(&mut self) -> Result<(Option<u16>, Advance), RunError> {
        if !self.is_decentralized() {
            return Ok((self.awaited.max_level(&self.machine), Advance::NotGranted));
        }
        if self.peers.stale {
            self.take_messages()?;
        }
        let (tables, current) = (self.engine.tables(), self.engine.current_tag());
        let patience = |port| patience(tables, port);
        // The others stop too, and need not tell anything at the last tag.
        let is_decided = self.machine.stop_tag() == Some(current);
        loop {
            let Some(pause) = self.awaited.pause(current, patience) else { return Ok((None, Advance::NotGranted)) };
            let physical = self.machine.clock().physical(self.platform.now());
            if !is_decided && physical < pause.until {
                return Ok((Some(pause.level), self.wait_for(pause.until)));
            }
            if self.sweep()? {
                return Ok((Some(pause.level), Advance::Until(Deadline::Now)));
            }
            if is_decided {
                self.awaited.assume_absent(current, Instant::FOREVER, patience);
            } else {
                self.awaited.assume_absent(current, physical, patience);
            }
        }
    }

    /// There is no event. When none can come any more, the next microstep is the last tag.
    fn idle_until_all_have_left(&mut self) -> Advance {
        // Neither the program, nor one of its threads, nor another federate can make an event out of nothing.
        let has_source = self.engine.settings().keepalive
            || self.platform.outside().mailbox().links() > 0
            || self.peers.can_receive();
        if has_source {
            return Advance::Until(Deadline::Never);
        }
        self.engine.set_stop_tag(lf_model::Tag::NEVER);
        Advance::Until(Deadline::Now)
    }

    /// Waits until this physical time of the federation, or for word from others.
    fn wait_for(&self, time: Instant) -> Advance {
        if time == Instant::FOREVER {
            return Advance::NotGranted;
        }
        Advance::Until(Deadline::At(self.machine.clock().local(time)))
    }

    /// Whether a federate whose receive buffer is full of messages without room would have to send word of another of
    /// its inputs, for which this one waits for ever: then which input holds the messages.
    pub(super) fn starved(&mut self) -> Option<InputId> {
        let tag = if self.engine.is_in_tag() { self.engine.current_tag() } else { self.engine.next_tag()?.before() };
        let (tables, awaited) = (self.engine.tables(), &self.awaited);
        for inbound in self.peers.inbound.iter_mut() {
            let (Some(from), Some(held)) = (inbound.from, inbound.held.input()) else { continue };
            let is_full = !inbound.held.is_stale() && inbound.input.space().is_empty();
            let mut inputs = (0..).zip(tables.inputs).filter(|(_, input)| !input.physical && input.federate == from.0);
            let for_ever = |port| patience(tables, port) == Interval::FOREVER;
            if is_full && inputs.any(|(port, _)| for_ever(port) && !awaited.is_known(port, tag)) {
                return Some(held);
            }
        }
        None
    }
}

fn max_wait(tables: &Tables, port: u16) -> Interval {
    tables.inputs.get(usize::from(port)).map_or(Interval::ZERO, |input| input.max_wait)
}

/// How long after a tag's time an input is waited for within the tag.
fn patience(tables: &Tables, port: u16) -> Interval {
    tables
        .inputs
        .get(usize::from(port))
        .map_or(Interval::ZERO, |input| input.max_wait.saturating_add(input.absent_after))
}
