// SPDX-License-Identifier: Apache-2.0
//! Two channels with a network between them that does what it likes.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use std::ops::Range;

use lf_secure::{
    Channel, ChannelError, ChannelStage, DatagramKeys, FederationSecret, HANDSHAKE_BYTES, Hint, Keyring, MARK, Member,
    Participant, RECORD_OVERHEAD, Role,
};
use proptest::prelude::*;
use support::{EPHEMERAL, FEDERATE, FEDERATION, RTI, secret};

type Bytes = Vec<u8>;

/// A seed of nobody that is known.
const STRANGER: u8 = 9;

fn members() -> [Member; 2] {
    [(3, FEDERATE), (4, 4)].map(|(federate, seed)| Member { federate, key: secret(seed).public() })
}

/// Calls `with` with the keyrings of the federate and of the RTI.
fn with_keyrings<R>(federate: u8, federation: [u8; 32], with: impl FnOnce(&Keyring<'_>, &Keyring<'_>) -> R) -> R {
    let (rti, members) = (secret(RTI).public(), members());
    let federate = Keyring::new(secret(federate), FederationSecret::new(federation), rti, &[]);
    let rti = Keyring::new(secret(RTI), FederationSecret::new(FEDERATION), rti, &members);
    with(&federate, &rti)
}

/// A federate's end and the RTI's, with what each of them has received and why it has failed.
struct Pair<'k> {
    ends: [End<'k>; 2],
}

struct End<'k> {
    channel: Channel<Bytes>,
    keyring: &'k Keyring<'k>,
    /// All that it has sent to the network.
    sent: Bytes,
    received: Bytes,
    failure: Option<ChannelError>,
}

impl<'k> End<'k> {
    fn new(role: Role, keyring: &'k Keyring<'k>, ephemeral: u8, buffer_bytes: usize) -> Self {
        let mut channel = Channel::new(vec![0; buffer_bytes], vec![0; buffer_bytes]);
        channel.begin(role, keyring, [ephemeral; 32], u32::from(ephemeral), 0);
        Self { channel, keyring, sent: Vec::new(), received: Vec::new(), failure: None }
    }

    /// Handles what the network brings.
    fn receive(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() && self.failure.is_none() {
            let space = self.channel.space();
            let count = space.len().min(bytes.len());
            assert!(count > 0, "a channel whose content is taken has space");
            space[..count].copy_from_slice(&bytes[..count]);
            bytes = &bytes[count..];
            self.failure = self.channel.filled(count, self.keyring).err();
            self.take();
        }
    }

    fn take(&mut self) {
        let mut buffer = [0; 7];
        while self.channel.has_content() && self.failure.is_none() {
            match self.channel.take(&mut buffer) {
                Ok(count) => self.received.extend_from_slice(&buffer[..count]),
                Err(error) => self.failure = Some(error),
            }
        }
    }

    /// Returns what it sends now.
    fn send(&mut self) -> Bytes {
        let bytes = self.channel.pending().to_vec();
        self.channel.sent(bytes.len());
        self.channel.take_sent();
        self.sent.extend_from_slice(&bytes);
        bytes
    }

    /// Encrypts all of this content and returns it, for the network.
    fn seal(&mut self, content: &[u8]) -> Bytes {
        let (mut rest, mut bytes) = (content, Vec::new());
        while !rest.is_empty() && self.channel.seal(rest) {
            bytes.extend_from_slice(self.channel.pending());
            self.channel.sent(usize::MAX);
            rest = &rest[self.channel.take_sent()..];
        }
        self.sent.extend_from_slice(&bytes);
        bytes
    }
}

impl<'k> Pair<'k> {
    fn new(federate: &'k Keyring<'k>, rti: &'k Keyring<'k>, buffer_bytes: usize) -> Self {
        Self::with_ephemerals(federate, rti, buffer_bytes, [EPHEMERAL[0], 0x22])
    }

    fn with_ephemerals(federate: &'k Keyring<'k>, rti: &'k Keyring<'k>, buffer_bytes: usize, seeds: [u8; 2]) -> Self {
        let federate = End::new(Role::Initiator, federate, seeds[0], buffer_bytes);
        Self { ends: [federate, End::new(Role::Responder, rti, seeds[1], buffer_bytes)] }
    }

    /// Makes the handshake; `change` sees what goes from which end, and with how many bytes before.
    fn shake_hands(&mut self, mut change: impl FnMut(usize, usize, &mut Bytes)) {
        loop {
            let mut idle = true;
            for from in [0, 1] {
                let before = self.ends[from].sent.len();
                let mut bytes = self.ends[from].send();
                idle &= bytes.is_empty();
                change(from, before, &mut bytes);
                self.ends[1 - from].receive(&bytes);
            }
            if idle {
                return;
            }
        }
    }

    fn open(federate: &'k Keyring<'k>, rti: &'k Keyring<'k>) -> Self {
        let mut pair = Self::new(federate, rti, 512);
        pair.shake_hands(|_, _, _| {});
        assert_eq!(pair.stages(), [ChannelStage::Open; 2]);
        pair
    }

    fn stages(&self) -> [ChannelStage; 2] {
        [0, 1].map(|end| self.ends[end].channel.stage())
    }

    fn failures(&self) -> [Option<ChannelError>; 2] {
        [0, 1].map(|end| self.ends[end].failure)
    }
}

/// Returns the bytes of each frame, without the mark.
fn frames(bytes: &[u8]) -> Vec<Range<usize>> {
    let (mut place, mut frames) = (0, Vec::new());
    while let [a, b, ..] = bytes[place..] {
        let end = place + 2 + usize::from(u16::from_be_bytes([a, b]));
        frames.push(place..end);
        place = end;
    }
    frames
}

#[test]
fn both_ends_know_each_other_and_exchange_bytes() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut pair = Pair::open(federate, rti);
        assert_eq!(pair.ends[0].channel.peer(), Some(Participant::Rti));
        assert_eq!(pair.ends[1].channel.peer(), Some(Participant::Federate(3)));
        let bytes = pair.ends[0].seal(b"to the RTI");
        assert_eq!(bytes.len(), 10 + RECORD_OVERHEAD);
        pair.ends[1].receive(&bytes);
        assert_eq!(pair.ends[1].received, b"to the RTI");
        let bytes = pair.ends[1].seal(&[7; 1200]);
        pair.ends[0].receive(&bytes);
        assert_eq!(pair.ends[0].received, [7; 1200]);
    });
}

/// A man in the middle who changes any bit of the handshake is noticed before a byte of content comes, by the end that
/// reads the change or by the other one, whose answer does not fit.
#[test]
fn every_changed_bit_of_a_handshake_is_noticed() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut honest = Pair::new(federate, rti, HANDSHAKE_BYTES);
        honest.shake_hands(|_, _, _| {});
        for end in [0, 1] {
            for place in 0..honest.ends[end].sent.len() {
                let mut pair = Pair::new(federate, rti, HANDSHAKE_BYTES);
                pair.shake_hands(|from, before, bytes| {
                    if let Some(byte) = place.checked_sub(before).filter(|_| from == end)
                        && let Some(byte) = bytes.get_mut(byte)
                    {
                        *byte ^= 1 << (place % 8);
                    }
                });
                for from in [0, 1] {
                    let bytes = pair.ends[from].seal(b"content");
                    pair.ends[1 - from].receive(&bytes);
                }
                let received = pair.ends.iter().any(|end| !end.received.is_empty());
                // A changed length makes the receiver wait for bytes that do not come.
                let waits = pair.stages().contains(&ChannelStage::Handshake);
                let failed = pair.failures().iter().any(Option::is_some);
                assert!(!received && (failed || waits), "byte {place} of end {end}: {:?}", pair.stages());
            }
        }
    });
}

/// So is one who changes any byte of a record.
#[test]
fn every_changed_byte_of_a_record_is_noticed() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        for place in 0..20 + RECORD_OVERHEAD {
            for flip in [0x01, 0x80] {
                let mut pair = Pair::open(federate, rti);
                let mut bytes = pair.ends[0].seal(&[3; 20]);
                bytes[place] ^= flip;
                // More follows, so that a longer length is not just waited for.
                bytes.extend_from_slice(&pair.ends[0].seal(&[4; 400]));
                bytes.extend_from_slice(&pair.ends[0].seal(&[4; 400]));
                pair.ends[1].receive(&bytes);
                let waits = place < 2 && pair.ends[1].failure.is_none();
                let expected =
                    [ChannelError::Forged, ChannelError::Length(0)].map(|error| std::mem::discriminant(&error));
                let found = pair.ends[1].failure.map(|error| std::mem::discriminant(&error));
                assert!(waits || found.is_some_and(|found| expected.contains(&found)), "{place}: {found:?}");
                assert_eq!(pair.ends[1].received, [], "byte {place}");
            }
        }
    });
}

#[test]
fn a_record_that_comes_again_too_early_or_from_elsewhere_is_noticed() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let records = |pair: &mut Pair<'_>| [b"first", b"other"].map(|content| pair.ends[0].seal(content));
        // Repeated.
        let mut pair = Pair::open(federate, rti);
        let [first, _] = records(&mut pair);
        pair.ends[1].receive(&first);
        pair.ends[1].receive(&first);
        assert_eq!((&pair.ends[1].received[..], pair.ends[1].failure), (&b"first"[..], Some(ChannelError::Forged)));
        // Left out, or moved.
        let mut pair = Pair::open(federate, rti);
        let [_, other] = records(&mut pair);
        pair.ends[1].receive(&other);
        assert_eq!((&pair.ends[1].received[..], pair.ends[1].failure), (&b""[..], Some(ChannelError::Forged)));
        // Sent back.
        let mut pair = Pair::open(federate, rti);
        let [first, _] = records(&mut pair);
        pair.ends[0].receive(&first);
        assert_eq!((&pair.ends[0].received[..], pair.ends[0].failure), (&b""[..], Some(ChannelError::Forged)));
        // Of another connection of the same two.
        let mut pair = Pair::open(federate, rti);
        let mut later = Pair::with_ephemerals(federate, rti, 512, [0x33, 0x44]);
        later.shake_hands(|_, _, _| {});
        let [first, _] = records(&mut later);
        pair.ends[1].receive(&first);
        assert_eq!((&pair.ends[1].received[..], pair.ends[1].failure), (&b""[..], Some(ChannelError::Forged)));
    });
}

/// A whole recorded connection, played again to the RTI, ends with its third message: the RTI's keys are new.
#[test]
fn a_recorded_connection_cannot_be_played_again() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut pair = Pair::open(federate, rti);
        pair.ends[0].seal(b"RESIGN");
        let recorded = pair.ends[0].sent.clone();
        let mut again = End::new(Role::Responder, rti, 0x77, 512);
        again.receive(&recorded);
        assert_eq!((&again.received[..], again.failure), (&b""[..], Some(ChannelError::Handshake)));
    });
}

/// A peer without the federation's secret gets nothing but a refusal, and neither end shows its identity.
#[test]
fn another_federation_is_refused_before_any_key_is_shown() {
    with_keyrings(FEDERATE, [0; 32], |federate, rti| {
        let mut pair = Pair::new(federate, rti, 512);
        pair.shake_hands(|_, _, _| {});
        assert_eq!(pair.failures(), [Some(ChannelError::Refused(Hint::Secret)), Some(ChannelError::Handshake)]);
        assert_eq!(pair.ends[1].sent, [MARK, 1, 0, 0, 1]);
    });
}

#[test]
fn a_key_that_is_not_trusted_is_refused_and_both_ends_say_so() {
    with_keyrings(STRANGER, FEDERATION, |federate, rti| {
        let mut pair = Pair::new(federate, rti, 512);
        pair.shake_hands(|_, _, _| {});
        let unknown = ChannelError::UnknownKey(secret(STRANGER).public());
        assert_eq!(pair.failures(), [Some(ChannelError::Refused(Hint::Key)), Some(unknown)]);
    });
}

/// A federate whose key was stolen is not the RTI, and not another federate: the end that connects says whom it wants.
#[test]
fn a_stolen_key_makes_nobody_else() {
    let (rti_key, members) = (secret(RTI).public(), members());
    let federation = || FederationSecret::new(FEDERATION);
    let caller = Keyring::new(secret(4), federation(), rti_key, &members);
    let thief = Keyring::new(secret(FEDERATE), federation(), rti_key, &members);
    for expected in [Participant::Rti, Participant::Federate(4), Participant::Federate(12)] {
        let mut pair = Pair::new(&caller, &thief, 512);
        pair.ends[0].channel.expect(expected);
        pair.shake_hands(|_, _, _| {});
        let other = ChannelError::Other { expected, found: Participant::Federate(3) };
        assert_eq!(pair.failures(), [Some(other), Some(ChannelError::Refused(Hint::Key))]);
        // The caller has not shown its own key.
        assert!(!pair.ends[0].sent.windows(32).any(|window| window == caller.public().bytes()));
    }
}

#[test]
fn an_end_that_does_not_encrypt_is_refused() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut end = End::new(Role::Responder, rti, 0x22, 512);
        end.receive(&[1, 0, 0, 4]);
        assert_eq!(end.failure, Some(ChannelError::Plain(1)));
        assert_eq!(end.send(), []);
        let mut end = End::new(Role::Initiator, federate, 0x11, 512);
        end.receive(&[0, 4]);
        assert_eq!(end.failure, Some(ChannelError::Plain(0)));
        let mut end = End::new(Role::Responder, rti, 0x22, 512);
        end.receive(&[MARK, 2]);
        assert_eq!(end.failure, Some(ChannelError::Version(2)));
    });
}

/// Nothing that a connection sends has a key, a secret or content in it.
#[test]
fn nothing_on_the_network_is_readable() {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut pair = Pair::open(federate, rti);
        let content = b"a value that nobody may read";
        let bytes = pair.ends[0].seal(content);
        pair.ends[1].receive(&bytes);
        let keys = [federate, rti].map(|keyring| *keyring.public().bytes());
        for end in &pair.ends {
            for part in [&keys[0][..8], &keys[1][..8], &FEDERATION[..8], &content[..4]] {
                assert!(!end.sent.windows(part.len()).any(|window| window == part));
            }
        }
        assert_eq!(frames(&pair.ends[0].sent[2..]).len(), 3);
    });
}

/// Two ends' keys of datagrams, the federate's first.
fn datagram_keys<R>(with: impl FnOnce(&mut DatagramKeys, &mut DatagramKeys) -> R) -> R {
    with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
        let mut pair = Pair::open(federate, rti);
        let [federate, rti] = &mut pair.ends;
        with(federate.channel.datagrams().unwrap(), rti.channel.datagrams().unwrap())
    })
}

#[test]
fn a_datagram_counts_once_in_order_and_as_a_whole() {
    datagram_keys(|federate, rti| {
        let mut sealed = [[0; 64]; 3];
        let lengths = sealed.each_mut().map(|bytes| rti.seal(b"T1", bytes).unwrap());
        // It names the connection as its receiver does.
        assert_eq!(DatagramKeys::name_in(&sealed[0]), Some(u32::from(EPHEMERAL[0])));
        let mut open = |number: usize, change: Option<usize>| {
            let mut bytes = sealed[number][..lengths[number]].to_vec();
            if let Some(place) = change {
                bytes[place] ^= 1;
            }
            federate.open(&mut bytes).map(|content| content.to_vec())
        };
        for place in 0..lengths[0] {
            assert_eq!(open(0, Some(place)), None, "byte {place}");
        }
        assert_eq!(open(0, None), Some(b"T1".to_vec()));
        assert_eq!(open(0, None), None);
        assert_eq!(open(2, None), Some(b"T1".to_vec()));
        assert_eq!(open(1, None), None);
        // It is for the federate only.
        assert_eq!(rti.open(&mut { sealed[2] }[..lengths[2]]), None);
        assert_eq!(federate.open(&mut [0; 27]), None);
    });
}

proptest! {
    /// However the network cuts the bytes, and however long the buffers are, the same content comes out.
    #[test]
    fn content_arrives_whatever_the_pieces(
        contents in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..300), 1..8),
        pieces in prop::collection::vec(1_usize..200, 1..20),
        buffer_bytes in HANDSHAKE_BYTES..700,
    ) {
        with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
            let mut pair = Pair::new(federate, rti, buffer_bytes);
            pair.shake_hands(|_, _, _| {});
            let mut bytes = Vec::new();
            for content in &contents {
                bytes.extend_from_slice(&pair.ends[0].seal(content));
            }
            let (mut rest, mut pieces) = (&bytes[..], pieces.iter().cycle());
            while !rest.is_empty() {
                let (piece, behind) = rest.split_at(rest.len().min(*pieces.next().unwrap()));
                pair.ends[1].receive(piece);
                rest = behind;
            }
            assert_eq!(pair.ends[1].failure, None);
            assert_eq!(pair.ends[1].received, contents.concat());
        });
    }

    /// Whatever a stranger sends, at any stage, an end neither panics nor returns a byte of it.
    #[test]
    fn bytes_of_a_stranger_are_never_content(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        marked: bool,
        opened: bool,
    ) {
        with_keyrings(FEDERATE, FEDERATION, |federate, rti| {
            let mut pair = Pair::new(federate, rti, 512);
            if opened {
                pair.shake_hands(|_, _, _| {});
            }
            let mark: &[u8] = if marked && !opened { &[MARK, 1] } else { &[] };
            pair.ends[1].receive(&[mark, &bytes].concat());
            assert!(pair.ends[1].received.is_empty());
        });
    }
}
