// SPDX-License-Identifier: Apache-2.0
//! Codes instead of sentences, for images without texts: a code names the sentence and has the numbers in it.
//!
//! An error or a log event is an enum whose [`Display`](core::fmt::Display) is its sentence. [`coded!`](crate::coded)
//! writes the index of its variant and its fields as numbers, and reads them back on another computer, which has the
//! sentence. So a sentence stands in one place, and a code is as exact as the sentence.
//!
//! A code looks like `lf#0.c.1f4."a.out -> b.in"`: numbers in hexadecimal, texts between quotation marks.

use core::net::Ipv4Addr;
#[cfg(feature = "ipv6")]
use core::net::Ipv6Addr;
use core::time::Duration;

use lf_model::time::{EventTag, Instant, Interval, Microstep, Tag};
use lf_model::{DeliverError, ModelError, PayloadError};
use lf_wire::{DecodeError, MessageType, RejectCode};

use crate::clock_sync::{ClockFault, Line};
use crate::federate::{ClockSyncReport, ConfigError, FederateError, Phase};
use crate::rti::{Cause, Outcome, Progress, RtiEvent, SetupError, SuspectedViolation, Violation, Waits};
use crate::{Endpoint, FederateId, IpAddress, Times};

/// The first characters of each code.
pub const PREFIX: &str = "lf#";

/// A value that can be written as a code.
pub trait Encode {
    /// Writes what identifies the value.
    fn encode(&self, to: &mut Writer<'_>);
}

/// A value that can be read from a code.
pub trait Decode: Sized {
    /// Returns the value; `None` if the code does not stand for one.
    fn decode(from: &mut Reader<'_>) -> Option<Self>;
}

/// Writes a code, piece by piece.
#[derive(Debug)]
pub struct Writer<'a> {
    bytes: &'a mut [u8],
    length: usize,
}

impl<'a> Writer<'a> {
    /// Writes the code of `value`, which belongs to the family with this number, into these bytes, as far as it fits.
    /// Returns its length.
    pub fn write(bytes: &'a mut [u8], family: u8, value: &dyn Encode) -> usize {
        let mut writer = Self { bytes, length: 0 };
        writer.put(PREFIX.as_bytes());
        writer.digits(u64::from(family));
        value.encode(&mut writer);
        writer.length
    }

    /// Writes a number. Digits are hexadecimal, because they need no division.
    #[inline(never)]
    pub fn number(&mut self, number: u64) {
        self.put(b".");
        self.digits(number);
    }

    /// Writes a number of 32 bits, as most are.
    #[inline(never)]
    pub fn small(&mut self, number: u32) {
        self.number(number.into());
    }

    /// Writes a text. A quotation mark would end it, but names of a program have none. A code is ASCII.
    #[inline(never)]
    pub fn text(&mut self, text: &str) {
        self.put(b".\"");
        for byte in text.as_bytes() {
            self.put(&[if byte.is_ascii() { *byte } else { b'?' }]);
        }
        self.put(b"\"");
    }

    fn digits(&mut self, number: u64) {
        let mut shift = 64_u32.saturating_sub(number.leading_zeros()).div_ceil(4).max(1) * 4;
        while shift > 0 {
            shift -= 4;
            let digit = (number >> shift).to_le_bytes()[0] & 0xF;
            self.put(&[if digit < 10 { b'0' + digit } else { b'a' - 10 + digit }]);
        }
    }

    fn put(&mut self, text: &[u8]) {
        for (place, byte) in self.bytes.iter_mut().skip(self.length).zip(text) {
            *place = *byte;
            self.length += 1;
        }
    }
}

/// Reads a code, piece by piece.
#[derive(Debug)]
pub struct Reader<'a> {
    rest: &'a str,
    /// Makes a text outlive the code: errors name parts of the program, and on the board these names are static.
    keep: fn(&str) -> &'static str,
}

impl<'a> Reader<'a> {
    /// Returns a reader of this code and the number of its family; `None` if it is not a code.
    pub fn new(code: &'a str, keep: fn(&str) -> &'static str) -> Option<(u8, Self)> {
        let code = code.strip_prefix(PREFIX)?;
        let (family, rest) = code.split_at(code.find('.').unwrap_or(code.len()));
        Some((u8::from_str_radix(family, 16).ok()?, Self { rest, keep }))
    }

    /// Reads a number.
    pub fn number(&mut self) -> Option<u64> {
        let rest = self.rest.strip_prefix('.')?;
        let (digits, rest) = rest.split_at(rest.find(|sign: char| !sign.is_ascii_hexdigit()).unwrap_or(rest.len()));
        self.rest = rest;
        u64::from_str_radix(digits, 16).ok()
    }

    /// Reads a text.
    pub fn text(&mut self) -> Option<&'static str> {
        let (text, rest) = self.rest.strip_prefix(".\"")?.split_once('"')?;
        self.rest = rest;
        Some((self.keep)(text))
    }

    /// Returns what follows everything that was read.
    pub fn rest(self) -> &'a str {
        self.rest
    }
}

/// Writes and reads the variants of an enum by their index in the list, and their fields in order.
#[macro_export]
macro_rules! coded {
    ($type:ident $(<$life:lifetime>)? {
        $($(#[$condition:meta])? $variant:ident $(($($place:ident),*))? $({ $($field:ident),* })?),* $(,)?
    }) => {
        const _: () = {
            #[derive(Clone, Copy)]
            enum Kind { $($(#[$condition])? $variant),* }
            impl $(<$life>)? $crate::code::Encode for $type $(<$life>)? {
                fn encode(&self, to: &mut $crate::code::Writer<'_>) {
                    match self {
                        $($(#[$condition])? Self::$variant $(($($place),*))? $({$($field),*})? => {
                            to.small(Kind::$variant as u32);
                            $($($crate::code::Encode::encode($place, to);)*)?
                            $($($crate::code::Encode::encode($field, to);)*)?
                        })*
                    }
                }
            }
            impl $(<$life>)? $crate::code::Decode for $type $(<$life>)? {
                fn decode(from: &mut $crate::code::Reader<'_>) -> Option<Self> {
                    let kind = from.number()?;
                    $($(#[$condition])? {
                        if kind == Kind::$variant as u64 {
                            $($(let $place = $crate::code::Decode::decode(from)?;)*)?
                            $($(let $field = $crate::code::Decode::decode(from)?;)*)?
                            return Some(Self::$variant $(($($place),*))? $({$($field),*})?);
                        }
                    })*
                    None
                }
            }
        };
    };
}

/// Writes and reads values that are one number, with the method that writes it.
macro_rules! numbers {
    ($($type:ty: $write:ident $value:ident => $number:expr, $from:ident => $made:expr;)*) => {$(
        impl Encode for $type {
            fn encode(&self, to: &mut Writer<'_>) {
                let $value = *self;
                to.$write($number);
            }
        }
        impl Decode for $type {
            fn decode(from: &mut Reader<'_>) -> Option<Self> {
                let $from = from.number()?;
                $made
            }
        }
    )*};
}

numbers! {
    bool: small value => value.into(), number => Some(number != 0);
    u8: small value => value.into(), number => Self::try_from(number).ok();
    u16: small value => value.into(), number => Self::try_from(number).ok();
    u32: small value => value, number => Self::try_from(number).ok();
    u64: number value => value, number => Some(number);
    usize: number value => value as u64, number => Self::try_from(number).ok();
    i32: number value => i64::from(value).cast_unsigned(), number => Self::try_from(number.cast_signed()).ok();
    i64: number value => value.cast_unsigned(), number => Some(number.cast_signed());
    Instant: number value => value.as_nanos().cast_unsigned(), number => Some(Self::from_nanos(number.cast_signed()));
    Interval: number value => value.as_nanos().cast_unsigned(), number => Some(Self::from_nanos(number.cast_signed()));
    Duration: number value => Interval::from_duration(value).as_nanos().cast_unsigned(),
        number => Some(Self::from_nanos(number));
    FederateId: small value => value.0.into(), number => u16::try_from(number).ok().map(Self);
    Times: small value => value.0, number => u32::try_from(number).ok().map(Self);
    RejectCode: small value => value.byte().into(), number => u8::try_from(number).ok().map(Self::from_byte);
    MessageType: small value => value.byte().into(), number => Self::from_byte(u8::try_from(number).ok()?);
}

/// Writes and reads values that consist of several values.
macro_rules! structs {
    ($($type:ty { $($field:ident),* } = $make:expr;)*) => {$(
        impl Encode for $type {
            fn encode(&self, to: &mut Writer<'_>) {
                $(structs!(@ self $field).encode(to);)*
            }
        }
        impl Decode for $type {
            fn decode(from: &mut Reader<'_>) -> Option<Self> {
                $(let $field = Decode::decode(from)?;)*
                Some($make)
            }
        }
    )*};
    (@ $self:ident $field:ident) => { $self.$field };
}

structs! {
    Tag { time, microstep } = Self::new(time, Microstep(microstep));
    EventTag { offset_from_t0, microstep } = Self::new(offset_from_t0, microstep);
    ClockSyncReport { exchanges, unused, calm, line } = Self { exchanges, unused, calm, line };
    Line { at, offset, drift_ppb, width } = Self { at, offset, drift_ppb, width };
    Endpoint { ip, port } = Self { ip, port };
}

/// The mark that replaces the bits of an IPv4 address: an IPv6 address follows.
#[cfg(feature = "ipv6")]
const IPV6: u64 = 1 << 32;

impl Encode for IpAddress {
    fn encode(&self, to: &mut Writer<'_>) {
        match *self {
            Self::V4(address) => to.small(address.to_bits()),
            #[cfg(feature = "ipv6")]
            Self::V6(address, scope) => {
                to.number(IPV6);
                for segment in address.segments() {
                    segment.encode(to);
                }
                to.small(scope);
            }
        }
    }
}

impl Decode for IpAddress {
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        let number = from.number()?;
        #[cfg(feature = "ipv6")]
        if number == IPV6 {
            let mut segments = [0_u16; 8];
            for segment in &mut segments {
                *segment = u16::decode(from)?;
            }
            return u32::decode(from).map(|scope| Self::v6(Ipv6Addr::from(segments), scope));
        }
        u32::try_from(number).ok().map(|bits| Self::V4(Ipv4Addr::from_bits(bits)))
    }
}

impl Encode for Microstep {
    fn encode(&self, to: &mut Writer<'_>) {
        self.0.encode(to);
    }
}

impl Encode for &'static str {
    fn encode(&self, to: &mut Writer<'_>) {
        to.text(self);
    }
}

impl Decode for &'static str {
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        from.text()
    }
}

/// Bytes of a peer, which need not be a text.
impl Encode for &[u8] {
    fn encode(&self, to: &mut Writer<'_>) {
        to.number(self.len() as u64);
        for byte in *self {
            byte.encode(to);
        }
    }
}

impl Decode for &[u8] {
    /// Reads bytes as a text; other bytes are replaced.
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        let mut bytes = [0; 255];
        let length = usize::decode(from)?;
        for place in bytes.get_mut(..length)? {
            *place = u8::decode(from)?;
        }
        let text = core::str::from_utf8(bytes.get(..length)?).unwrap_or("?");
        Some((from.keep)(text).as_bytes())
    }
}

impl<T: Encode> Encode for Option<T> {
    fn encode(&self, to: &mut Writer<'_>) {
        to.small(self.is_some().into());
        if let Some(value) = self {
            value.encode(to);
        }
    }
}

impl<T: Decode> Decode for Option<T> {
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        if from.number()? == 0 { Some(None) } else { T::decode(from).map(Some) }
    }
}

coded!(PayloadError {
    Absent, NoRoom { needed, available }, Length { expected, found }, Remainder { element, found },
    TooLong { capacity, found }, NotBool(byte), Nul, NotUtf8, NotChar(number), NotVariant(number), LongerThan(bound),
    NotSerialized, NotDeserialized,
});
coded!(ModelError {
    ActionFull { action, capacity }, DelayFull { connection, capacity }, Encode { output, error },
    TagOrder { tag, against }, NotReady { tag }, NoThreadLeft { threads },
});
coded!(DeliverError {
    Full { input, capacity }, Payload { input, error }, Late { input, tag, current }, NoSuchPort { port },
});
coded!(DecodeError {
    UnknownType { found }, OverLimit { message, field, offset, found, limit },
    Negative { message, field, offset, found }, LargerThanBuffer { message, needed, capacity },
    Unexpected { message },
});

coded!(Phase {
    Disconnected,
    Authenticating,
    Introducing,
    Synchronizing,
    Meeting,
    Starting,
    Running,
    Resigning,
    Ended,
    Failed,
});
coded!(ClockFault { Drift(ppb), Unsteady(off), OtherPort { port, other }, FarOff(off) });
coded!(ConfigError { FederationIdTooLong { bytes }, NoTrials, AdvanceInterval });
coded!(FederateError {
    Rejected(code), RtiNotAuthentic, NoAnswer, NoClockSync, TrialsDiffer { trials }, PeerUnreachable { federate },
    Unexpected { message, phase }, WrongDestination { federate }, LateMessage { port, tag, current },
    BeforeStart { port, by }, RtiFailed, RtiLost { phase }, NotGranted { tag }, NotLater { tag, current },
    NoTag { port },
});

coded!(SetupError {
    FederationIdTooLong { bytes }, StartTimeMultiple, ClockSyncPeriod, Window, Federates { slots },
    Storage { part, needed, found }, #[cfg(feature = "transients")] Transients { transients, federates },
});
coded!(Violation {
    Bytes(error), TooLong { bytes, max }, Unexpected(message), Clock(clock), NoSuchFederate(id),
    Delay { upstream, delay_ns }, TooManyUpstream { max }, OtherFederate(id), NoAuthentication, HasLeft,
    Transient, NoTag { to }, #[cfg(feature = "transients")] OtherNeighbors,
});
coded!(Cause {
    Failed, ConnectionLost, Violation(violation), NoClock, NoStopReply, NoMemory { bytes }, Aborted,
});
coded!(Outcome { Complete, Lost { federate, cause }, NotStarted { first, missing }, Aborted });
coded!(SuspectedViolation { NotGranted(tag), Backwards { next, completed }, Ahead { of, by }, OtherFamily(of) });
coded!(Progress { Absent, Handshake(next), Joined });
coded!(Waits {
    Start { missing, federates, strangers }, StartFor { federate, progress }, StartForMore(more),
    Grant { federate, tag, lasts, by, at }, Stop(federate), Sender { from, to, room, lasts },
});
coded!(RtiEvent<'a> {
    Joined(federate), Started(start), Rejected { code, federate, federation_id, violation, times },
    RejectedBy { federate, code, times }, HandshakeAbandoned { federate, timed_out, times }, Evicted(times),
    Resigned(federate), Lost { federate, cause, started }, SuspectedViolation { federate, violation }, Waits(waits),
    Missing(federate), UnknownType { federate, found, times }, Dropped { from, to, times }, Late { from, to, times },
    Sum { federate, unknown, late, dropped }, InTransitFull(federate), StopRequested(federate), StopGranted(tag),
    Stranger(from), #[cfg(feature = "transients")] Begins { federate, tag },
    #[cfg(feature = "transients")] Replaced(federate), #[cfg(feature = "transients")] Missed { from, to, times },
});

#[cfg(test)]
mod tests {
    use std::string::String;

    use super::*;

    fn code(value: &dyn Encode) -> String {
        let mut bytes = [0; 96];
        let length = Writer::write(&mut bytes, 2, value);
        String::from_utf8_lossy(&bytes[..length]).into_owned()
    }

    fn back<T: Decode>(code: &str) -> Option<T> {
        let (family, mut reader) = Reader::new(code, |text| String::from(text).leak())?;
        let value = T::decode(&mut reader)?;
        (family == 2 && reader.rest().is_empty()).then_some(value)
    }

    #[test]
    fn decoded_codes_equal_the_encoded_values() {
        let tag = |time: i64| EventTag::relative(Tag::at(Instant::from_nanos(time)), Instant::from_nanos(0));
        for error in [
            FederateError::NoAnswer,
            FederateError::Rejected(RejectCode::Other(77)),
            FederateError::Unexpected { message: MessageType::T4, phase: Phase::Meeting },
            FederateError::LateMessage { port: 3, tag: tag(1_000_000_000), current: tag(0) },
            FederateError::BeforeStart { port: 0, by: Interval::from_nanos(-5) },
        ] {
            assert_eq!(back(&code(&error)), Some(error));
        }
        let refused = RtiEvent::Rejected {
            code: RejectCode::FederationIdMismatch,
            federate: None,
            federation_id: Some(b"grid"),
            violation: Some(Violation::Bytes(DecodeError::Negative {
                message: MessageType::NeighborStructure,
                field: "upstream count",
                offset: 1,
                found: -7,
            })),
            times: Times(10),
        };
        assert_eq!(back(&code(&refused)), Some(refused));
        let full = ModelError::ActionFull { action: "main.a.x", capacity: 16 };
        assert_eq!(code(&full), "lf#2.0.\"main.a.x\".10");
        assert_eq!(back(&code(&full)), Some(full));
    }

    #[test]
    fn addresses_of_both_families_can_be_told() {
        for ip in ["10.0.0.1", "255.255.255.255", "::1", "fd00::abcd:1", "ffff:ffff:ffff:ffff:ffff:ffff:ffff:ffff"] {
            let ip: core::net::IpAddr = ip.parse().expect("an address");
            let told = RtiEvent::Stranger(Endpoint::new(ip, 15045));
            assert_eq!(back(&code(&told)), Some(told));
        }
    }

    #[test]
    fn text_that_is_no_code_is_refused() {
        for text in ["", "lf#", "lf#2", "lf#2.e", "lf#2.0", "lf#2.1.0", "lf#3.1", "lf#2.0.\"open"] {
            assert_eq!(back::<FederateError>(text), None, "{text}");
        }
    }

    #[test]
    fn a_code_that_is_too_long_is_cut() {
        let mut bytes = [0; 8];
        assert_eq!(Writer::write(&mut bytes, 0, &u64::MAX), 8);
        assert_eq!(&bytes, b"lf#0.fff");
    }
}
