// SPDX-License-Identifier: Apache-2.0
//! The phases of a federate between its start and its end.

use core::fmt;

use lf_texts::text;

/// The phase of a federate. The phases follow each other in this order; each can lead to [`Phase::Failed`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Phase {
    /// Not connected yet.
    Disconnected,
    /// Connected; waiting for the RTI's proof that it knows the federation id.
    Authenticating,
    /// Connected; waiting for the RTI to accept this federate.
    Introducing,
    /// In the initial clock synchronization.
    Synchronizing,
    /// Connecting to the federates to which it sends directly.
    Meeting,
    /// Waiting for the start time, which the RTI sends when all federates have joined.
    Starting,
    /// The start time is known: tags are granted, begun and completed.
    Running,
    /// The last tag is complete, RESIGN is to be sent.
    Resigning,
    /// RESIGN has been sent.
    Ended,
    /// Ended because of an error.
    Failed,
}

impl fmt::Display for Phase {
    /// Completes a sentence such as "the connection ended …".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::Disconnected => text!("before this federate had connected"),
            Self::Authenticating => text!("during the authentication"),
            Self::Introducing => text!("before it had accepted this federate"),
            Self::Synchronizing => text!("during the initial clock synchronization"),
            Self::Meeting => text!("while this federate connected to others"),
            Self::Starting => text!("while this federate waited for the others to start"),
            Self::Running => text!("while this federate was running"),
            Self::Resigning => text!("before this federate could resign"),
            Self::Ended => text!("after this federate had resigned"),
            Self::Failed => text!("after this federate had failed"),
        };
        text.fmt(f)
    }
}
