// SPDX-License-Identifier: Apache-2.0
//! What a federate can be asked about itself.

use lf_model::time::{Instant, Tag};

use super::clock_sync::ClockSyncReport;
use super::config::{ClockSync, Coordination};
use super::machine::Federate;
use super::needs::Needs;
use crate::Deadline;
use crate::clock_sync::ClockCorrection;

impl<N: Needs> Federate<'_, N> {
    /// How tags are kept in order.
    pub fn coordination(&self) -> Coordination {
        self.config.coordination
    }

    /// From this participant's own clock to the federation's physical time.
    ///
    /// It makes one step, with [`Event::ClockCorrected`](super::Event::ClockCorrected), before the start. Afterwards
    /// only its rate changes, with [`Received::corrected`](super::Received::corrected).
    pub fn clock(&self) -> ClockCorrection {
        *self.clock.correction()
    }

    /// The physical time at which logical time begins; `None` before [`Event::Started`](super::Event::Started).
    pub fn start_time(&self) -> Option<Instant> {
        self.tags.start_time()
    }

    /// The last tag that the RTI has granted; `NEVER` before the first grant. A provisional grant counts as one of all
    /// that is before its tag.
    pub fn granted(&self) -> Tag {
        self.tags.granted()
    }

    /// When something is likely to come, on the participant's own clock: what the RTI grants ends just before the
    /// earliest event of those upstream, as far as their connections have no delay.
    pub fn next_arrival(&self) -> Deadline {
        match self.tags.granted().time {
            Instant::NEVER | Instant::FOREVER => Deadline::Never,
            time => Deadline::At(self.clock.correction().local(time)),
        }
    }

    /// The last provisional grant, if it is later than [`Federate::granted`].
    pub fn granted_provisionally(&self) -> Option<Tag> {
        self.tags.granted_provisionally()
    }

    /// The last tag that was begun; `NEVER` before the first.
    pub fn current(&self) -> Tag {
        self.tags.current()
    }

    /// The tag to which a PTAG calls this federate, though it may have no event there: to be begun when no event is
    /// earlier. Others of its cycle wait for what it sends at that tag, or for word that there is nothing.
    pub fn demanded_tag(&self) -> Option<Tag> {
        self.tags.demanded_tag().filter(|tag| *tag <= self.stop.last_tag())
    }

    /// Whether it is known of all inputs what comes at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.tags.knows_all_inputs()
    }

    /// The tag at which the whole federation stops; `None` before [`Event::StopGranted`](super::Event::StopGranted).
    pub fn stop_tag(&self) -> Option<Tag> {
        self.stop.granted()
    }

    /// Whether this federate has named a tag to stop at, and the RTI has not decided.
    pub fn awaits_stop_tag(&self) -> bool {
        self.stop.is_open()
    }

    /// Whether a message with this tag may be sent: not after this federate's last tag, for nobody will get there.
    pub fn may_send(&self, tag: Tag) -> bool {
        tag <= self.stop.last_tag()
    }

    /// The place of the federate to which a connection is to be made next, among those to which this one sends.
    pub fn next_peer_index(&self) -> Option<usize> {
        self.session.next_peer_index(&self.config)
    }

    /// What clock synchronization has found out; `None` unless it goes on while the federation runs.
    pub fn clock_sync_report(&self) -> Option<ClockSyncReport> {
        matches!(self.config.clock_sync, ClockSync::On { .. }).then(|| self.clock.report())
    }
}
