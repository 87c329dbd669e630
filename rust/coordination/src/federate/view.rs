// SPDX-License-Identifier: Apache-2.0
//! Getters of a federate.

use lf_model::time::{Instant, Tag};

use super::clock_sync::ClockSyncReport;
use super::config::{ClockSync, Coordination};
use super::machine::Federate;
use super::needs::Needs;
use crate::Deadline;
use crate::clock_sync::ClockCorrection;

impl<N: Needs> Federate<'_, N> {
    /// Returns the way in which federates keep the order of tags.
    pub fn coordination(&self) -> Coordination {
        self.config.coordination()
    }

    /// Returns the correction from this participant's own clock to the federation's physical time.
    ///
    /// It makes one step, with [`Event::ClockCorrected`](super::Event::ClockCorrected), before the start. Afterwards
    /// only its rate changes, with [`Received::corrected`](super::Received::corrected).
    pub fn clock(&self) -> ClockCorrection {
        *self.clock.correction()
    }

    /// Returns the physical time at which logical time begins; `None` before [`Event::Started`](super::Event::Started).
    pub fn start_time(&self) -> Option<Instant> {
        self.tags.start_time()
    }

    /// Returns the last tag that the RTI has granted; `NEVER` before the first grant. A provisional grant counts as a
    /// grant of everything before its tag.
    pub fn granted(&self) -> Tag {
        self.tags.granted()
    }

    /// Returns when a message is likely to come, on the participant's own clock: the RTI grants up to just before the
    /// earliest event of the federates upstream, if their connections have no delay.
    pub fn next_arrival(&self) -> Deadline {
        match self.tags.granted().time {
            Instant::NEVER | Instant::FOREVER => Deadline::Never,
            time => Deadline::At(self.clock.correction().local(time)),
        }
    }

    /// Returns the last provisional grant, if it is later than [`Federate::granted`].
    pub fn granted_provisionally(&self) -> Option<Tag> {
        self.tags.granted_provisionally()
    }

    /// Returns the last tag that was begun; `NEVER` before the first.
    pub fn current(&self) -> Tag {
        self.tags.current()
    }

    /// Returns the tag that a PTAG demands of this federate, though it may have no event there. Begin it when no event
    /// is earlier: others of its cycle wait for its messages at that tag, or for their absence.
    pub fn demanded_tag(&self) -> Option<Tag> {
        self.tags.demanded_tag().filter(|tag| *tag <= self.stop.last_tag())
    }

    /// Returns whether all inputs are known at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.tags.knows_all_inputs()
    }

    /// Returns the tag at which the whole federation stops; `None` before
    /// [`Event::StopGranted`](super::Event::StopGranted).
    pub fn stop_tag(&self) -> Option<Tag> {
        self.stop.granted()
    }

    /// Returns whether this federate has named a tag to stop at, and the RTI has not decided.
    pub fn awaits_stop_tag(&self) -> bool {
        self.stop.is_open()
    }

    /// Returns whether a message with this tag may be sent: not after this federate's last tag, because no federate
    /// will reach it.
    pub fn may_send(&self, tag: Tag) -> bool {
        tag <= self.stop.last_tag()
    }

    /// Returns the index of the federate to connect to next, among those to which this one sends.
    pub fn next_peer_index(&self) -> Option<usize> {
        self.session.next_peer_index(&self.config)
    }

    /// Returns the results of clock synchronization; `None` unless it goes on while the federation runs.
    pub fn clock_sync_report(&self) -> Option<ClockSyncReport> {
        matches!(self.config.clock_sync, ClockSync::On { .. }).then(|| self.clock.report())
    }
}
