// SPDX-License-Identifier: Apache-2.0
//! The errors of the model, each with a sentence that says what to do.
use core::fmt;

use lf_texts::say;

use crate::payload::PayloadError;
use crate::time::Tag;

/// An error that ends the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelError {
    /// An action was scheduled while its queue was full.
    ActionFull {
        /// The action's path in the program.
        action: &'static str,
        /// The capacity of its queue.
        capacity: usize,
    },
    /// A delayed connection had to carry a value while its queue was full.
    DelayFull {
        /// The path of the port at the end of the connection.
        connection: &'static str,
        /// The capacity of its queue.
        capacity: usize,
    },
    /// A value for another federate could not be written as bytes.
    Encode {
        /// The connection to the other federate.
        output: &'static str,
        /// The reason.
        error: PayloadError,
    },
    /// The event loop began a tag that is not later than the last one, or later than a pending event.
    TagOrder {
        /// The tag that was to begin.
        tag: Tag,
        /// The last tag, or the pending event's.
        against: Tag,
    },
    /// The event loop began a tag while another one was not complete, before the start, or after the end.
    NotReady {
        /// The tag that was to begin.
        tag: Tag,
    },
    /// A body asked for a thread when all threads of the image were running.
    NoThreadLeft {
        /// The number of threads that the image has.
        threads: usize,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ActionFull { action, capacity } => say!(
                f,
                "action {action} was scheduled while it held {capacity} pending events, which is all it has room for: \
                 write @capacity(n) with a larger n before its declaration, or schedule it less often"
            ),
            Self::DelayFull { connection, capacity } => say!(
                f,
                "the connection with `after` to {connection} held {capacity} values on their way, which is all it has \
                 room for: write @capacity(n) with a larger n before the connection, or send less often"
            ),
            Self::Encode { output, error } => say!(f, "a value cannot be sent over {output}: {error}"),
            Self::TagOrder { tag, against } => {
                say!(f, "tag {tag} cannot begin, because tag {against} comes first: this is an error of the event loop")
            }
            Self::NotReady { tag } => say!(
                f,
                "tag {tag} cannot begin, because the program is not between two tags: this is an error of the \
                 event loop"
            ),
            Self::NoThreadLeft { threads } => say!(
                f,
                "spawn_physical_thread was called while all of the image's threads ({threads}) were running: raise n \
                 in the target property `platform: {{user-threads: n}}`, or set CONFIG_LF_USER_THREADS"
            ),
        }
    }
}

impl core::error::Error for ModelError {}

/// The reason why a message from another federate was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeliverError {
    /// No room now: keep the message, and do not read its connection until
    /// [`Engine::has_room`](crate::Engine::has_room) returns `true`.
    Full {
        /// The connection.
        input: &'static str,
        /// The capacity of its queue.
        capacity: usize,
    },
    /// The payload is not a value of the port's type.
    Payload {
        /// The connection.
        input: &'static str,
        /// The reason.
        error: PayloadError,
    },
    /// The tag has passed.
    Late {
        /// The connection.
        input: &'static str,
        /// The message's tag.
        tag: Tag,
        /// The current tag.
        current: Tag,
    },
    /// The program has no such input.
    NoSuchPort {
        /// The port number on the wire.
        port: u16,
    },
}

impl fmt::Display for DeliverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { input, capacity } => say!(
                f,
                "{input} holds {capacity} messages, which is all it has room for: read no more until one has been \
                 handled"
            ),
            Self::Payload { input, error } => {
                say!(f, "a message for {input} does not fit its type: {error}; build all federates from one program")
            }
            Self::Late { input, tag, current } => say!(
                f,
                "a message for {input} came with tag {tag}, but this federate is at {current} already: \
                 check that all federates run the same program"
            ),
            Self::NoSuchPort { port } => {
                say!(
                    f,
                    "a message came for input {port}, which this federate does not have: build all federates from one \
                     program"
                )
            }
        }
    }
}

impl core::error::Error for DeliverError {}

/// A physical action was not scheduled, because its inbox is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScheduleError {
    /// The capacity of the inbox.
    pub capacity: usize,
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        say!(
            f,
            "{} events of this physical action wait already, which is all it has room for: write @capacity(n) with a \
             larger n before its declaration, or schedule it less often",
            self.capacity
        )
    }
}

impl core::error::Error for ScheduleError {}
