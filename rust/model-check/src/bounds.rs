// SPDX-License-Identifier: Apache-2.0
//! How much can happen in one federation.

/// How much can happen. All events lie at the times 0 to `time_max` and the microsteps 0 to `microstep_max`; a reaction
/// that would cause more does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The last time, in ticks after the start.
    pub time_max: u8,
    /// The last microstep of each time.
    pub microstep_max: u8,
    /// Events of their own that all federates together have besides the first ones, at the start.
    pub own_events_max: u8,
    /// Messages that all federates together send.
    pub messages_max: u8,
    /// Whether federates are told which of their next events nobody needs (DNET).
    pub dnet: bool,
    /// How many federates may be lost, at any moment.
    pub losses_max: u8,
    /// Tags of messages on their way to one federate that the RTI has room for.
    pub in_transit: u8,
    /// Tags with messages that a federate may have before it that are earlier than what a sender has announced, before
    /// that sender is not heard any more.
    pub window: usize,
    /// Whether orders that cannot make a difference are left out. Only tests of that want them all.
    pub reduced: bool,
    /// What is done wrong, to see that it is found.
    pub fault: Option<Fault>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            time_max: 1,
            microstep_max: 1,
            own_events_max: 1,
            messages_max: 2,
            dnet: true,
            losses_max: 0,
            in_transit: 8,
            window: 16,
            reduced: true,
            fault: None,
        }
    }
}

/// What can be done wrong on purpose: a check that finds none of these would be worth nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The RTI is told that every connection takes one tick longer than it does.
    DelaysTooLong,
    /// Nobody says that it has completed a tag.
    NoCompletion,
    /// Nobody says that there will be no message.
    NoAbsence,
    /// A message is put into the connection behind the next event that is announced.
    LateMessages,
}
