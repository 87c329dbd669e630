// SPDX-License-Identifier: Apache-2.0
//! One federate of a federation, from the first connection to its end.
//!
//! The event loop reports events to [`Federate`] (`handle_*`) and its own steps (commands), and asks it for messages to
//! send and for the time of the next call (`poll_*`). All times are readings of the participant's *own* clock, which
//! never jumps; [`Federate::clock`] converts them to the federation's physical time.
//!
//! # Duties of the event loop
//!
//! 1. Connect by [`ConnectRetry`], then call [`Federate::handle_connected`], with a nonce if the federate
//!    authenticates. Pass every decoded message to [`Federate::handle_message`], in order, and the end of the
//!    connection to [`Federate::handle_disconnected`].
//! 2. After *every* call that takes `&mut self`, move messages from [`Federate::poll_transmit`] to the connection's
//!    out-buffer until it returns `None`; if room is short, continue when there is some. A late call loses nothing: the
//!    messages are computed from state, with one slot per kind. Data messages go straight into the same out-buffer,
//!    followed by a call of [`Federate::sent`]. Put all data messages of a tag into the out-buffer *before*
//!    [`Federate::complete`] and the following [`Federate::next_event`]: as both buffer and socket keep the order, no
//!    LTC or NET can then overtake a message that it covers. A NET for tag t itself may go out before or after t's
//!    messages.
//! 3. When a write has emptied the out-buffer, call [`Federate::handle_written`]: T3 of the clock synchronization is
//!    the time after the write.
//!
//!    With [`ClockSync::On`], pass each datagram to [`Federate::handle_datagram`] as soon as it comes, with the time
//!    right after it was read, and send the answer at once.
//! 4. Call [`Federate::handle_timeout`] at the time of [`Federate::poll_timeout`]; each call may change that time.
//! 5. Once started, call [`Federate::next_event`] whenever the next tag changes. When it returns `true` and the tag's
//!    physical time has come, call [`Federate::begin`], run the tag, and call [`Federate::complete`]. After an
//!    [`Event::Granted`] or [`Event::StopGranted`], call [`Federate::next_event`] again.
//!
//!    In a cycle without delay, [`Federate::demanded_tag`] may return a tag before the next event. Begin it like any
//!    other, because federates downstream wait for the messages of this tag, or for their absence. Tell [`Awaited`] of
//!    everything that comes at awaited inputs, and run only reactions below [`Awaited::max_level`].
//!
//!    With decentralized coordination the RTI grants nothing, and [`Federate::begin`] accepts any tag that a stop does
//!    not forbid: [`Awaited`] says when a tag may begin, and how long its reactions wait. The RTI receives no tags.
//! 6. After the last tag call [`Federate::finish`]; after an error of the program [`Federate::fail`]. After either of
//!    them, and after an error that this state machine returns, send what `poll_transmit` still returns, and end the
//!    writing direction of the connection at once, because the RTI holds up all others until then. Close it when the
//!    RTI has ended its own direction: closing it with unread bytes would reset it, and RESIGN could be lost. An error
//!    is final; the federate then ignores whatever comes.
//!
//! # Parts
//!
//! [`Federate`] consists of parts, each with a state of its own: the way to the start and the end (`session`, with its
//! due messages in `outbox` and the connections to others in `peers`), the clock (`clock_sync`), the state of tags
//! (`tags`, with the rules for NETs in `net_rules`), physical actions (`physical`), how far the federate may run ahead
//! of the RTI (`flow_control`), whether others have left in order (`departure`), federates that come and go
//! (`transient_state`) and stops (`stop`). No part knows the whole;
//! `machine` passes calls to them.

mod awaited;
mod clock_sync;
mod config;
mod connect;
mod decentralized;
mod departure;
mod error;
mod event;
mod flow_control;
mod machine;
mod needs;
mod net_rules;
mod outbox;
mod peers;
mod phase;
mod physical;
mod session;
mod stop;
mod tags;
#[cfg(feature = "transients")]
mod transient_state;
#[cfg(feature = "transients")]
mod transients;
mod view;

pub use awaited::{Awaited, AwaitedInput};
pub use clock_sync::{ClockSyncReport, Received};
pub use config::{
    ADVANCE_INTERVAL, CLOCK_SYNC_TIME_OUT, CLOCK_SYNC_TRIALS, CONNECT_RETRY, CONNECT_TIME_OUT, ClockSync, Config,
    Coordination,
};
pub use connect::{ConnectRetry, ConnectStep};
pub use decentralized::Pause;
pub use error::{ConfigError, FederateError, SAME_PROGRAM, before_start, late};
pub use event::{Disconnected, Event};
pub use machine::Federate;
pub use needs::{All, Needs};
pub use peers::ADDRESS_RETRY;
pub use phase::Phase;
