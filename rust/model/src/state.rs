// SPDX-License-Identifier: Apache-2.0
//! The engine's variables, apart from its queues.
use crate::bits::Bits;
use crate::cell::Bounds;
use crate::error::ModelError;
use crate::tables::{PortId, ReactionId, Tables, TriggerId};
use crate::time::{Instant, Interval, Tag};

/// The settings of a program, from its target properties.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Whether other federates take part in the decision when it stops.
    pub federated: bool,
    /// The last tag is this long after the start.
    pub timeout: Option<Interval>,
    /// Without events, wait for some instead of stopping.
    pub keepalive: bool,
    /// Logical time does not wait for physical time. The event loop honours it.
    pub fast: bool,
}

impl Settings {
    /// Not federated, no timeout, ends without events, in real time.
    pub const DEFAULT: Self = Self { federated: false, timeout: None, keepalive: false, fast: false };
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    NotStarted,
    BetweenTags,
    InTag,
    Done,
}

/// The engine's own variables, apart from its tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) phase: Phase,
    pub(crate) start: Instant,
    /// The first tag of the program.
    #[cfg(feature = "transients")]
    pub(crate) first: Tag,
    /// The tag that is open, or the last one that was; before the first, the one before the start.
    pub(crate) current: Tag,
    pub(crate) stop: Tag,
    /// The last tag for which something is sent: that of the federation, which goes on if this program stops alone.
    pub(crate) sends_until: Tag,
    pub(crate) stop_request: Option<Tag>,
    pub(crate) error: Option<ModelError>,
    pub(crate) network_input: bool,
    /// The lowest level from which on no reaction has run at the open tag.
    pub(crate) untouched: u16,
    /// The time that tags wait for messages, if a body has set it.
    pub(crate) max_wait: Option<Interval>,
    /// Whether the environment is told what reactions do.
    #[cfg(feature = "traces")]
    pub(crate) records_steps: bool,
}

impl State {
    /// Returns the first tag of the program.
    pub(crate) fn first(&self) -> Tag {
        #[cfg(feature = "transients")]
        let first = self.first;
        #[cfg(not(feature = "transients"))]
        let first = Tag::at(self.start);
        first
    }

    /// Makes the next microstep the last tag of this program, or this tag if that is later, whatever other federates
    /// do.
    pub(crate) fn stop_alone(&mut self, earliest: Tag) {
        self.stop = self.stop.min(self.current.next_microstep().max(earliest));
    }

    /// Makes `tag` the last one of this program, and of those that it sends to.
    pub(crate) fn stop_at(&mut self, tag: Tag) {
        self.stop = self.stop.min(tag);
        self.sends_until = self.sends_until.min(tag);
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { start: self.first().time, current: self.current, stop: self.stop }
    }

    /// Returns whether the open tag is the last one.
    pub(crate) fn is_last(&self) -> bool {
        self.current == self.stop
    }

    /// Stores the first error, which ends the program after the reaction.
    pub(crate) fn fail(&mut self, error: ModelError) {
        self.error.get_or_insert(error);
    }

    pub(crate) fn request_stop(&mut self, tag: Tag, federated: bool) {
        if !federated {
            self.stop = self.stop.min(tag);
        } else if tag < self.stop {
            self.stop_request = Some(self.stop_request.map_or(tag, |earlier| earlier.min(tag)));
        }
    }
}

/// A message that was in time: its tag, and the tag at which it takes effect, after others with the same tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Last {
    pub(crate) sent: Tag,
    pub(crate) happens: Tag,
}

impl Last {
    pub(crate) const NONE: Self = Self { sent: Tag::NEVER, happens: Tag::NEVER };
}

/// The tardy values of the open tag. For programs whose inputs are never tardy it has no memory and stays empty.
#[derive(Debug)]
pub(crate) struct Tardy<'s> {
    /// The reactions that see a tardy input, or a port that was set because of one.
    pub(crate) reactions: Bits<'s>,
    /// The intended tag of each input's value; NEVER if it is not tardy.
    pub(crate) intended: &'s mut [Tag],
}

impl Tardy<'_> {
    pub(crate) fn clear(&mut self) {
        self.reactions.clear();
        self.intended.fill(Tag::NEVER);
    }
}

/// Returns whether a reaction is marked as tardy. Programs whose inputs are never tardy have no marks.
pub(crate) fn is_tardy(tardy: &Bits<'_>, reaction: ReactionId) -> bool {
    !tardy.0.is_empty() && tardy.contains(reaction.0)
}

/// Returns the intended tag of the value of the input that fills this port, if it is tardy.
pub(crate) fn intended_for(tables: &Tables, intended: &[Tag], port: PortId) -> Option<Tag> {
    let fills = |trigger: TriggerId| tables.triggers[usize::from(trigger.0)].kind.fills() == Some(port);
    let mut inputs = tables.inputs.iter().zip(intended);
    let (_, intended) = inputs.find(|(input, _)| fills(input.trigger))?;
    Some(*intended).filter(|intended| *intended != Tag::NEVER)
}
