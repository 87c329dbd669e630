// SPDX-License-Identifier: Apache-2.0
//! What people are told of a federation by its RTI.

use lf_coordination::rti::{Notice, Waits};
use log::Level;

use crate::remark::tell;

/// Logs a notice at the level of its importance; of what happens often, now and then one.
pub fn log_notice(notice: Notice<'_>) {
    if !notice.is_told() {
        return;
    }
    let level = match notice {
        Notice::Lost { .. }
        | Notice::Missing(_)
        | Notice::Rejected { .. }
        | Notice::RejectedBy { .. }
        | Notice::Late { .. } => Level::Error,
        Notice::HandshakeAbandoned { .. }
        | Notice::SuspectedViolation { .. }
        | Notice::MadeWay(_)
        | Notice::Sum { .. }
        | Notice::Waits(Waits::Grant { .. } | Waits::Stop(_) | Waits::Sender { .. })
        | Notice::Stranger(_)
        | Notice::UnknownType { .. }
        | Notice::InTransitFull(_) => Level::Warn,
        Notice::Dropped { .. } => Level::Debug,
        Notice::Joined(_)
        | Notice::Waits(Waits::Start { .. } | Waits::StartFor { .. } | Waits::StartForMore(_))
        | Notice::Started(_)
        | Notice::Resigned(_)
        | Notice::StopRequested(_)
        | Notice::StopGranted(_) => Level::Info,
    };
    tell(level, &notice);
}
