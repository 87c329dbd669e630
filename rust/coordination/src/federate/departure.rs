// SPDX-License-Identifier: Apache-2.0
//! The question whether a federate that sent directly has left in order, after its connection ended without a word.
//!
//! A federate of this project sends a last message on every direct connection before it closes it. The stock federate
//! just closes, and so does the system of a killed process. The RTI knows the difference, because a federate that
//! leaves in order sends RESIGN. Two questions that every RTI answers find out what it knows:
//!
//! 1. Does this RTI report departures? This federate advertises that it has no address, and asks for its own address.
//!    Our RTI keeps the address, because that advertisement has a meaning of its own (module `rti::stop`); a stock RTI
//!    forgets it. No other question for addresses is open by then, as all connections are made before the start.
//! 2. Where is the other federate? Our RTI knows the computer of each federate that is there, also of one without a
//!    port, and of none that has left. After a loss it sends FAILED instead, unless the others are to go on without the
//!    lost federate; then that one has left, too.
//!
//! A stock RTI reports no loss. With it the end of a connection counts as a departure in order.

use lf_model::time::Instant;
use lf_wire::{ADDRESS_PORT_UNKNOWN, Message};

use super::outbox::query;
use super::peers::ADDRESS_RETRY;
use crate::{Deadline, FederateId};

/// The question about one other federate at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    /// Whether the RTI reports departures, once it has shown that.
    reports: Option<bool>,
    /// Whether this federate has advertised that it has no address.
    advertised: bool,
    question: Inquiry,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Inquiry {
    #[default]
    None,
    Due(FederateId),
    Asked(FederateId),
    /// The RTI has not seen this federate leave; the next question is due at this time.
    Again(FederateId, Instant),
    /// This federate has left.
    Left(FederateId),
}

impl Departure {
    /// Returns whether this federate is known to have left in order. If that is not known, asks the RTI.
    pub(super) fn has_left(&mut self, federate: FederateId) -> bool {
        if self.reports == Some(false) {
            return true;
        }
        match self.question {
            Inquiry::None => self.question = Inquiry::Due(federate),
            Inquiry::Left(left) if left == federate => {
                self.question = Inquiry::None;
                return true;
            }
            _ => {}
        }
        false
    }

    /// Returns whether the RTI owes an answer.
    #[cfg(feature = "transients")]
    pub(super) fn is_asked(&self) -> bool {
        matches!(self.question, Inquiry::Asked(_))
    }

    /// Returns the next advertisement or question for the RTI, from the federate with this id.
    pub(super) fn due(&self, own: FederateId) -> Option<Message<'static>> {
        let Inquiry::Due(federate) = self.question else { return None };
        Some(match self.reports {
            None if !self.advertised => Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN },
            None => query(own, false),
            Some(_) => query(federate, false),
        })
    }

    /// Records that the message of [`Departure::due`] has been transmitted.
    pub(super) fn transmitted(&mut self, message: &Message<'_>) {
        match (message, self.question) {
            (Message::AddressQuery { .. }, Inquiry::Due(federate)) => self.question = Inquiry::Asked(federate),
            _ => self.advertised = true,
        }
    }

    /// Handles the RTI's answer: whether it knows a port of the federate in question, and its computer. Has no effect
    /// when no question is open.
    pub(super) fn answered(&mut self, now: Instant, has_port: bool, has_address: bool) {
        let Inquiry::Asked(federate) = self.question else { return };
        self.question = match self.reports {
            None => {
                self.reports = Some(has_port);
                Inquiry::Due(federate)
            }
            Some(_) if has_address => Inquiry::Again(federate, now + ADDRESS_RETRY),
            Some(_) => Inquiry::Left(federate),
        };
        if self.reports == Some(false) {
            self.question = Inquiry::None;
        }
    }

    /// Returns the time at which to call [`Departure::handle_timeout`].
    pub(super) fn poll_timeout(&self) -> Deadline {
        match self.question {
            Inquiry::Again(_, time) => Deadline::At(time),
            _ => Deadline::Never,
        }
    }

    /// Repeats the question if that is due.
    pub(super) fn handle_timeout(&mut self, now: Instant) {
        if let Inquiry::Again(federate, time) = self.question
            && time <= now
        {
            self.question = Inquiry::Due(federate);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: FederateId = FederateId(0);
    const OTHER: FederateId = FederateId(1);
    const ADVERTISEMENT: Message<'static> = Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN };

    fn transmit(departure: &mut Departure) -> Option<Message<'static>> {
        let message = departure.due(OWN)?;
        departure.transmitted(&message);
        Some(message)
    }

    #[test]
    fn our_rti_is_asked_until_it_knows_no_computer_of_the_other_federate() {
        let (mut departure, now) = (Departure::default(), Instant::from_nanos(5));
        assert_eq!(departure.due(OWN), None);
        assert!(!departure.has_left(OTHER));
        assert_eq!(
            [transmit(&mut departure), transmit(&mut departure)],
            [Some(ADVERTISEMENT), Some(query(OWN, false))]
        );
        assert!(transmit(&mut departure).is_none());
        // Our RTI keeps the address of this federate.
        departure.answered(now, true, true);
        assert_eq!(transmit(&mut departure), Some(query(OTHER, false)));
        // It is there, and no federate connects to it.
        departure.answered(now, false, true);
        assert!(!departure.has_left(OTHER) && departure.due(OWN).is_none());
        let again = now + ADDRESS_RETRY;
        assert_eq!(departure.poll_timeout(), Deadline::At(again));
        departure.handle_timeout(again);
        assert_eq!(transmit(&mut departure), Some(query(OTHER, false)));
        departure.answered(again, false, false);
        assert!(departure.has_left(OTHER));
        // For the next one, this federate knows already what the RTI reports.
        assert!(!departure.has_left(FederateId(2)));
        assert_eq!(transmit(&mut departure), Some(query(FederateId(2), false)));
    }

    #[test]
    fn an_rti_that_forgets_addresses_is_asked_once_and_tells_of_no_departure() {
        let mut departure = Departure::default();
        assert!(!departure.has_left(OTHER));
        assert_eq!(
            [transmit(&mut departure), transmit(&mut departure)],
            [Some(ADVERTISEMENT), Some(query(OWN, false))]
        );
        departure.answered(Instant::from_nanos(5), false, true);
        assert!(departure.has_left(OTHER) && departure.has_left(FederateId(2)));
        assert_eq!((departure.due(OWN), departure.poll_timeout()), (None, Deadline::Never));
    }

    #[test]
    fn the_answer_about_one_federate_says_nothing_of_another() {
        let (mut departure, now) = (Departure::default(), Instant::from_nanos(5));
        assert!(!departure.has_left(OTHER) && !departure.has_left(FederateId(2)));
        while transmit(&mut departure).is_some() {}
        departure.answered(now, true, true);
        assert_eq!(transmit(&mut departure), Some(query(OTHER, false)));
        departure.answered(now, false, false);
        assert!(!departure.has_left(FederateId(2)) && departure.has_left(OTHER));
        assert!(!departure.has_left(FederateId(2)));
        assert_eq!(transmit(&mut departure), Some(query(FederateId(2), false)));
    }
}
