// SPDX-License-Identifier: Apache-2.0
//! The recordings of an image's participants; there are none without `CONFIG_LF_TRACE`.

use lf_runtime::trace::Recording;

/// The participant of an image whose records these are.
#[derive(Clone, Copy, Debug)]
pub enum RecordedParticipant {
    /// The federate, or a program that is not federated.
    Federate,
    /// The RTI.
    Rti,
}

impl RecordedParticipant {
    /// Returns what is told, if the image records what happens.
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, reason = "nothing is recorded"))]
    pub fn recording(&mut self) -> Recording<'_> {
        #[cfg(feature = "traces")]
        return Recording::new(self, cfg!(CONFIG_LF_TRACE_VALUES));
        #[cfg(not(feature = "traces"))]
        Recording::OFF
    }
}
