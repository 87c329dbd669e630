// SPDX-License-Identifier: Apache-2.0
//! One federate of a federation, from the first connection to its end.
//!
//! [`Federate`] is told what happens (`handle_*`) and what its event loop does (commands), and is asked for what to
//! send and when it wants to be called (`poll_*`). All times given to it are readings of the participant's *own* clock,
//! which never jumps; [`Federate::clock`] turns them into the federation's physical time.
//!
//! # What the event loop has to do
//!
//! 1. Connect by [`ConnectRetry`], then [`Federate::handle_connected`], with a nonce if it authenticates. Give every
//!    decoded message to [`Federate::handle_message`], in order, and the end of the connection to
//!    [`Federate::handle_disconnected`].
//! 2. After *every* call that takes `&mut self`, move messages from [`Federate::poll_transmit`] to the connection's
//!    out-buffer until it gives `None`; where room is short, go on when there is some. Nothing is lost by going on
//!    late: the messages are worked out from state, and there is one place per kind. Data messages go straight into the
//!    same out-buffer, and [`Federate::sent`] is told. Put all data messages of a tag into the out-buffer *before*
//!    [`Federate::complete`] and the following [`Federate::next_event`]: as both buffer and socket keep the order, no
//!    LTC or NET can then overtake a message that it speaks for. A NET for tag t itself may go out before or after t's
//!    messages.
//! 3. When the out-buffer has become empty by a write, call [`Federate::handle_written`]: T3 of the clock
//!    synchronization is the time after the write.
//!
//!    With [`ClockSync::On`], give each datagram to [`Federate::handle_datagram`] as soon as it has come, with the time
//!    right after it was read, and send the answer at once.
//! 4. Call [`Federate::handle_timeout`] when [`Federate::poll_timeout`] says so; the deadline may change with each
//!    call.
//! 5. Once started: [`Federate::next_event`] whenever the next tag is another one; when it returns `true`, and the
//!    tag's physical time has come, [`Federate::begin`], run the tag, [`Federate::complete`]. After a
//!    [`Event::Granted`] or [`Event::StopGranted`], ask again.
//!
//!    In a cycle without delay, [`Federate::demanded_tag`] may name a tag that comes before the next event: it is begun like
//!    any other, for federates downstream wait for the messages of this tag, or for word that there are none. Tell
//!    [`Awaited`] of all that comes at awaited inputs, and run only reactions below [`Awaited::max_level`].
//!
//!    With decentralized coordination nothing is granted, and [`Federate::begin`] takes any tag that a stop does not
//!    forbid: [`Awaited`] says when a tag may begin, and how long its reactions wait. The RTI hears of no tags.
//! 6. After the last tag [`Federate::finish`]; after an error of the program [`Federate::fail`]. After an error that
//!    this state machine returns, or after either of them: send what `poll_transmit` still gives, and end the writing
//!    direction of the connection at once, for the RTI holds up all others until then. Close it when the RTI has ended
//!    its own direction: closing it while something is unread would reset it, and RESIGN could be lost. An error is
//!    final; the federate then ignores whatever comes.
//!
//! # Parts
//!
//! [`Federate`] is made of parts, each with a state of its own: the way to the start and the end (`session`, with the
//! messages that are due in `outbox` and the connections to others in `peers`), the clock (`clock_sync`), the state of
//! tags (`tags`, with the rules for what the RTI has to be told in `net_rules`), physical actions (`physical`), how far
//! it may run ahead of the RTI (`pace`), whether others have left in order (`departure`) and stops (`stop`). None of
//! them knows the whole; `machine` hands on to them.

mod awaited;
mod clock_sync;
mod config;
mod connect;
mod decentralized;
mod departure;
mod error;
mod event;
mod machine;
mod needs;
mod net_rules;
mod outbox;
mod pace;
mod peers;
mod phase;
mod physical;
mod session;
mod stop;
mod tags;
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
pub use pace::TAGS_AHEAD_MAX;
pub use peers::ADDRESS_RETRY;
pub use phase::Phase;
