// SPDX-License-Identifier: Apache-2.0
//! When a federate can never go on, because some queue is too small for what others send: an error, not a hang.

use lf_coordination::Deadline;
use lf_model::InputId;
use lf_model::time::{Instant, Interval};

use super::FederateLoop;
use super::tags::Advance;
use crate::error::{PeerFault, RunError};
use crate::platform::Platform;

/// How long others may take nothing while this federate waits for that in the middle of a tag. They may be waiting for
/// this one, and then for ever.
const TIME_OUT: Interval = Interval::from_secs(60);

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Ends with an error what would last for ever.
    pub(super) fn check_stuck(&mut self, advance: Advance) -> Result<(), RunError> {
        if advance == Advance::NotGranted && self.is_decentralized() {
            if let Some(input) = self.starved() {
                return Err(RunError::InputFull { input: self.name_of(input) });
            }
        } else if advance == Advance::NotGranted {
            if let Some(input) = self.choked() {
                return Err(RunError::InputFull { input: self.name_of(input) });
            }
            if let Some(input) = self.overfull() {
                return Err(RunError::TagFull { input: self.name_of(input) });
            }
        }
        let waits = advance == Advance::OutputFull;
        let now = self.platform.now();
        if waits
            && let Some((index, since)) = self.peers.stuck()
            && now >= since + TIME_OUT
        {
            let federate = self.federation.peers_out.get(index).copied().unwrap_or_default();
            return Err(RunError::Peer { federate, fault: PeerFault::Stuck });
        }
        let choked = self.choked().filter(|_| waits);
        self.choked_since = choked.and(self.choked_since.or(Some(now)));
        match (choked, self.choked_since) {
            (Some(input), Some(since)) if now >= since + TIME_OUT => {
                Err(RunError::InputFull { input: self.name_of(input) })
            }
            _ => Ok(()),
        }
    }

    /// When to look again though nothing has happened.
    pub(super) fn stuck_deadline(&self) -> Deadline {
        let since = self.peers.stuck().map(|(_, since)| since);
        let first: Option<Instant> = since.into_iter().chain(self.choked_since).min();
        first.map(|since| since + TIME_OUT).into()
    }

    /// Whether the connection cannot be read, because all of its buffer is held: then which input holds it. While no
    /// tag can be begun or completed either, this lasts.
    fn choked(&mut self) -> Option<InputId> {
        let choked = !self.held.is_stale() && self.link.buffers.input.space().is_empty();
        self.held.input().filter(|_| choked)
    }

    /// Whether more messages have come for one tag than a queue holds: then which input holds the others. They have to
    /// be in the queue before the tag is begun, and nothing that is earlier can make room any more.
    fn overfull(&mut self) -> Option<InputId> {
        let earliest = self.held.earliest();
        let granted = self.held.is_granted() || self.machine.granted() >= earliest;
        let due = !self.held.is_stale() && granted && !self.machine.awaits_stop_tag() && !self.engine.is_in_tag();
        let nothing_before = self.engine.next_tag().is_none_or(|next| next >= earliest);
        self.held.input().filter(|_| due && nothing_before)
    }

    fn name_of(&self, input: InputId) -> &'static str {
        self.engine.tables().inputs.get(usize::from(input.0)).map_or("", |input| input.name)
    }
}
