// SPDX-License-Identifier: Apache-2.0
//! The grants and the completed tags of one federate.

use lf_model::time::Tag;

use super::in_transit::Ring;

/// The tags of one federate that the RTI knows, except for its next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TagState {
    /// Latest tag completed.
    pub(super) completed: Tag,
    /// Latest TAG sent.
    pub(super) granted: Tag,
    /// Latest PTAG sent.
    pub(super) provisional: Tag,
    /// Latest DNET sent.
    pub(super) dnet: Tag,
    /// A downstream federate has been granted this tag provisionally and may wait for this one there.
    pub(super) demand: Option<(Tag, u16)>,
    /// Messages in transit to it.
    pub(super) in_transit: Ring,
    /// Whether it has left.
    pub(super) departed: bool,
}

impl TagState {
    /// The state without a grant or a completed tag.
    pub(super) const EMPTY: Self = Self {
        completed: Tag::NEVER,
        granted: Tag::NEVER,
        provisional: Tag::NEVER,
        dnet: Tag::NEVER,
        demand: None,
        in_transit: Ring::EMPTY,
        departed: false,
    };

    /// Returns the latest tag that it was granted, provisionally or not.
    pub(super) fn reach(&self) -> Tag {
        self.granted.max(self.provisional)
    }

    /// Revokes all grants from `tag` on. Returns whether there was one.
    pub(super) fn revoke(&mut self, tag: Tag) -> bool {
        let is_granted = self.granted.max(self.provisional.before()) >= tag;
        if is_granted {
            self.granted = self.granted.min(tag.before());
            self.provisional = self.provisional.min(tag.before());
        }
        is_granted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_model::time::{Instant, Microstep};
    use proptest::prelude::*;

    fn tag() -> impl Strategy<Value = Tag> {
        (0..9i64, 0..3u32).prop_map(|(time, microstep)| Tag::new(Instant::from_nanos(time), Microstep(microstep)))
    }

    proptest! {
        /// Everything before the tag stays granted, and nothing else does; a PTAG of the tag itself does not count,
        /// because it allows no more than a new one will.
        #[test]
        fn a_revoked_grant_does_not_count(granted in tag(), provisional in tag(), from in tag()) {
            let before = TagState { granted, provisional, ..TagState::EMPTY };
            let mut state = before;
            if state.revoke(from) {
                prop_assert!(state.reach() < from && (granted >= from || provisional > from));
                prop_assert_eq!(state.granted, granted.min(from.before()));
            } else {
                prop_assert_eq!(state, before);
                prop_assert!(granted < from && provisional <= from);
            }
        }
    }
}
