// SPDX-License-Identifier: Apache-2.0
//! The ids that a peer may have while the federation runs.

use lf_wire::RejectCode;

use super::config::Config;
use super::log_event::Violation;
use super::members::Members;
use super::stop::Stop;
use super::storage::{Membership, Phase};
use super::tags::Tags;

/// Whether federates may join.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Admission {
    /// As if there were no transient federates: it has not started, or expects none.
    Usual,
    /// Transient federates may join the running federation.
    Open,
    /// The federation runs, but nobody may join any more.
    Over,
}

impl Admission {
    pub(super) fn of(config: &Config<'_>, tags: &Tags<'_>, stop: &Stop) -> Self {
        match (config.transients() > 0 && tags.start.is_some(), tags.horizon.is_open && stop.granted().is_none()) {
            (false, _) => Self::Usual,
            (true, true) => Self::Open,
            (true, false) => Self::Over,
        }
    }

    /// Returns whether a peer takes the place of another instance, which runs, when it has this id, or why it cannot
    /// have it; `None` while no federate comes and goes.
    pub(super) fn entry(
        self,
        members: &Members<'_>,
        federate: u16,
        is_transient: bool,
    ) -> Option<Result<bool, (RejectCode, Option<Violation>)>> {
        if self == Self::Usual {
            return None;
        }
        let slot = &members.slots[usize::from(federate)];
        let takes = is_transient && slot.is_transient();
        let in_use = Err((RejectCode::IdInUse, None));
        Some(match slot.membership {
            Membership::Departed if takes && self == Self::Open => Ok(false),
            Membership::Departed if is_transient && !slot.is_transient() => {
                Err((RejectCode::IdInUse, Some(Violation::HasLeft)))
            }
            Membership::Free | Membership::Departed => Err((RejectCode::JoinsTooLate, None)),
            Membership::Joined(_) if takes && self == Self::Open => {
                let claims = members.connections.iter().filter(|other| other.federate == Some(federate));
                let is_alone = claims.filter(|other| other.phase != Phase::Draining).count() == 1;
                if is_alone && slot.clock.is_some() { Ok(true) } else { in_use }
            }
            Membership::Joined(_) | Membership::Joining(_) => in_use,
        })
    }
}
