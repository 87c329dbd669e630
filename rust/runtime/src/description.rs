// SPDX-License-Identifier: Apache-2.0
//! The description of a program for the event loop, from generated code. All of it is constant.

use crate::log_event::{FederateEvent, report};
use lf_coordination::auth::Answer;
use lf_coordination::federate::{AwaitedInput, ClockSync, Coordination};
use lf_coordination::rti::FEDERATION_ID_DEFAULT;
use lf_coordination::{WINDOW, WINDOW_MAX};
#[cfg(feature = "transients")]
use lf_model::HandedOver;
use lf_model::time::Interval;
use lf_model::{Settings, Tables};
use lf_wire::MessageType;
use log::{Level, LevelFilter};

/// Whether federates can have direct connections with others, as those with decentralized coordination do: the feature
/// `peers`. Without it no code for such connections is linked.
pub const PEERS: bool = cfg!(feature = "peers");

/// Whether federates can come and go while the federation runs: the feature `transients`. Without it no code for that
/// is linked.
pub const TRANSIENTS: bool = cfg!(feature = "transients");

/// One participant's program: a federate, or an unfederated main reactor.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// The program: the name of the main or federated reactor.
    pub program: &'static str,
    /// This participant: the name of the federate, or again that of the main reactor.
    pub name: &'static str,
    /// The target property `timeout`: the last tag's time after the start.
    pub timeout: Option<Interval>,
    /// The target property `keepalive`: an empty event queue does not end the program.
    pub keepalive: bool,
    /// The target property `fast`: logical time does not wait for physical time.
    pub fast: bool,
    /// The target property `logging`.
    pub logging: LevelFilter,
    /// The part in a federation; `None` for an unfederated program.
    pub federation: Option<Federation>,
}

impl Description {
    /// A program without a name and without options, for what generated code leaves out.
    pub const DEFAULT: Self = Self {
        program: "",
        name: "",
        timeout: None,
        keepalive: false,
        fast: false,
        logging: LevelFilter::Info,
        federation: None,
    };

    /// Returns the settings of the engine.
    pub const fn settings(&self) -> Settings {
        Settings {
            federated: self.federation.is_some(),
            timeout: self.timeout,
            keepalive: self.keepalive,
            fast: self.fast,
        }
    }

    /// Returns its part in the federation; an unfederated program has an empty part.
    pub const fn part(&self) -> &Federation {
        match &self.federation {
            Some(federation) => federation,
            None => &Federation::DEFAULT,
        }
    }

    /// Warns when the program authenticates with a key that others can guess: the federation id is the key, and by
    /// default it is the name of the program, or the stock RTI's default.
    pub fn check_key(&self, federation_id: &[u8]) {
        let authenticates = self.federation.is_some_and(|federation| federation.authentication.is_some());
        if authenticates && (federation_id == self.program.as_bytes() || federation_id == FEDERATION_ID_DEFAULT) {
            report(Level::Warn, &FederateEvent::GuessableKey);
        }
    }
}

/// A federate's part in its federation.
#[derive(Clone, Copy, Debug)]
pub struct Federation {
    /// The federate's id: its index among the federates, from 0.
    pub id: u16,
    /// The federation's id, unless the command line or Kconfig names another.
    pub federation_id: &'static str,
    /// The target property `auth`: the function by which it and the RTI prove that they know the federation id, if they
    /// authenticate.
    pub authentication: Option<Answer>,
    /// The way in which federates keep the order of tags.
    pub coordination: Coordination,
    /// The number of federates of the federation.
    pub federates: u16,
    /// The RTI's host, from `at`: an IP address or, if there is a resolver, a host name.
    pub rti_host: &'static str,
    /// The RTI's TCP port.
    pub rti_port: u16,
    /// The federates that send to this one, in order of id, each with the minimum delay of the connections in ns, or
    /// [`DELAY_NONE`](lf_wire::DELAY_NONE) if one has no `after`.
    pub upstream: &'static [(u16, i64)],
    /// The federates to which this one sends, in order of id.
    pub downstream: &'static [u16],
    /// The inputs from federates in the same cycle without delay, and with decentralized coordination all that are not
    /// physical: reactions wait until these inputs are known.
    pub awaited: &'static [AwaitedInput],
    /// Whether any federates of the federation are in a cycle without delay, so that the RTI may grant tags
    /// provisionally.
    pub cycles: bool,
    /// The federates from which this one has physical connections, and with decentralized coordination any connections,
    /// in order of id.
    pub peers_in: &'static [u16],
    /// The federates to which this one has such connections.
    pub peers_out: &'static [u16],
    /// The transient federates among this one and its neighbors: they come and go while the federation runs.
    pub transients: &'static [u16],
    /// Whether any of these connections is physical, so that its messages have no tags. [`Federation::with_buffers`]
    /// sets it.
    pub untagged: bool,
    /// The clock synchronization it takes part in.
    pub clock_sync: ClockSync,
    /// Whether it takes part in clock synchronization even if it runs on the RTI's computer and has the same clock.
    pub local_clock_sync: bool,
    /// The offset by which its own clock is ahead, as a test of clock synchronization.
    pub test_offset: Interval,
    /// The minimum delay from a physical action to an output to another federate; `None` when there is no such path.
    pub physical_delay: Option<Interval>,
    /// The target property `advance-message-interval`: the interval at which the federate announces its progress while
    /// its outputs depend on physical actions; longer than 0.
    pub advance_interval: Interval,
    /// The target property `log-waits`: the time after which a running federate logs what it waits for, if at all.
    pub log_waits: Option<Interval>,
    /// The window that the federate offers the RTI, or 0: see [`Federation::window_of`].
    pub window: u16,
    /// Bytes of the receive buffer, at least [`buffer_bytes`] of the longest payload that can come.
    pub input_bytes: usize,
    /// Bytes of the send buffer, at least [`buffer_bytes`] of the longest payload that can be sent.
    pub output_bytes: usize,
    /// Bytes of the receive buffer of each connection from another federate, at least [`peer_buffer_bytes`].
    pub peer_input_bytes: usize,
    /// Bytes of the send buffer of each connection to another federate, at least [`peer_buffer_bytes`].
    pub peer_output_bytes: usize,
}

impl Federation {
    /// A federate without neighbors, clock synchronization and options, for what generated code leaves out.
    pub const DEFAULT: Self = Self {
        id: 0,
        federation_id: "",
        authentication: None,
        coordination: Coordination::Centralized,
        federates: 0,
        rti_host: "",
        rti_port: 0,
        upstream: &[],
        downstream: &[],
        awaited: &[],
        cycles: false,
        peers_in: &[],
        peers_out: &[],
        transients: &[],
        untagged: false,
        clock_sync: ClockSync::Off,
        local_clock_sync: false,
        test_offset: Interval::ZERO,
        physical_delay: None,
        advance_interval: Interval::FOREVER,
        log_waits: None,
        window: 0,
        input_bytes: 0,
        output_bytes: 0,
        peer_input_bytes: 0,
        peer_output_bytes: 0,
    };

    /// Returns whether a federate, this one or a neighbor, comes and goes while the federation runs.
    pub fn is_transient(&self, federate: u16) -> bool {
        self.transients.contains(&federate)
    }

    /// Returns whether the RTI grants its tags.
    pub const fn is_centralized(&self) -> bool {
        matches!(self.coordination, Coordination::Centralized)
    }

    /// Returns the window for which a receive buffer of this many bytes has memory beside the longest message, or 0 if
    /// that is not larger than the usual one: twice as many messages of each input that comes through the RTI may wait.
    pub fn window_of(&self, tables: &Tables, input_bytes: usize) -> u16 {
        if !self.is_centralized() {
            return 0;
        }
        let lengths = tables.inputs.iter().filter(|input| !input.physical).map(|input| input.max_len);
        let bytes =
            lengths.map(|length| TAGGED_MESSAGE_HEADER_BYTES.saturating_add(length)).fold(0, usize::saturating_add);
        let spare = input_bytes.saturating_sub(self.input_bytes);
        let tags = spare.checked_div(bytes.saturating_mul(2)).unwrap_or(usize::MAX);
        let window = u16::try_from(tags).unwrap_or(u16::MAX).min(WINDOW_MAX);
        if window > WINDOW { window } else { 0 }
    }

    /// Returns whether other federates send to it through the RTI, or may do so.
    pub const fn has_inputs(&self) -> bool {
        self.is_centralized() && (!self.upstream.is_empty() || !self.peers_in.is_empty())
    }

    /// Returns the same with what follows from these tables: the smallest buffers that carry their payloads, and
    /// whether a connection is physical. Direct connections carry the payloads of physical connections, and with
    /// decentralized coordination all.
    #[must_use]
    pub const fn with_buffers(mut self, tables: &Tables) -> Self {
        let all_direct = matches!(self.coordination, Coordination::Decentralized);
        let (mut input, mut output) = ([0; 2], [0; 2]);
        let mut i = 0;
        while i < tables.inputs.len() {
            self.untagged |= tables.inputs[i].physical;
            let direct = (all_direct || tables.inputs[i].physical) as usize;
            input[direct] = larger(input[direct], tables.inputs[i].max_len);
            i += 1;
        }
        i = 0;
        while i < tables.outputs.len() {
            self.untagged |= tables.outputs[i].physical;
            let direct = (all_direct || tables.outputs[i].physical) as usize;
            output[direct] = larger(output[direct], tables.outputs[i].max_len);
            i += 1;
        }
        #[cfg(feature = "transients")]
        {
            i = 0;
            while i < tables.handed_over.len() {
                let bytes = tables.handed_over[i].max_len + HandedOver::ID_BYTES;
                (input[0], output[0]) = (larger(input[0], bytes), larger(output[0], bytes));
                i += 1;
            }
        }
        let neighbors = self.upstream.len() + self.downstream.len();
        self.input_bytes = buffer_bytes(input[0], neighbors);
        self.output_bytes = buffer_bytes(output[0], neighbors);
        self.peer_input_bytes = peer_buffer_bytes(input[1]);
        self.peer_output_bytes = peer_buffer_bytes(output[1]);
        self
    }
}

/// Bytes kept free in a send buffer for control messages, so that data never blocks them.
///
/// The longest control message of a running federation is 17 bytes; a federate owes at most a handful at a time. The
/// longest of the handshake is the neighbor structure, for which a buffer is larger by `neighbors`.
pub const CONTROL_BYTES: usize = 128;

/// Bytes of a tagged message before its payload: type, port, federate, length and tag.
pub const TAGGED_MESSAGE_HEADER_BYTES: usize = MessageType::TaggedMessage.fixed_bytes();

/// Returns the smallest buffer that carries messages with payloads up to `payload_bytes_max`, beside the control
/// messages and a handshake that names `neighbors` upstream and downstream federates.
pub const fn buffer_bytes(payload_bytes_max: usize, neighbors: usize) -> usize {
    const NEIGHBOR: usize = 10;
    const FEDERATION_ID_MAX: usize = 255;
    let message = TAGGED_MESSAGE_HEADER_BYTES + payload_bytes_max;
    let handshake = FEDERATION_ID_MAX + NEIGHBOR * neighbors;
    CONTROL_BYTES + larger(message, handshake)
}

/// Returns the smallest buffer of a connection between two federates, for payloads up to `payload_bytes_max`; it has
/// room for the introduction and for two messages.
pub const fn peer_buffer_bytes(payload_bytes_max: usize) -> usize {
    const FEDERATION_ID_MAX: usize = 255;
    let (messages, introduction) =
        (2 * (TAGGED_MESSAGE_HEADER_BYTES + payload_bytes_max), CONTROL_BYTES + FEDERATION_ID_MAX);
    larger(messages, introduction)
}

const fn larger(one: usize, other: usize) -> usize {
    if one > other { one } else { other }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_model::NetworkInput;

    /// Messages of 79 and 129 bytes, and a physical connection, whose messages do not come through the RTI.
    const TABLES: Tables = Tables {
        inputs: &[
            NetworkInput { max_len: 79 - TAGGED_MESSAGE_HEADER_BYTES, ..NetworkInput::DEFAULT },
            NetworkInput { max_len: 129 - TAGGED_MESSAGE_HEADER_BYTES, ..NetworkInput::DEFAULT },
            NetworkInput { max_len: 1 << 20, physical: true, ..NetworkInput::DEFAULT },
        ],
        ..Tables::DEFAULT
    };

    #[test]
    fn a_window_is_offered_for_which_the_receive_buffer_has_memory_twice() {
        let part = Federation { input_bytes: 500, ..Federation::DEFAULT };
        let tag = 79 + 129;
        for (bytes, window) in [
            (0, 0),
            (500, 0),
            (500 + 34 * tag - 1, 0),
            (500 + 34 * tag, 17),
            (500 + 80 * tag, 40),
            (500 + 256 * tag - 1, 127),
            (500 + 256 * tag, 128),
            (usize::MAX, 128),
        ] {
            assert_eq!(part.window_of(&TABLES, bytes), window, "{bytes}");
        }
        // Without inputs nothing has to wait, and without grants the RTI sends nothing.
        assert_eq!(part.window_of(&Tables::DEFAULT, 500), 128);
        let part = Federation { coordination: Coordination::Decentralized, ..part };
        assert_eq!(part.window_of(&TABLES, usize::MAX), 0);
    }
}
