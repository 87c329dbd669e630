// SPDX-License-Identifier: Apache-2.0
//! The error of a federate that waits without end for others, which wait for it: some queue is too small for their
//! messages.

use lf_coordination::Deadline;
use lf_coordination::federate::Needs;
use lf_derive::outlined;
use lf_model::InputId;
use lf_model::time::{Instant, Interval};

use super::direct::Direct;
use super::execution::{Advance, Execution};
use super::peers::Peers;
use super::receiver::Receiver;
use crate::error::{PeerFault, RunError};
use crate::platform::Platform;

/// The time for which others may accept nothing while this federate waits for that in the middle of a tag. They may be
/// waiting for this one, and then without end.
const BLOCKED_TIME_OUT: Interval = Interval::from_secs(60);

/// The state of a federate's waits for room.
#[derive(Debug, Default)]
pub(super) struct Deadlock {
    /// Since when all of the session's input buffer has been held while this federate waits for room for its output.
    full_since: Option<Instant>,
}

impl Deadlock {
    /// Returns the error of a deadlock, if there is one.
    #[outlined]
    pub(super) fn find<P: Platform, N: Needs>(
        &mut self,
        platform: &mut P,
        advance: Advance,
        receiver: &mut Receiver<'_>,
        direct: &mut Direct<'_, '_, N>,
        execution: &Execution<'_, '_, N>,
    ) -> Option<RunError> {
        let full_input = if N::INPUTS { receiver.full_input() } else { None };
        let full = |input: InputId| RunError::InputFull { input: execution.name_of(input) };
        if advance == Advance::NotGranted && execution.is_decentralized() {
            if let Some(input) = direct.deadlocked_input(execution) {
                return Some(full(input));
            }
        } else if advance == Advance::NotGranted {
            if let Some(input) = full_input {
                return Some(full(input));
            }
            if let Some(input) = execution.input_over_capacity(&receiver.held) {
                return Some(RunError::TagFull { input: execution.name_of(input) });
            }
        }
        if advance != Advance::OutputFull {
            self.full_since = None;
            return None;
        }
        let now = platform.now();
        if let Some((federate, since)) = direct.peers.blocked()
            && now >= since + BLOCKED_TIME_OUT
        {
            return Some(RunError::Peer { federate, fault: PeerFault::Blocked });
        }
        self.full_since = full_input.and(self.full_since.or(Some(now)));
        let is_over = self.full_since.is_some_and(|since| now >= since + BLOCKED_TIME_OUT);
        full_input.filter(|_| is_over).map(full)
    }

    /// Returns when to look again while an output is full.
    pub(super) fn poll_timeout<N: Needs>(&self, peers: &Peers<'_, '_, N>) -> Deadline {
        let since = peers.blocked().map(|(_, since)| since).into_iter().chain(self.full_since).min();
        since.map(|since| since + BLOCKED_TIME_OUT).into()
    }
}
