// SPDX-License-Identifier: Apache-2.0
//! Encrypted connections: whatever comes from the network, no byte of it becomes content that the other end has not
//! sent, in the order in which it has sent it.

use std::sync::LazyLock;

use lf_secure::{
    Channel, ChannelStage, FederationSecret, HANDSHAKE_BYTES, Keyring, Member, Participant, Role, StaticSecret,
};

/// Only one of this many inputs is for connections after their handshake, which takes a thousand times as long as the
/// rest.
const HANDSHAKES_ONE_OF: u8 = 32;

type Bytes = Vec<u8>;

static MEMBERS: LazyLock<[Member; 1]> = LazyLock::new(|| [Member { federate: 0, key: secret(2).public() }]);
/// The keys of the federate and of the RTI.
static KEYRINGS: LazyLock<[Keyring<'static>; 2]> = LazyLock::new(|| {
    [2, 1].map(|own| Keyring::new(secret(own), FederationSecret::new([7; 32]), secret(1).public(), &*MEMBERS))
});

fn secret(seed: u8) -> StaticSecret {
    StaticSecret::new([seed; 32])
}

/// One end with its keyring.
struct End {
    channel: Channel<Bytes>,
    keyring: &'static Keyring<'static>,
}

impl End {
    fn new(role: Role) -> Self {
        let [federate, rti] = &*KEYRINGS;
        let keyring = if role == Role::Initiator { federate } else { rti };
        let mut channel = Channel::new(vec![0; HANDSHAKE_BYTES + 40], vec![0; HANDSHAKE_BYTES + 40]);
        channel.begin(role, keyring, [9; 32], 0, 0);
        Self { channel, keyring }
    }

    /// Passes it bytes of the network, and returns what it takes for content.
    fn receive(&mut self, mut bytes: &[u8]) -> Bytes {
        let mut content = Vec::new();
        while !bytes.is_empty() {
            let space = self.channel.space();
            let count = space.len().min(bytes.len());
            assert!(count > 0, "a channel without content has space");
            space[..count].copy_from_slice(&bytes[..count]);
            bytes = &bytes[count..];
            if self.channel.filled(count, self.keyring).is_err() {
                return content;
            }
            let mut buffer = [0; 5];
            while self.channel.has_content() {
                match self.channel.take(&mut buffer) {
                    Ok(count) => content.extend_from_slice(&buffer[..count]),
                    Err(_) => return content,
                }
            }
        }
        content
    }

    fn send(&mut self) -> Bytes {
        let bytes = self.channel.pending().to_vec();
        self.channel.sent(bytes.len());
        self.channel.take_sent();
        bytes
    }
}

/// Makes a connection between a federate and the RTI.
fn open() -> [End; 2] {
    let mut ends = [Role::Initiator, Role::Responder].map(End::new);
    for from in [0, 1, 0] {
        let bytes = ends[from].send();
        ends[1 - from].receive(&bytes);
    }
    assert_eq!(ends.each_ref().map(|end| end.channel.stage()), [ChannelStage::Open; 2]);
    assert_eq!(ends[1].channel.peer(), Some(Participant::Federate(0)));
    ends
}

/// Passes bytes of a stranger to an end before, in or after its handshake.
///
/// # Panics
/// If something does not hold that has to.
pub fn secure_raw(data: &[u8]) {
    let [choice, rest @ ..] = data else { return };
    let mut end = match choice % HANDSHAKES_ONE_OF {
        0 => {
            let [federate, rti] = open();
            if *choice < 128 { federate } else { rti }
        }
        _ => End::new(Role::Responder),
    };
    assert!(end.receive(rest).is_empty(), "bytes of a stranger are no content");
}

/// Lets an end send, and a man in the middle change, drop, repeat and split its records.
///
/// # Panics
/// If something does not hold that has to.
pub fn secure_structured(data: &[u8]) {
    let [choice, steps @ ..] = data else { return };
    if choice % HANDSHAKES_ONE_OF > 0 {
        return;
    }
    let [mut federate, mut rti] = open();
    let (mut sent, mut received, mut before) = (Vec::new(), Vec::new(), Vec::new());
    for step in steps.chunks_exact(3) {
        let [what, place, length] = [step[0], step[1], step[2]];
        let content = vec![place; usize::from(length % 64) + 1];
        assert!(federate.channel.seal(&content));
        let mut record = federate.send();
        sent.extend_from_slice(&content[..record.len() - lf_secure::RECORD_OVERHEAD]);
        match what % 8 {
            0 => {
                let place = usize::from(place) % record.len();
                record[place] ^= 1 << (length % 8);
            }
            1 => record.clear(),
            2 => record.truncate(usize::from(place) % record.len()),
            3 => record.splice(..0, std::mem::take(&mut before)).for_each(drop),
            _ => {}
        }
        received.extend_from_slice(&rti.receive(&record));
        before = record;
    }
    assert!(sent.starts_with(&received), "content comes whole and in order, or not at all");
}
