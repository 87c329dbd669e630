// SPDX-License-Identifier: Apache-2.0
//! The operations of an event loop on a federate, in any order.

use arbitrary::{Arbitrary, Result, Unstructured};
use lf_coordination::federate::Federate;
use lf_model::time::{Instant, Tag};
use lf_wire::MessageType;

use crate::messages::Parts;
use crate::parts::{self, tag};

/// The most frequent messages of the RTI.
const USUAL: &[MessageType] = &[
    MessageType::TagGrant,
    MessageType::TagGrant,
    MessageType::TagGrant,
    MessageType::ProvisionalTagGrant,
    MessageType::DownstreamNextEventTag,
    MessageType::TaggedMessage,
    MessageType::PortAbsent,
    MessageType::UpstreamDisconnected,
    MessageType::StopRequest,
    MessageType::StopGranted,
];

/// An operation of the event loop or of the RTI.
#[derive(Debug)]
pub(super) enum Operation {
    Connected,
    Disconnected,
    Hear(Parts),
    Timeout,
    Written,
    Transmit(usize),
    NextEvent(Tag),
    Begin(Tag),
    /// Begins this tag if the federate has allowed it.
    BeginIfAllowed(Tag),
    Complete(bool),
    Sent,
    RequestStop(Tag),
    LimitStop(Tag),
    Finish,
    Fail,
}

impl Operation {
    pub(super) fn any(input: &mut Unstructured<'_>, start: i64) -> Result<Self> {
        Ok(match u8::arbitrary(input)? {
            0..4 => Self::Connected,
            4..6 => Self::Disconnected,
            6..80 => {
                let message_type = *input.choose(USUAL)?;
                Self::Hear(parts::of_type(input, message_type, start)?)
            }
            80..90 => Self::Hear(parts::any(input, start)?),
            90..100 => Self::Timeout,
            100..104 => Self::Written,
            104..140 => Self::Transmit(usize::from(u8::arbitrary(input)?)),
            140..180 => Self::NextEvent(tag(input, start)?),
            180..184 => Self::Begin(tag(input, start)?),
            184..215 => Self::BeginIfAllowed(tag(input, start)?),
            215..235 => Self::Complete(bool::arbitrary(input)?),
            235..245 => Self::Sent,
            245..248 => Self::RequestStop(tag(input, start)?),
            248..251 => Self::LimitStop(tag(input, start)?),
            251..253 => Self::Finish,
            _ => Self::Fail,
        })
    }

    /// Runs the operation, apart from the federate's output. Returns whether the federate can continue.
    pub(super) fn act(&self, federate: &mut Federate<'_>, now: Instant) -> bool {
        match self {
            Self::Connected => federate.handle_connected(now, [7; 8]),
            Self::Disconnected => return federate.handle_disconnected().is_ok(),
            Self::Hear(parts) => return federate.handle_message(now, parts.message()).is_ok(),
            Self::Timeout => return federate.handle_timeout(now).is_ok(),
            Self::Written => federate.handle_written(now),
            Self::NextEvent(tag) => drop(federate.next_event(now, *tag)),
            Self::Begin(tag) => return federate.begin(*tag).is_ok(),
            Self::BeginIfAllowed(tag) if federate.may_advance(*tag) => return federate.begin(*tag).is_ok(),
            Self::BeginIfAllowed(_) | Self::Transmit(_) => {}
            Self::Complete(input) => federate.complete(*input),
            Self::Sent => federate.sent(),
            Self::RequestStop(tag) => federate.request_stop(*tag),
            Self::LimitStop(tag) => federate.limit_stop(*tag),
            Self::Finish => federate.finish(),
            Self::Fail => federate.fail(),
        }
        true
    }
}
