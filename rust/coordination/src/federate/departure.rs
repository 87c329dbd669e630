// SPDX-License-Identifier: Apache-2.0
//! Whether a federate has left in order that sent directly, and whose connection has ended without a word.
//!
//! A federate of ours says of every direct connection that nothing more comes before it closes it. The stock one just
//! closes, and so does the system of one that is killed. The RTI knows the difference, because it is told (RESIGN). Two
//! questions that every RTI answers find out what it knows:
//!
//! 1. Whether this RTI tells of departures. This federate advertises that it has no address, and asks for its own one.
//!    Our RTI keeps the address, because that advertisement has a meaning of its own (module `rti::stop`); a stock RTI
//!    forgets it. Nobody else asks for addresses any more, as all connections are made before the start.
//! 2. Where the other federate is. Our RTI knows the computer of each that is there, also of one that has no port, and
//!    none of one that has left. After a loss it says FAILED instead, unless the others are to go on without the lost
//!    one; then that has left, too.
//!
//! A stock RTI tells nobody of a loss. With it the end of a connection counts as a departure in order.

use lf_model::time::Instant;
use lf_wire::{ADDRESS_PORT_UNKNOWN, Message};

use super::peers::ADDRESS_RETRY;
use crate::{Deadline, FederateId};

/// What this federate finds out about another one, one at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    /// Whether the RTI tells of departures, once it has shown that.
    tells: Option<bool>,
    /// This federate has advertised that it has no address.
    advertised: bool,
    question: Inquiry,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Inquiry {
    #[default]
    None,
    Due(FederateId),
    Asked(FederateId),
    /// The RTI has not seen this federate leave; it is asked again then.
    Again(FederateId, Instant),
    /// This federate has left.
    Left(FederateId),
}

impl Departure {
    /// Whether it is known that this federate has left in order. If not, the RTI is asked.
    pub(super) fn has_left(&mut self, federate: FederateId) -> bool {
        if self.tells == Some(false) {
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

    /// What the RTI is to be told or asked next, by the federate with this id.
    pub(super) fn due(&self, own: FederateId) -> Option<Message<'static>> {
        let Inquiry::Due(federate) = self.question else { return None };
        Some(match self.tells {
            None if !self.advertised => Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN },
            None => query(own),
            Some(_) => query(federate),
        })
    }

    /// The message of [`Departure::due`] has been transmitted.
    pub(super) fn transmitted(&mut self, message: &Message<'_>) {
        match (message, self.question) {
            (Message::AddressQuery { .. }, Inquiry::Due(federate)) => self.question = Inquiry::Asked(federate),
            _ => self.advertised = true,
        }
    }

    /// The RTI's answer about the federate that was asked for: whether it knows a port of it, and its computer. Without
    /// effect when nothing was asked.
    pub(super) fn answered(&mut self, now: Instant, has_port: bool, has_address: bool) {
        let Inquiry::Asked(federate) = self.question else { return };
        self.question = match self.tells {
            None => {
                self.tells = Some(has_port);
                Inquiry::Due(federate)
            }
            Some(_) if has_address => Inquiry::Again(federate, now + ADDRESS_RETRY),
            Some(_) => Inquiry::Left(federate),
        };
        if self.tells == Some(false) {
            self.question = Inquiry::None;
        }
    }

    /// When [`Departure::handle_timeout`] is to be called.
    pub(super) fn poll_timeout(&self) -> Deadline {
        match self.question {
            Inquiry::Again(_, time) => Deadline::At(time),
            _ => Deadline::Never,
        }
    }

    /// Asks again, if it is time for that.
    pub(super) fn handle_timeout(&mut self, now: Instant) {
        if let Inquiry::Again(federate, time) = self.question
            && time <= now
        {
            self.question = Inquiry::Due(federate);
        }
    }
}

const fn query(federate: FederateId) -> Message<'static> {
    Message::AddressQuery { federate: federate.0, is_transient: Some(false) }
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
        assert_eq!([transmit(&mut departure), transmit(&mut departure)], [Some(ADVERTISEMENT), Some(query(OWN))]);
        assert!(transmit(&mut departure).is_none());
        // Our RTI keeps the address of this federate.
        departure.answered(now, true, true);
        assert_eq!(transmit(&mut departure), Some(query(OTHER)));
        // It is there, and nobody connects to it.
        departure.answered(now, false, true);
        assert!(!departure.has_left(OTHER) && departure.due(OWN).is_none());
        let again = now + ADDRESS_RETRY;
        assert_eq!(departure.poll_timeout(), Deadline::At(again));
        departure.handle_timeout(again);
        assert_eq!(transmit(&mut departure), Some(query(OTHER)));
        departure.answered(again, false, false);
        assert!(departure.has_left(OTHER));
        // For the next one, nothing has to be found out about the RTI.
        assert!(!departure.has_left(FederateId(2)));
        assert_eq!(transmit(&mut departure), Some(query(FederateId(2))));
    }

    #[test]
    fn an_rti_that_forgets_addresses_is_asked_once_and_tells_of_no_departure() {
        let mut departure = Departure::default();
        assert!(!departure.has_left(OTHER));
        assert_eq!([transmit(&mut departure), transmit(&mut departure)], [Some(ADVERTISEMENT), Some(query(OWN))]);
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
        assert_eq!(transmit(&mut departure), Some(query(OTHER)));
        departure.answered(now, false, false);
        assert!(!departure.has_left(FederateId(2)) && departure.has_left(OTHER));
        assert!(!departure.has_left(FederateId(2)));
        assert_eq!(transmit(&mut departure), Some(query(FederateId(2))));
    }
}
