// SPDX-License-Identifier: Apache-2.0
//! Attacks on all ports of a running federation, by a program that reads everything and may forge every address, but
//! has no key: strangers that say each message of the protocol, forged and repeated datagrams of clock synchronization,
//! recorded connections played again, and connections that are held without a word. An encrypted federation does what
//! it does without them.
//!
//! A man in the middle who changes the bytes of a connection is in `encrypted.rs`, and in `rust/secure/tests` for all
//! connections, which are alike.

use std::collections::VecDeque;
use std::fs;
use std::io::Write;
use std::net::{Ipv4Addr, TcpStream, UdpSocket};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, SystemTime};

use lf_testkit::messages::encoded;
use lf_wire::{DELAY_NONE, Message, NeighborStructure, RejectCode, Tag};
use rustix::net::{AddressFamily, SocketFlags, SocketType, ipproto, socket_with};

use super::recording::{ID, Prepared, Recorder, Recording};

/// The time between two attacks on a port.
const PAUSE: Duration = Duration::from_millis(2);
/// The number of connections to a port that are held open: more than there are slots for strangers.
const HELD: usize = 8;
/// The times by which forged clocks are off, in nanoseconds: an hour, and little enough to be believed.
const LIES: [i64; 4] = [3_600_000_000_000, -10_000_000_000, 5_000_000, 900_000];
/// The number of recorded datagrams that are sent again at once.
const REPEATED: usize = 16;

/// An attack, which goes on until nobody can send an end any more.
type Attack = fn(&Mutex<Recording>, &Receiver<()>);

/// Returns the ports in the tables of Linux for the namespace of this process, in this state: of TCP those that listen.
fn ports(protocol: &str, state: &str) -> Vec<u16> {
    let tables = ["", "6"].map(|family| fs::read_to_string(format!("/proc/self/net/{protocol}{family}")));
    tables.into_iter().flatten().flat_map(|text| ports_in(&text, state)).collect()
}

fn ports_in(text: &str, state: &str) -> Vec<u16> {
    let fields = text.lines().skip(1).map(|line| line.split_whitespace().collect::<Vec<_>>());
    let such = fields.filter(|fields| fields[3] == state);
    such.filter_map(|fields| u16::from_str_radix(fields[1].rsplit(':').next()?, 16).ok()).collect()
}

/// Returns the messages of a stranger: those that introduce a federate, and those that harm a plain federation.
fn forged() -> Vec<Vec<u8>> {
    let (federation_id, tag) = (ID.as_bytes(), Tag::new(0, 0));
    let introductions = [
        Message::FedIds { federate: 0, federation_id },
        Message::FedIds { federate: 1, federation_id },
        Message::P2pSendingFedId { federate: 0, is_transient: Some(false), federation_id },
    ];
    let harm = [
        Message::Failed,
        Message::Resign,
        Message::StopRequest(tag),
        Message::StopGranted(tag),
        Message::NextEventTag(Tag::FOREVER),
        Message::LatestTagComplete(Tag::FOREVER),
        Message::TagGrant(Tag::FOREVER),
        Message::ProvisionalTagGrant(Tag::FOREVER),
        Message::TaggedMessage { port: 0, federate: 1, tag: Tag::FOREVER, payload: &[0xFF; 4] },
        Message::P2pMessage { port: 0, federate: 1, payload: &[0xFF; 4] },
        Message::PortAbsent { port: 0, federate: 1, tag: Tag::FOREVER },
        Message::Timestamp(i64::MIN),
        Message::AddressAdvertisement { port: 9 },
        Message::NeighborStructure(NeighborStructure::new(&[(1, DELAY_NONE)], &[1])),
        Message::Reject(RejectCode::FederationIdMismatch),
        Message::Ack,
    ];
    let behind = |first: Option<&Message<'_>>| {
        let first = first.map(encoded).unwrap_or_default();
        harm.iter().map(|message| [&first[..], &encoded(message)].concat()).collect::<Vec<_>>()
    };
    let mut all = behind(None);
    all.extend(introductions.iter().flat_map(|message| behind(Some(message))));
    // Handshakes: none at all, the beginning of one, and one without the federation's secret.
    all.extend([vec![], vec![0xE5, 1, 0], [&[0xE5, 1, 0, 48][..], &[0x5A; 48]].concat(), vec![0xE5, 1, 0, 0, 1]]);
    all
}

/// Connects to all ports again and again until it is told to end.
fn attack_connections(recording: &Mutex<Recording>, end: &Receiver<()>) {
    let forged = forged();
    let mut held = VecDeque::new();
    for turn in 0.. {
        if end.recv_timeout(PAUSE) != Err(RecvTimeoutError::Timeout) {
            return;
        }
        for port in ports("tcp", "0A") {
            let recorded = recording.lock().unwrap().sent_to(port);
            let all: Vec<_> = forged.iter().chain(&recorded).collect();
            let Ok(mut stream) = TcpStream::connect((Ipv4Addr::LOCALHOST, port)) else { continue };
            let _ = stream.write_all(all[turn % all.len()]);
            held.push_back(stream);
        }
        while held.len() > HELD {
            held.pop_front();
        }
    }
}

/// Sends datagrams from each port to each other one, until it is told to end: it forges addresses, too.
fn attack_clocks(recording: &Mutex<Recording>, end: &Receiver<()>) {
    let raw = socket_with(AddressFamily::INET, SocketType::RAW, SocketFlags::CLOEXEC, Some(ipproto::UDP));
    let raw = UdpSocket::from(raw.expect("this process is privileged in its namespace"));
    let send = |from: u16, to: u16, content: &[u8]| {
        let length = u16::try_from(content.len() + 8).expect("datagrams are short");
        // Without a checksum, which is allowed.
        let header = [from, to, length, 0].map(u16::to_be_bytes).concat();
        let _ = raw.send_to(&[&header[..], content].concat(), (Ipv4Addr::LOCALHOST, 0));
    };
    while end.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).expect("it is later").as_nanos();
        let now = i64::try_from(now).expect("it is not so late");
        let ports = ports("udp", "07");
        for (from, to) in ports.iter().flat_map(|from| ports.iter().map(move |to| (*from, *to))) {
            for lie in LIES {
                let time = now + lie;
                for message in [Message::T1(time), Message::T4(time), Message::CodedProbe(time)] {
                    send(from, to, &encoded(&message));
                }
            }
            for federate in [0, 1] {
                send(from, to, &encoded(&Message::T3 { federate }));
            }
        }
        let repeated: Vec<_> = recording.lock().unwrap().datagrams.iter().rev().take(REPEATED).cloned().collect();
        for (from, to, content) in repeated {
            send(from, to, &content);
        }
    }
}

/// Attacks the ports of a federation in this way from before its RTI listens until all have ended; returns what the
/// RTI, the source and the sink have printed.
fn run(prepared: &Prepared, attacks: &[Attack]) -> [String; 3] {
    let recorder = Recorder::begin();
    let attackers = attacks.iter().map(|attack| {
        let (recording, (end, ended), attack) = (Arc::clone(&recorder.recording), channel(), *attack);
        (thread::spawn(move || attack(&recording, &ended)), end)
    });
    let attackers: Vec<_> = attackers.collect();
    let (rti, port) = prepared.rti();
    let [source, sink] = ["source", "sink"].map(|name| prepared.federate(name, port));
    let finished = [rti, source, sink].map(|run| run.finish().to_string());
    for (attacker, end) in attackers {
        drop(end);
        attacker.join().expect("it does not panic");
    }
    recorder.end();
    finished
}

/// Returns whether a participant's clock has heard what was forged.
fn is_misled(output: &str) -> bool {
    output.contains("another program sends it") || output.contains("another program there sends them")
}

#[test]
fn nobody_without_a_key_disturbs_an_encrypted_federation() {
    let test = "attacks::nobody_without_a_key_disturbs_an_encrypted_federation";
    Prepared::in_namespace(test, "security: noise", |prepared| {
        let [rti, source, sink] = run(prepared, &[attack_connections, attack_clocks]);
        assert!(sink.contains("came: true true"), "{rti}\n{source}\n{sink}");
        for output in [&rti, &source, &sink] {
            assert!(output.starts_with("exit status: 0"), "{output}");
            assert!(output.contains("is not authentic, or old, and ignored") && !is_misled(output), "{output}");
        }
        // The sink listens no longer than until the source has connected, so it may have heard no stranger.
        assert!(rti.contains("is not secure and not used: "), "{rti}");
    });
}

/// The attack is none that fails anyway: the clocks of a plain federation hear it.
#[test]
fn forged_times_are_heard_without_encryption() {
    let test = "attacks::forged_times_are_heard_without_encryption";
    Prepared::in_namespace(test, "coordination: decentralized", |prepared| {
        let outputs = run(prepared, &[attack_clocks]);
        assert!(outputs.iter().any(|output| is_misled(output)), "{outputs:?}");
    });
}
