// SPDX-License-Identifier: Apache-2.0
//! A recording, checked and typed.

use super::mask::Mask;

/// One recorded run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    /// The file's name without its extension.
    pub name: String,
    /// A description of the run.
    pub description: String,
    /// Behavior of the recorded program that looks accidental; another program may differ here on purpose.
    pub quirk: Option<String>,
    /// The recorded program.
    pub source: String,
    /// The program under test and its configuration.
    pub role: Role,
    /// The run, from the view of the tester.
    pub steps: Vec<Step>,
}

impl Recording {
    /// Returns the configuration of the RTI, if it is the program under test.
    pub fn rti(&self) -> Option<&RtiSetup> {
        match &self.role {
            Role::Rti(setup) => Some(setup),
            Role::Federate(_) => None,
        }
    }

    /// Returns the configuration of the federate, if it is the program under test.
    pub fn federate(&self) -> Option<&FederateSetup> {
        match &self.role {
            Role::Federate(setup) => Some(setup),
            Role::Rti(_) => None,
        }
    }
}

/// The program under test. The tester plays all the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// An RTI.
    Rti(RtiSetup),
    /// A federate.
    Federate(FederateSetup),
}

/// The configuration of the recorded RTI.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RtiSetup {
    /// Number of federates.
    pub federates: u16,
    /// Number of transient federates.
    pub transient_federates: u16,
    /// The federation id.
    pub federation_id: String,
    /// Further options of the command line.
    pub options: Vec<String>,
    /// Whether it authenticates.
    pub auth: bool,
    /// Its exit code; negative: killed by that signal; none: it was still running. For information.
    pub exit_code: Option<i32>,
}

/// The configuration of the recorded federate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FederateSetup {
    /// Its id.
    pub id: u16,
    /// The federation id.
    pub federation_id: String,
    /// The federation's coordination of tags.
    pub coordination: Coordination,
    /// Ids of the upstream federates. Their delays are in the NEIGHBOR_STRUCTURE that it sends.
    #[allow(clippy::doc_markdown, reason = "the message's name in the protocol is no code")]
    pub upstream: Vec<u16>,
    /// Ids of the downstream federates.
    pub downstream: Vec<u16>,
    /// Its command line.
    pub arguments: Vec<String>,
    /// Whether it authenticates.
    pub auth: bool,
    /// A description of its reactions.
    pub program: String,
    /// Its exit code; negative: killed by that signal; none: it was still running. For information.
    pub exit_code: Option<i32>,
}

/// The coordination of tags in a federation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coordination {
    /// By grants of the RTI.
    Centralized,
    /// By waiting in each federate.
    Decentralized,
}

/// An action of the tester, or an event. Numbers are those of connections: below 100 the id of the federate, from 100
/// on connections before the handshake or between federates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// The tester (role federate: the federate) opens this connection.
    Connect(u16),
    /// The tester opens this connection to the port that the federate has advertised.
    P2pConnect(u16),
    /// The tester sends these bytes.
    Send(Frame),
    /// The tester receives this message.
    Recv(Frame),
    /// The tester closes this connection.
    Close(u16),
    /// The tester reads end-of-file on this connection: the program under test has closed it.
    ClosedByPeer(u16),
    /// No bytes arrived on these connections after the last action.
    Silence(Vec<u16>),
    /// The tester waits until its clock shows this many nanoseconds after the start time.
    Until(i64),
    /// The tester opens a UDP socket for this federate.
    UdpBind(u16),
    /// The tester sends this datagram.
    UdpSend(Frame),
    /// The tester receives this datagram.
    UdpRecv {
        /// The datagram.
        frame: Frame,
        /// The port from which it has to come, if the recording names it.
        from_port: Option<u16>,
    },
}

/// Bytes on a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The connection; of a datagram, the federate.
    pub connection: u16,
    /// The bytes. In a `send` usually one message; the recordings also contain parts of messages and several at once.
    pub bytes: Mask,
    /// The content for the masked bytes; only in frames that the tester sends, and there whenever a byte is masked.
    pub fill: Option<Fill>,
    /// The tag of a message whose time is masked because the start time varies. The start time itself is masked in
    /// front of an effective start.
    pub tag: Option<RelativeTag>,
    /// A description of the message for readers.
    pub message: String,
    /// A comment for readers.
    pub note: Option<String>,
}

/// The content for the masked bytes of frames that the tester sends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fill {
    /// The port of its UDP socket, u16.
    UdpPort,
    /// The port of its listener for other federates, i32.
    P2pPort,
    /// Its clock, i64 in nanoseconds.
    PhysicalTime,
    /// The start time that it chooses, i64 in nanoseconds.
    Start,
    /// The time of [`Frame::tag`]: the start time plus the tag's nanoseconds, i64.
    TagTime,
    /// The HMAC with this key over the received nonce.
    Hmac {
        /// The key.
        key: String,
    },
}

impl Fill {
    /// Returns the number of bytes that it fills.
    pub const fn bytes(&self) -> usize {
        match self {
            Self::UdpPort => 2,
            Self::P2pPort => 4,
            Self::PhysicalTime | Self::Start | Self::TagTime => 8,
            Self::Hmac { .. } => 32,
        }
    }
}

/// A tag relative to the start time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelativeTag {
    /// Time after the start in nanoseconds.
    pub time_ns: i64,
    /// Microstep.
    pub microstep: u32,
}
