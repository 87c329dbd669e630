// SPDX-License-Identifier: Apache-2.0
//! The log events of participants: each sentence once, as the [`Display`](fmt::Display) of a value that can also be
//! written as a [`code`](lf_coordination::code), and be decoded to the sentence elsewhere.

use core::fmt::{self, Write};
use core::time::Duration;

use lf_coordination::clock_sync::ClockFault;
use lf_coordination::code::{Decode, Encode, Reader, Writer};
use lf_coordination::federate::ClockSyncReport;
use lf_coordination::rti::RtiEvent;
use lf_coordination::{Endpoint, IpAddress, Times, coded};
use lf_model::time::{EventTag, Instant, Interval};
use lf_texts::say;
use lf_wire::RejectCode;
use log::Level;

use crate::error::{PeerFault, RunError};
use crate::federate::{Advice, Reason, ReasonText};
use crate::image::{ImageError, RtiError, SettingsError};
use crate::platform::{NetError, RandomError};
#[cfg(feature = "security")]
use crate::secure::SecurityEvent;

/// A sentence that can be logged as a code: those of one type are a family, whose number the code begins with.
pub trait LogEvent: fmt::Display + Encode {
    /// The family's number.
    const FAMILY: u8;
}

/// Numbers the families, for both directions.
macro_rules! families {
    ($($(#[$condition:meta])? $number:literal $type:ident $(<$life:lifetime>)?),* $(,)?) => {
        $($(#[$condition])? impl $(<$life>)? LogEvent for $type $(<$life>)? {
            const FAMILY: u8 = $number;
        })*

        /// Passes the sentence of a code to `show`. `keep` makes a text outlive the code. Returns `false` if it is not
        /// a code of this release.
        pub fn explain(
            code: &str,
            keep: fn(&str) -> &'static str,
            show: &mut dyn FnMut(&dyn fmt::Display),
        ) -> bool {
            let Some((family, mut code)) = Reader::new(code, keep) else { return false };
            match family {
                $($(#[$condition])? $number => {
                    let Some(said) = $type::decode(&mut code).filter(|_| code.rest().is_empty()) else { return false };
                    show(&said);
                })*
                _ => return false,
            }
            true
        }
    };
}

families! {
    0 ImageError, 1 RtiError, 2 RtiEvent<'a>, 3 FederateEvent, 4 PeerEvent, 5 ConnectionEvent, 6 DeviceEvent,
    #[cfg(feature = "security")] 7 SecurityEvent,
}

/// A log event of a federate that goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FederateEvent {
    /// It has been waiting for this long.
    Waits {
        /// The reason.
        reason: Reason,
        /// The start of the federation, to which the tag is relative.
        start: Instant,
        /// The duration.
        lasts: Interval,
    },
    /// The federation id is the key of the authentication, and not secret.
    GuessableKey,
    /// Its clock is not synchronized while the federation runs.
    NoDatagrams,
    /// A datagram came from this address, which is not the RTI.
    Stranger(Endpoint),
    /// The results of clock synchronization.
    ClockSync(ClockSyncReport),
    /// The system has no buffers for sending.
    NoBuffers,
    /// Its clock has a problem.
    ClockFault(ClockFault),
}

impl fmt::Display for FederateEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // There are no rounds over UDP, and the sentences are long.
            Self::Stranger(_) | Self::ClockSync(_) | Self::ClockFault(_) if !cfg!(feature = "datagrams") => Ok(()),
            Self::Waits { reason, start, lasts } => {
                let (words, advice) = (ReasonText(*reason, *start), Advice(*reason));
                say!(f, "waiting for {words}, for {} ms{advice}", lasts.as_nanos() / 1_000_000)
            }
            Self::GuessableKey => say!(
                f,
                "the federation id is the key of `auth`, and others can guess this one: choose another with --id, or \
                 CONFIG_LF_FEDERATION_ID",
            ),
            Self::NoDatagrams => {
                say!(f, "the clock is synchronized before the start only, because this image has no UDP")
            }
            Self::Stranger(from) => {
                say!(f, "datagrams from {from}, which is not the RTI, are ignored")
            }
            Self::ClockSync(report) => say!(f, "clock synchronization: {report}"),
            Self::ClockFault(fault) => fault.fmt(f),
            Self::NoBuffers => say!(
                f,
                "out of network buffers: what is to be sent waits for them; more of them make it quicker \
                 (CONFIG_NET_BUF_TX_COUNT, CONFIG_NET_PKT_TX_COUNT)",
            ),
        }
    }
}

coded!(FederateEvent {
    Waits { reason, start, lasts }, GuessableKey, NoDatagrams, Stranger(from), ClockSync(report), NoBuffers,
    ClockFault(fault),
});

/// A log event of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeviceEvent {
    /// The queue of the action that a device schedules had no room for this many events.
    EventsLost {
        /// The device, by its name in the program.
        device: &'static str,
        /// Their number since the last log event.
        events: u32,
    },
}

impl fmt::Display for DeviceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::EventsLost { device, events } = self;
        say!(
            f,
            "events of {device} that its action's queue had no room for: {events}; write @capacity(n) with a larger n \
             before the action's declaration"
        )
    }
}

coded!(DeviceEvent { EventsLost { device, events } });

/// A log event of connections with other federates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeerEvent {
    /// A federate to which this one sends has left.
    Left(u16),
    /// The final messages of a federate could not be read.
    LastMessages(RunError),
    /// A federate goes on sending after the end of this one.
    DoesNotEnd(u16),
    /// A federate has left in the middle of a message.
    LeftInMessage(u16),
    /// A message came for a tag after the last one.
    AfterStop {
        /// The connection.
        input: &'static str,
        /// The message's tag.
        intended: EventTag,
    },
    /// A message came too late, and not everything that it triggers handles that.
    Late {
        /// The connection.
        input: &'static str,
        /// The message's tag.
        intended: EventTag,
        /// The tag at which it takes effect; `None` when it came after the last one.
        actual: Option<EventTag>,
        /// The time by which it came after its own time.
        lateness: Duration,
        /// The receiver.
        federate: u16,
        /// The number of such messages.
        times: Times,
    },
    /// At the end: some messages were late.
    LateInAll {
        /// Their number.
        messages: u64,
        /// The number of those that no reaction has handled.
        unhandled: u64,
    },
    /// At the end: messages did not reach a federate.
    Lost {
        /// Their minimum number.
        messages: u64,
        /// The federate.
        to: u16,
    },
    /// At the end: a federate left earlier than this one.
    LeftBefore(u16),
    /// A connection was refused.
    Refused {
        /// Its source.
        address: IpAddress,
        /// The reason.
        code: RejectCode,
        /// The number of such connections.
        times: Times,
    },
    /// A transient federate was refused.
    Transient {
        /// Its id.
        federate: u16,
        /// The number of refused connections.
        times: Times,
    },
    /// A connection was closed whose peer did not send its id.
    Unidentified {
        /// Its source.
        address: IpAddress,
        /// The number of such connections.
        times: Times,
    },
}

impl fmt::Display for PeerEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Left(federate) => say!(f, "federate {federate} has left: messages to it are lost"),
            Self::LastMessages(error) => {
                say!(f, "what another federate sent at the end could not be read: {error}")
            }
            Self::DoesNotEnd(from) => {
                say!(f, "federate {from} does not end: what it may still send is not waited for")
            }
            Self::LeftInMessage(from) => say!(f, "federate {from} has left in the middle of a message"),
            Self::AfterStop { input, intended } => {
                say!(f, "a message over {input} is for {intended}, after the last tag: it does not happen")
            }
            Self::Late { input, intended, actual, lateness, federate, times } => {
                say!(f, "late message to federate {federate} over {input} for {intended}: it ")?;
                match actual {
                    Some(actual) => say!(f, "happens at {actual}, {lateness:?} after its time{times}"),
                    None => say!(
                        f,
                        "came {lateness:?} after its time, and after the last tag, so it does not happen{times}"
                    ),
                }
            }
            Self::LateInAll { messages, unhandled: 0 } => say!(f, "{messages} late messages"),
            Self::LateInAll { messages, unhandled } => say!(
                f,
                "{messages} late messages, {unhandled} of them not handled: wait longer with @maxwait or \
                 @absent_after, or give the reactions tardy handlers"
            ),
            Self::Lost { messages, to } => say!(f, "at least {messages} messages to federate {to} did not reach it"),
            Self::LeftBefore(to) => {
                say!(f, "federate {to} left before this one: messages on their way to it may be lost")
            }
            Self::Refused { address, code, times } => {
                say!(f, "a connection from {address} was refused: {code}{times}")
            }
            Self::Transient { federate, times } => say!(
                f,
                "federate {federate} was refused, because it is transient: it may come and go while the federation \
                 runs, and this federate awaits it at the start; remove `@transient` from its program{times}"
            ),
            Self::Unidentified { address, times } => {
                say!(f, "a connection from {address} did not say which federate it is, and was closed{times}")
            }
        }
    }
}

coded!(PeerEvent {
    Left(federate), LastMessages(error), DoesNotEnd(from), LeftInMessage(from), AfterStop { input, intended },
    Late { input, intended, actual, lateness, federate, times }, LateInAll { messages, unhandled },
    Lost { messages, to }, LeftBefore(to), Refused { address, code, times }, Transient { federate, times },
    Unidentified { address, times },
});

/// A log event of incoming connections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConnectionEvent {
    /// One cannot be authenticated.
    NoRandom(RandomError),
    /// The system did not hand one over.
    NotAccepted {
        /// The reason.
        error: NetError,
        /// The number of times that this has happened.
        times: Times,
    },
}

impl fmt::Display for ConnectionEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRandom(error) => say!(f, "a connection is refused: {error}"),
            Self::NotAccepted { error, times } => say!(f, "a connection could not be accepted: {error}{times}"),
        }
    }
}

coded!(ConnectionEvent { NoRandom(error), NotAccepted { error, times } });

coded!(NetError {
    Refused, Reset, Unreachable, AddressInUse, NoSocketLeft, Stale, Os(number),
    #[cfg(feature = "security")]
    Insecure,
});
coded!(PeerFault {
    Bytes(error), Unexpected(message), WrongInput { federate, port }, Unreachable(error), Unanswered, Refuses(code),
    Blocked, WrongTag { port },
});
coded!(RunError {
    RtiUnreachable { address, last }, Random(error), Federate(error), Config(error), Model(error),
    Bytes { error, phase }, Deliver(error), Interrupted, InputFull { input }, Late { input, tag, current },
    BeforeStart { input, by }, TooLong { input, bytes, max }, KnownTooShort { needed, found }, Bind(error),
    Listen(error), Peer { federate, fault }, TagFull { input }, BufferTooSmall { buffer, needed, found },
});
coded!(Reason {
    Rti(address, last), Answer(phase), Peer(federate, fault), Others, Grant(tag), Input(tag, name), Room(tag, federate),
    Id,
});
coded!(SettingsError { RtiAddress, RtiPort(port) });
coded!(ImageError { Descriptor, Settings(error), Run(error), Running });
coded!(RtiError { Settings(error), Listen { port, error }, Bind(error), Setup(error), Ended(outcome), Order });

impl Encode for RandomError {
    fn encode(&self, to: &mut Writer<'_>) {
        self.0.encode(to);
    }
}

impl Decode for RandomError {
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        i32::decode(from).map(Self)
    }
}

/// Whether log events are sentences, and not codes.
pub const TEXTS: bool = cfg!(feature = "texts");

/// Logs an event at this level: as a sentence, or without [`TEXTS`] as a code.
pub fn report<T: LogEvent>(level: Level, said: &T) {
    if level > log::STATIC_MAX_LEVEL {
        return;
    }
    if TEXTS {
        log::log!(level, "{said}");
    } else {
        log::log!(level, "{}", Code::of(said));
    }
}

/// Bytes of the longest code. A longer one, with a long name of a connection, is cut.
const CODE_BYTES: usize = 96;

/// The code of a log event.
#[derive(Debug)]
pub struct Code {
    bytes: [u8; CODE_BYTES],
    length: usize,
}

impl Code {
    /// Returns the code of a log event.
    pub fn of<T: LogEvent>(said: &T) -> Self {
        let mut bytes = [0; CODE_BYTES];
        let length = Writer::write(&mut bytes, T::FAMILY, said);
        Self { bytes, length }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let code = self.bytes.get(..self.length).unwrap_or_default();
        // Codes are ASCII, and code that checks that of a text is large.
        code.iter().try_for_each(|byte| f.write_char(char::from(*byte)))
    }
}
