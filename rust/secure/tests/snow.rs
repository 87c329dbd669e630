// SPDX-License-Identifier: Apache-2.0
//! Another implementation of Noise as the other end of a channel, in both roles.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use lf_secure::{Channel, ChannelStage, FederationSecret, Keyring, MARK, Member, Participant, REKEY_RECORDS, Role};
use snow::{HandshakeState, TransportState};
use support::{EPHEMERAL, FEDERATE, FEDERATION, RTI, secret};

/// The longest content of a record that the test's other end takes.
const CONTENT_MAX: u16 = 1000;

/// A peer made of `snow`, with the frames of a channel around its messages.
struct Peer {
    handshake: Option<HandshakeState>,
    transport: Option<TransportState>,
    is_marked: bool,
    has_marked: bool,
    came: Vec<u8>,
}

impl Peer {
    fn new(role: Role, own: u8) -> Self {
        let parameters = "Noise_XXpsk0_25519_ChaChaPoly_SHA256".parse().unwrap();
        let builder = snow::Builder::new(parameters).prologue(&[MARK, 1]).unwrap();
        let own = secret(own);
        let builder = builder.local_private_key(own.bytes()).unwrap().psk(0, &FEDERATION).unwrap();
        let handshake = match role {
            Role::Initiator => builder.build_initiator(),
            Role::Responder => builder.build_responder(),
        };
        let (is_marked, has_marked) = (false, false);
        Self { handshake: Some(handshake.unwrap()), transport: None, is_marked, has_marked, came: Vec::new() }
    }

    /// Returns what it sends next for its handshake.
    fn step(&mut self) -> Vec<u8> {
        let handshake = self.handshake.as_mut().unwrap();
        let is_first = !self.has_marked && handshake.is_initiator();
        let told = [&CONTENT_MAX.to_be_bytes()[..], &7_u32.to_be_bytes(), &0_u16.to_be_bytes()].concat();
        let mut message = [0; 256];
        let count = handshake.write_message(if is_first { &[] } else { &told }, &mut message).unwrap();
        let mut bytes = frame(&message[..count]);
        if !std::mem::replace(&mut self.has_marked, true) {
            bytes.splice(..0, [MARK, 1]);
        }
        self.finish();
        bytes
    }

    fn finish(&mut self) {
        if self.handshake.as_ref().is_some_and(HandshakeState::is_handshake_finished) {
            self.transport = Some(self.handshake.take().unwrap().into_transport_mode().unwrap());
        }
    }

    /// Handles what has come, and returns the contents of records.
    fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.came.extend_from_slice(bytes);
        let mut contents = Vec::new();
        if !self.is_marked && self.came.len() >= 2 {
            assert_eq!(self.came.drain(..2).collect::<Vec<_>>(), [MARK, 1]);
            self.is_marked = true;
        }
        while self.came.len() >= 2 {
            let length = usize::from(u16::from_be_bytes([self.came[0], self.came[1]]));
            if self.came.len() < 2 + length {
                break;
            }
            let message: Vec<u8> = self.came.drain(..2 + length).skip(2).collect();
            let mut plain = vec![0; message.len()];
            match (&mut self.handshake, &mut self.transport) {
                (Some(handshake), _) => {
                    handshake.read_message(&message, &mut plain).unwrap();
                    self.finish();
                }
                (None, Some(transport)) => {
                    let count = transport.read_message(&message, &mut plain).unwrap();
                    contents.extend_from_slice(&plain[..count]);
                }
                (None, None) => unreachable!("a peer is in one of two stages"),
            }
        }
        contents
    }

    fn seal(&mut self, content: &[u8]) -> Vec<u8> {
        let mut message = vec![0; content.len() + 16];
        let count = self.transport.as_mut().unwrap().write_message(content, &mut message).unwrap();
        frame(&message[..count])
    }
}

fn frame(message: &[u8]) -> Vec<u8> {
    [&u16::try_from(message.len()).unwrap().to_be_bytes()[..], message].concat()
}

fn feed(channel: &mut Channel<Vec<u8>>, keyring: &Keyring<'_>, bytes: &[u8]) {
    channel.space()[..bytes.len()].copy_from_slice(bytes);
    channel.filled(bytes.len(), keyring).unwrap();
}

fn drain(channel: &mut Channel<Vec<u8>>) -> Vec<u8> {
    let bytes = channel.pending().to_vec();
    channel.sent(bytes.len());
    channel.take_sent();
    bytes
}

fn converse(own: Role) {
    let members = [Member { federate: 3, key: secret(FEDERATE).public() }];
    let (mine, theirs) = match own {
        Role::Initiator => (FEDERATE, RTI),
        Role::Responder => (RTI, FEDERATE),
    };
    let keyring = Keyring::new(secret(mine), FederationSecret::new(FEDERATION), secret(RTI).public(), &members);
    let mut channel = Channel::new(vec![0; 4096], vec![0; 4096]);
    let other = if own == Role::Initiator { Role::Responder } else { Role::Initiator };
    let mut peer = Peer::new(other, theirs);
    channel.begin(own, &keyring, EPHEMERAL, 9, 0);
    if own == Role::Initiator {
        peer.receive(&drain(&mut channel));
        feed(&mut channel, &keyring, &peer.step());
        peer.receive(&drain(&mut channel));
        assert_eq!(channel.peer(), Some(Participant::Rti));
    } else {
        feed(&mut channel, &keyring, &peer.step());
        peer.receive(&drain(&mut channel));
        feed(&mut channel, &keyring, &peer.step());
        assert_eq!(channel.peer(), Some(Participant::Federate(3)));
    }
    assert_eq!(channel.stage(), ChannelStage::Open);
    for number in 0..REKEY_RECORDS + 3 {
        if number > 0 && number % REKEY_RECORDS == 0 {
            peer.transport.as_mut().unwrap().rekey_incoming();
            peer.transport.as_mut().unwrap().rekey_outgoing();
        }
        let content = number.to_le_bytes();
        assert!(channel.seal(&content));
        assert_eq!(peer.receive(&drain(&mut channel)), content);
        feed(&mut channel, &keyring, &peer.seal(&content));
        let mut taken = [0; 16];
        assert_eq!(channel.take(&mut taken), Ok(content.len()));
        assert_eq!(taken[..content.len()], content);
    }
    // A record is as long as the other end takes it.
    let long = [1; 3000];
    assert!(channel.seal(&long));
    assert_eq!(peer.receive(&drain(&mut channel)).len(), usize::from(CONTENT_MAX));
}

#[test]
fn a_channel_connects_to_another_implementation_and_changes_keys_with_it() {
    converse(Role::Initiator);
}

#[test]
fn another_implementation_connects_to_a_channel_and_changes_keys_with_it() {
    converse(Role::Responder);
}
