// SPDX-License-Identifier: Apache-2.0
//! The tags of a running federate: begun when they are due and granted, run, and completed.

use lf_coordination::Deadline;
use lf_coordination::federate::Phase;
use lf_model::Progress;
use lf_model::time::{Instant, Tag};

use super::FederateLoop;
use super::output::Output;
use crate::error::RunError;
use crate::platform::Platform;

/// How many tags are run before the socket is looked at again, when physical time is ahead of logical time.
const TAGS_PER_TURN: u32 = 16;

/// How far the tags of one turn came.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Advance {
    /// All that is possible now is done; at this time more may be.
    Until(Deadline),
    /// The next tag, or the rest of the open one, needs word from the RTI or from other federates.
    NotGranted,
    /// The output buffer is full in the middle of a tag.
    OutputFull,
    /// The last tag is complete.
    Done,
}

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Runs the tags that are due and granted.
    pub(super) fn advance(&mut self) -> Result<Advance, RunError> {
        if self.machine.phase() != Phase::Running {
            return Ok(Advance::Until(Deadline::Never));
        }
        for _ in 0..TAGS_PER_TURN {
            if !self.engine.is_in_tag()
                && let Some(advance) = self.begin_next()?
            {
                return Ok(advance);
            }
            let (max_level, limit) = self.level_limit()?;
            let mut output = Output::new(
                self.platform,
                &mut self.link,
                &mut self.peers,
                self.federation.peers_out,
                &mut self.machine,
                self.silent,
            );
            match self.engine.advance(self.program, &mut output, max_level) {
                Progress::Complete => {}
                Progress::OutputFull { .. } => return Ok(Advance::OutputFull),
                Progress::LevelLimit { .. } => return Ok(limit),
                Progress::Failed(error) => return Err(error.into()),
            }
            self.machine.complete(self.engine.had_network_input());
            if let Some(tag) = self.engine.take_stop_request() {
                self.machine.request_stop(tag);
            }
            if self.engine.is_done() {
                self.machine.finish();
                return Ok(Advance::Done);
            }
        }
        Ok(Advance::Until(Deadline::Now))
    }

    /// Begins the next tag, if it is due and granted; else says what it waits for.
    fn begin_next(&mut self) -> Result<Option<Advance>, RunError> {
        // Asked first: who leaves now has left all its events behind.
        let sources = self.platform.outside().mailbox().links() > 0 || self.peers.can_receive();
        self.machine.set_physical_sources(sources);
        let env = Output::new(
            self.platform,
            &mut self.link,
            &mut self.peers,
            self.federation.peers_out,
            &mut self.machine,
            self.silent,
        );
        self.engine.drain_physical(self.program, &env);
        if let Some(tag) = self.engine.take_stop_request() {
            self.machine.request_stop(tag);
        }
        if self.is_decentralized() {
            return self.begin_when_known();
        }
        let now = self.platform.now();
        let event = self.engine.next_tag();
        // In a cycle without delay others may wait for this federate at a tag at which it has no event.
        let summons = self.machine.summons().filter(|summons| event.is_none_or(|event| *summons < event));
        let Some(tag) = summons.or(event) else { return Ok(Some(Advance::Until(self.idle(now)))) };
        // What this federate announces after it has done something stands for all that it was sent before the grant for
        // that, which includes the messages that wait for room.
        self.machine.next_event(now, event.unwrap_or(Tag::FOREVER).min(self.held.earliest()));
        // One NET per tag, even when many tags go into one write: each lets the RTI grant the tag before to others, who
        // may need that before they can take the messages of this one.
        self.collect();
        // A message of the last tag can come though that was granted long ago.
        if !self.machine.may_advance(tag) || tag >= self.held.earliest() {
            return Ok(Some(Advance::NotGranted));
        }
        if !self.engine.settings().fast && self.machine.clock().physical(now) < tag.time {
            return Ok(Some(Advance::Until(Deadline::At(self.machine.clock().local(tag.time)))));
        }
        self.machine.begin(tag)?;
        self.engine.begin(self.program, tag)?;
        self.held.look_again();
        self.peers.look_again();
        Ok(None)
    }

    /// There is no event. When none can come any more, the next microstep is the last tag.
    fn idle(&mut self, now: Instant) -> Deadline {
        // Neither the program nor one of its threads can make an event out of nothing.
        let has_no_source = !self.engine.settings().keepalive
            && self.platform.outside().mailbox().links() == 0
            && !self.peers.can_receive();
        if !self.federation.upstream.is_empty() || !has_no_source {
            // FOREVER is granted when all upstream federates have left. Others may be granted any tag once they are
            // told that nothing comes from here before FOREVER; so what the last tag sends would come too late, and is
            // not sent.
            // What still waits for room has just got some, and is about to be an event.
            let next = self.held.earliest();
            self.silent = self.machine.next_event(now, next) && has_no_source && next == Tag::FOREVER;
            if !self.silent {
                return Deadline::Never;
            }
        }
        self.engine.set_stop_tag(Tag::NEVER);
        Deadline::Now
    }
}
