// SPDX-License-Identifier: Apache-2.0
//! The log of an RTI.

use lf_coordination::rti::{RtiEvent, Waits};
use log::Level;

use crate::log_event::report;

/// Logs a event at the level of its importance; of what happens often, now and then one.
pub fn log_rti_event(event: RtiEvent<'_>) {
    if !event.is_logged() {
        return;
    }
    let level = match event {
        RtiEvent::Lost { .. }
        | RtiEvent::Missing(_)
        | RtiEvent::Rejected { .. }
        | RtiEvent::RejectedBy { .. }
        | RtiEvent::Late { .. } => Level::Error,
        RtiEvent::HandshakeAbandoned { .. }
        | RtiEvent::SuspectedViolation { .. }
        | RtiEvent::Evicted(_)
        | RtiEvent::Sum { .. }
        | RtiEvent::Waits(Waits::Grant { .. } | Waits::Stop(_) | Waits::Sender { .. })
        | RtiEvent::Stranger(_)
        | RtiEvent::UnknownType { .. }
        | RtiEvent::InTransitFull(_) => Level::Warn,
        RtiEvent::Dropped { .. } => Level::Debug,
        #[cfg(feature = "transients")]
        RtiEvent::Missed { .. } => Level::Debug,
        RtiEvent::Joined(_)
        | RtiEvent::Waits(Waits::Start { .. } | Waits::StartFor { .. } | Waits::StartForMore(_))
        | RtiEvent::Started(_)
        | RtiEvent::Resigned(_)
        | RtiEvent::StopRequested(_)
        | RtiEvent::StopGranted(_) => Level::Info,
        #[cfg(feature = "transients")]
        RtiEvent::Begins { .. } | RtiEvent::Replaced(_) => Level::Info,
    };
    report(level, &event);
}
