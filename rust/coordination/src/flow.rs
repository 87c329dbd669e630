// SPDX-License-Identifier: Apache-2.0
//! The messages by which a federate and the RTI agree on how far the federate may run ahead.
//!
//! A federate asks the RTI by a `PORT_ABSENT` for itself, which every RTI sends back once it has taken everything
//! before it. The question names an input that does not exist and a time at which nothing happens, so it has no other
//! meaning; its microstep is the window that the federate offers, or 0. Ours answers an offer by a message of the same
//! kind for another such input, whose microstep is the window of the federation.

use lf_wire::{Message, Tag};

use crate::FederateId;

/// The number of tags with messages that a federate may begin before the RTI has taken them, and that the RTI lets lie
/// in front of a receiver. The queue of each network input has room for both.
pub const WINDOW: u16 = 16;
/// The largest window on which federates with larger receive buffers agree. More would gain little: a write and a read
/// of this many messages take longer than what surrounds them.
pub const WINDOW_MAX: u16 = 128;

/// The input that a question names.
const QUESTION_PORT: u16 = u16::MAX;
/// The input that the RTI's answer to an offer names.
const ANSWER_PORT: u16 = u16::MAX - 1;

fn message(port: u16, federate: FederateId, window: u16) -> Message<'static> {
    Message::PortAbsent { port, federate: federate.0, tag: Tag { microstep: window.into(), ..Tag::NEVER } }
}

/// Returns the window that a message names, if it is one of this kind between this federate and the RTI.
fn window_in(message: &Message<'_>, port: u16, federate: FederateId) -> Option<u16> {
    match *message {
        Message::PortAbsent { port: named, federate: to, tag } if named == port && to == federate.0 => {
            u16::try_from(tag.microstep).ok().filter(|_| tag.time == Tag::NEVER.time)
        }
        _ => None,
    }
}

/// Returns a federate's question, with the window that it offers, or 0.
pub(crate) fn question(federate: FederateId, offer: u16) -> Message<'static> {
    message(QUESTION_PORT, federate, offer)
}

/// Returns the window that a federate offers by this message.
pub(crate) fn offer_in(message: &Message<'_>, federate: FederateId) -> Option<u16> {
    window_in(message, QUESTION_PORT, federate).filter(|offer| *offer > 0)
}

/// Returns the RTI's answer to an offer: the window of the federation.
pub(crate) fn answer(federate: FederateId, window: u16) -> Message<'static> {
    message(ANSWER_PORT, federate, window)
}

/// Returns the window that an answer names, if this message is one: the usual window if an RTI without others has sent
/// the question back.
pub(crate) fn answered_in(message: &Message<'_>, federate: FederateId) -> Option<u16> {
    let returned = window_in(message, QUESTION_PORT, federate).map(|_| WINDOW);
    returned.or_else(|| window_in(message, ANSWER_PORT, federate).map(|window| window.clamp(WINDOW, WINDOW_MAX)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: FederateId = FederateId(3);

    #[test]
    fn only_messages_of_this_kind_have_a_window() {
        let at = |time, microstep| Tag { time, microstep };
        let absent = |port, federate, tag| Message::PortAbsent { port, federate, tag };
        for (message, offer, answered) in [
            (question(OWN, 0), None, Some(WINDOW)),
            (question(OWN, 100), Some(100), Some(WINDOW)),
            (question(FederateId(2), 100), None, None),
            (answer(OWN, 0), None, Some(WINDOW)),
            (answer(OWN, 100), None, Some(100)),
            (answer(OWN, u16::MAX), None, Some(WINDOW_MAX)),
            (absent(QUESTION_PORT, 3, at(0, 100)), None, None),
            (absent(QUESTION_PORT, 3, at(Tag::NEVER.time, 1 << 16)), None, None),
            (absent(7, 3, at(Tag::NEVER.time, 100)), None, None),
            (Message::TagGrant(at(Tag::NEVER.time, 100)), None, None),
        ] {
            assert_eq!((offer_in(&message, OWN), answered_in(&message, OWN)), (offer, answered), "{message:?}");
        }
    }
}
