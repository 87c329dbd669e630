// SPDX-License-Identifier: Apache-2.0
//! The bounds of what can happen in one federation.

/// The bounds of one federation. All events lie at the times 0 to `time_max` and the microsteps 0 to `microstep_max`; a
/// reaction sends nothing beyond them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The last time, in ticks after the start.
    pub time_max: u8,
    /// The last microstep of each time.
    pub microstep_max: u8,
    /// The number of local events that all federates together have besides the first ones, at the start.
    pub own_events_max: u8,
    /// The number of messages that all federates together send.
    pub messages_max: u8,
    /// Whether the RTI sends DNET.
    pub dnet: bool,
    /// The number of federates that may be lost, at any point; a transient one may leave in order instead.
    pub losses_max: u8,
    /// The federate that is transient: it may be absent at the start, leave in order, be lost, and come. Then no other
    /// federate is lost, and the RTI's clock is beyond all tags.
    pub transient: Option<u8>,
    /// The number of times that it comes while the federation runs.
    pub comings_max: u8,
    /// Whether a second instance of it may come while the first one is there, to take its place.
    pub swaps: bool,
    /// The number of tags of messages in transit to one federate that the RTI has room for.
    pub in_transit: u8,
    /// The number of tags with messages before a receiver and earlier than the sender's announced tag, from which on
    /// the RTI no longer reads that sender.
    pub window: u16,
    /// Whether orders that cannot make a difference are left out. Only tests of the reduction want them all.
    pub reduced: bool,
    /// The fault to inject, to see that the check finds it.
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
            transient: None,
            comings_max: 0,
            swaps: false,
            in_transit: 8,
            window: 16,
            reduced: true,
            fault: None,
        }
    }
}

/// The faults that can be injected: a check that misses any of them would be worthless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The RTI assumes a delay one tick longer than the true one for every connection.
    DelaysTooLong,
    /// No federate sends LTC.
    NoCompletion,
    /// No federate sends `PORT_ABSENT`.
    NoAbsence,
    /// A federate sends a message after it has announced its next event.
    LateMessages,
    /// An instance that is told to make way for another one stays.
    Stays,
}
