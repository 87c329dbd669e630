// SPDX-License-Identifier: Apache-2.0
//! Encrypted federations of real processes, and a man in the middle of their connections, over TCP.
//!
//! He changes bytes here, and repeats connections. Connections with the RTI and those between federates are the same
//! `Channel` below the same `SecurePlatform`, so what `rust/secure/tests/channels.rs` proves of records that are
//! repeated, exchanged, left out, cut, or from another session holds for both.

use std::fs;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use std::thread;

use lf_federations::{Lfz, Run, TIME_OUT, programs};
use lf_linux::keys::{federation_text, public_text, secret_text};
use lf_secure::{Channel, ChannelStage, FederationSecret, Keyring, Member, Participant, PublicKey, Role, StaticSecret};
use lf_wire::{Message, RejectCode};
use rustix::process::Signal;

/// The federation id, which no observer may see.
const ID: &str = "an id in confidence";
const FEDERATION: [u8; 32] = [0x5A; 32];
/// The seed of the RTI's key; those of federates are their ids and one more.
const RTI: u8 = 200;

fn secret(seed: u8) -> StaticSecret {
    StaticSecret::new([seed; 32])
}

fn public(seed: u8) -> PublicKey {
    secret(seed).public()
}

/// The public keys of both federates.
static MEMBERS: LazyLock<[Member; 2]> =
    LazyLock::new(|| [(0, 1), (1, 2)].map(|(federate, seed)| Member { federate, key: public(seed) }));

/// Writes a folder with the secret key of this seed and the public ones of all others.
fn write_keys(folder: &Path, own: u8) {
    let write = |name: &str, text: String, mode: u32| {
        let file = folder.join(name);
        fs::write(&file, text).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
    };
    write("own.key", secret_text(secret(own).bytes()), 0o600);
    write("federation.secret", federation_text(&FEDERATION), 0o600);
    write("rti.pub", public_text(public(RTI).bytes()), 0o644);
    for member in &*MEMBERS {
        write(&format!("{}.pub", member.federate), public_text(member.key.bytes()), 0o644);
    }
}

/// Starts an RTI with keys, which never has all of its federates; returns it and its port.
fn start_rti(folder: &Path) -> (Run, u16) {
    write_keys(folder, RTI);
    Lfz::rti(&["-n", "2", "-i", ID, "-c", "on", "--keys", folder.to_str().unwrap()])
}

/// The directions of a connection: to its acceptor, and from there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Way {
    There,
    Back,
}

/// A connection on which a byte may be changed.
struct Wire {
    stream: TcpStream,
    /// The direction and place of the byte that is changed.
    change: Option<(Way, usize)>,
    /// All bytes of each direction, as they were on the network.
    seen: [Vec<u8>; 2],
}

impl Wire {
    fn new(port: u16, change: Option<(Way, usize)>) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(TIME_OUT)).unwrap();
        stream.set_nodelay(true).unwrap();
        Self { stream, change, seen: Default::default() }
    }

    /// Passes these bytes on, in this direction. A changed length must not let the reader wait: then nothing follows.
    fn pass(&mut self, way: Way, bytes: &mut [u8]) {
        let seen = &mut self.seen[way as usize];
        let changed =
            self.change.filter(|(changed, _)| *changed == way).and_then(|(_, place)| place.checked_sub(seen.len()));
        seen.extend_from_slice(bytes);
        let byte = changed.and_then(|place| bytes.get_mut(place));
        let is_last = byte.is_some();
        if let Some(byte) = byte {
            *byte ^= 0x10;
        }
        if way == Way::There {
            // The other end may have refused it already.
            let _ = self.stream.write_all(bytes);
        }
        if is_last {
            let _ = self.stream.shutdown(Shutdown::Write);
        }
    }
}

/// A federate that only introduces itself.
struct Client {
    wire: Wire,
    channel: Channel<Vec<u8>>,
    keyring: Keyring<'static>,
}

impl Client {
    /// Connects with the RTI.
    fn new(port: u16, own: u8, change: Option<(Way, usize)>) -> Self {
        Self::to(Participant::Rti, port, own, change)
    }

    /// Connects with a participant, by its port.
    fn to(participant: Participant, port: u16, own: u8, change: Option<(Way, usize)>) -> Self {
        let keyring = Keyring::new(secret(own), FederationSecret::new(FEDERATION), public(RTI), &*MEMBERS);
        let mut channel = Channel::new(vec![0; 4096], vec![0; 4096]);
        let mut ephemeral = [0; 32];
        fs::File::open("/dev/urandom").unwrap().read_exact(&mut ephemeral).unwrap();
        channel.begin(Role::Initiator, &keyring, ephemeral, 0, 0);
        channel.expect(participant);
        Self { wire: Wire::new(port, change), channel, keyring }
    }

    fn send(&mut self) {
        let mut bytes = self.channel.pending().to_vec();
        self.channel.sent(bytes.len());
        self.channel.take_sent();
        self.wire.pass(Way::There, &mut bytes);
    }

    /// Reads until there is content or the connection is over; returns it.
    fn receive(&mut self) -> Vec<u8> {
        loop {
            let mut content = [0; 64];
            match self.channel.take(&mut content) {
                Ok(0) => {}
                Ok(count) => return content[..count].to_vec(),
                Err(_) => return Vec::new(),
            }
            if !self.read() {
                return Vec::new();
            }
        }
    }

    /// Reads once. Returns `false` when nothing more comes.
    fn read(&mut self) -> bool {
        let mut bytes = [0; 512];
        let Ok(count @ 1..) = self.wire.stream.read(&mut bytes) else { return false };
        self.wire.pass(Way::Back, &mut bytes[..count]);
        self.channel.space()[..count].copy_from_slice(&bytes[..count]);
        self.channel.filled(count, &self.keyring).is_ok()
    }

    /// Does its part of the handshake. Returns whether the other end is the one that it wants.
    fn shake_hands(&mut self) -> bool {
        self.send();
        while self.channel.stage() == ChannelStage::Handshake {
            if !self.read() {
                return false;
            }
        }
        self.send();
        self.channel.stage() == ChannelStage::Open
    }

    /// Introduces itself to the RTI as this federate, and returns the answer, if one came that is authentic.
    fn introduce(&mut self, federate: u16) -> Vec<u8> {
        self.ask(&Message::FedIds { federate, federation_id: ID.as_bytes() })
    }

    /// Says this first, and returns the answer, if one came that is authentic.
    fn ask(&mut self, message: &Message<'_>) -> Vec<u8> {
        if !self.shake_hands() {
            return Vec::new();
        }
        let mut ids = [0; 64];
        let count = message.encode(&mut ids).unwrap();
        assert!(self.channel.seal(&ids[..count]));
        self.send();
        self.receive()
    }
}

/// Returns what the RTI has answered when nobody changed anything, and the wire.
fn honest(port: u16) -> (Vec<u8>, Wire) {
    let mut client = Client::new(port, 1, None);
    let answer = client.introduce(0);
    (answer, client.wire)
}

/// Each byte of a connection with the RTI is changed once, in both directions, over TCP: then no answer comes that
/// counts. Afterwards the true federate still gets one.
#[test]
fn a_man_in_the_middle_is_noticed_at_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    let (rti, port) = start_rti(folder.path());
    let mut ack = [0; 1];
    Message::Ack.encode(&mut ack).unwrap();
    let (answer, wire) = honest(port);
    assert_eq!(answer, ack);
    for way in [Way::There, Way::Back] {
        for place in 0..wire.seen[way as usize].len() {
            let answer = Client::new(port, 1, Some((way, place))).introduce(0);
            assert!(answer.is_empty(), "byte {place} {way:?}");
        }
    }
    rti.signal(Signal::TERM);
    rti.finish().line(&["not secure", "not readable"]);
}

/// Returns the port on which a process listens.
fn listening_port(process: u32) -> u16 {
    loop {
        let sockets = fs::read_dir(format!("/proc/{process}/fd")).unwrap().flatten();
        let sockets: Vec<_> = sockets.filter_map(|file| fs::read_link(file.path()).ok()).collect();
        let tables = ["tcp", "tcp6"].map(|name| fs::read_to_string(format!("/proc/{process}/net/{name}")).unwrap());
        let port = tables.concat().lines().find_map(|line| {
            let fields: Vec<_> = line.split_whitespace().collect();
            let is_its = sockets.iter().any(|socket| socket == Path::new(&format!("socket:[{}]", fields[9])));
            let port = u16::from_str_radix(fields[1].rsplit(':').next()?, 16).ok()?;
            (fields[3] == "0A" && is_its).then_some(port)
        });
        match port {
            Some(port) => return port,
            None => thread::yield_now(),
        }
    }
}

/// Each byte of a direct connection between federates is changed once, from the federate that connects and, in the
/// handshake, from the one that accepts; a connection is repeated; and thieves of the RTI's key and a stranger
/// introduce themselves as a federate. None of them gets an answer that counts, and then the true one does.
#[test]
fn a_man_in_the_middle_of_a_direct_connection_is_noticed_at_every_byte() {
    let program = super::recording::build("security: noise").program("sink");
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let (mut rti, port) = start_rti(folders[0].path());
    write_keys(folders[1].path(), 2);
    let mut command = Command::new(program);
    command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", ID, "--keys"]).arg(folders[1].path());
    let sink = Run::start(command);
    rti.wait_for("federate 1 has joined");
    let port = listening_port(sink.id());

    let introduction = Message::P2pSendingFedId { federate: 0, is_transient: None, federation_id: ID.as_bytes() };
    let client = |own, change| Client::to(Participant::Federate(1), port, own, change);
    let mut only_hands = client(1, None);
    assert!(only_hands.shake_hands());
    let [there, back] = only_hands.wire.seen;
    for place in 0..back.len() {
        assert!(client(1, Some((Way::Back, place))).ask(&introduction).is_empty(), "byte {place}");
    }
    // An answer to the first message, and perhaps a refusal of the last one.
    let mut again = TcpStream::connect(("127.0.0.1", port)).unwrap();
    again.write_all(&there).unwrap();
    let mut answer = Vec::new();
    again.read_to_end(&mut answer).unwrap();
    assert!((back.len()..=back.len() + 3).contains(&answer.len()), "{answer:?}");

    assert_eq!(client(RTI, None).ask(&introduction), [0, RejectCode::Insecure.byte()]);
    assert!(client(77, None).ask(&introduction).is_empty());

    let mut ack = [0; 1];
    Message::Ack.encode(&mut ack).unwrap();
    for place in 0.. {
        let mut client = client(1, Some((Way::There, place)));
        let answer = client.ask(&introduction);
        if place >= client.wire.seen[Way::There as usize].len() {
            assert_eq!(answer, ack);
            break;
        }
        assert!(answer.is_empty(), "byte {place}");
    }
    for run in [sink, rti] {
        run.signal(Signal::TERM);
        run.finish();
    }
}

/// The recording of a connection has no id and no key in it, and is of no use when it is played again.
#[test]
fn a_recorded_connection_is_neither_readable_nor_of_use() {
    let folder = tempfile::tempdir().unwrap();
    let (mut rti, port) = start_rti(folder.path());
    let (_, wire) = honest(port);
    let mut ids = [0; 64];
    let count = Message::FedIds { federate: 0, federation_id: ID.as_bytes() }.encode(&mut ids).unwrap();
    for seen in &wire.seen {
        for part in [&ids[..count.min(8)], &ID.as_bytes()[..6], &public(1).bytes()[..8], &public(RTI).bytes()[..8]] {
            assert!(!seen.windows(part.len()).any(|window| window == part));
        }
    }
    let mut again = TcpStream::connect(("127.0.0.1", port)).unwrap();
    again.write_all(&wire.seen[0]).unwrap();
    rti.wait_for("not readable");
    rti.signal(Signal::TERM);
    rti.finish();
}

/// The keys of federate 1 make nobody federate 0; a plain connection and a key of nobody are refused, each in words.
#[test]
fn who_is_not_the_federate_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let (mut rti, port) = start_rti(folder.path());
    let insecure = [0, RejectCode::Insecure.byte()];
    assert_eq!(Client::new(port, 2, None).introduce(0), insecure);
    rti.wait_for("claimed to be federate 0, which it is not");
    assert!(Client::new(port, 77, None).introduce(0).is_empty());
    rti.wait_for(&format!("the public key {}, which is not among those", public(77)));
    let mut plain = TcpStream::connect(("127.0.0.1", port)).unwrap();
    plain.write_all(&[1, 0, 0, 1, b'x']).unwrap();
    let mut answer = Vec::new();
    plain.read_to_end(&mut answer).unwrap();
    assert_eq!(answer, insecure);
    rti.signal(Signal::TERM);
    rti.finish();
}

/// A federation with every kind of connection does the same as without encryption; its keys are made for the run.
#[test]
fn an_encrypted_federation_runs() {
    let finished = Lfz::run("encrypted", &programs().join("Encrypted.lf"), &[]).succeed();
    // 36 values at 0, 20, … 700 ms.
    assert_eq!(finished.of("sink").find(|line| line.contains("sum")), Some("the sum is 666, and directly came true"));
    for federate in ["source", "sink"] {
        assert!(finished.of(federate).any(|line| line.contains("clock synchronization:")), "{finished}");
    }
    assert!(!finished.lines.iter().any(|line| line.contains("not secure") || line.contains("not authentic")));
}
