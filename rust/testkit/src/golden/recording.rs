// SPDX-License-Identifier: Apache-2.0
//! A recording, checked and typed.

use super::mask::Mask;

/// One recorded run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    /// The file's name without its extension.
    pub name: String,
    /// What the run shows.
    pub description: String,
    /// What looks accidental in the recorded program; another one may differ here on purpose.
    pub quirk: Option<String>,
    /// What was recorded.
    pub source: String,
    /// The program under test and how it was started.
    pub role: Role,
    /// The run, from the view of the tester.
    pub steps: Vec<Step>,
}

impl Recording {
    /// How the RTI was started, if it is the program under test.
    pub fn rti(&self) -> Option<&RtiSetup> {
        match &self.role {
            Role::Rti(setup) => Some(setup),
            Role::Federate(_) => None,
        }
    }

    /// How the federate was made, if it is the program under test.
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

/// How the recorded RTI was started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RtiSetup {
    /// Number of federates.
    pub federates: u16,
    /// How many of them are transient.
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

/// How the recorded federate was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FederateSetup {
    /// Its id.
    pub id: u16,
    /// The federation id.
    pub federation_id: String,
    /// How the federation keeps the order of tags.
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
    /// What it does, in words.
    pub program: String,
    /// Its exit code; negative: killed by that signal; none: it was still running. For information.
    pub exit_code: Option<i32>,
}

/// How a federation keeps the order of tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coordination {
    /// By grants of the RTI.
    Centralized,
    /// By the federates' waiting.
    Decentralized,
}

/// What the tester does, or what happens to it. Numbers are those of connections: below 100 the id of the federate,
/// from 100 on connections that are none, or not yet, or between federates.
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
    /// Nothing came on these connections after the last action.
    Silence(Vec<u16>),
    /// The tester opens a UDP socket for this federate.
    UdpBind(u16),
    /// The tester sends this datagram.
    UdpSend(Frame),
    /// The tester receives this datagram.
    UdpRecv {
        /// The datagram.
        frame: Frame,
        /// Port from which it has to come, where the recording says so.
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
    /// With what the tester fills the masked bytes; only of what it sends, and there whenever something is masked.
    pub fill: Option<Fill>,
    /// The tag, of a message whose time is masked because the start time varies.
    pub tag: Option<RelativeTag>,
    /// What it is, for people.
    pub message: String,
    /// What is worth noticing, for people.
    pub note: Option<String>,
}

/// With what the tester fills the masked bytes of what it sends.
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
    /// The HMAC, made with this key over the nonce that it has received.
    Hmac {
        /// The key.
        key: String,
    },
}

impl Fill {
    /// Number of bytes that it fills.
    pub const fn bytes(&self) -> usize {
        match self {
            Self::UdpPort => 2,
            Self::P2pPort => 4,
            Self::PhysicalTime | Self::Start | Self::TagTime => 8,
            Self::Hmac { .. } => 32,
        }
    }
}

/// A tag that counts from the start time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelativeTag {
    /// Time after the start in nanoseconds.
    pub time_ns: i64,
    /// Microstep.
    pub microstep: u32,
}
