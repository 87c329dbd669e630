// SPDX-License-Identifier: Apache-2.0
//! Federations in a network namespace of their own, in which all that goes over the network is recorded: encrypted, no
//! kind of connection shows a payload, the federation id, a tag or another time; plain, all of them do.
//!
//! A test runs itself once more in the namespace, which ends with it.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, UdpSocket};
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::SystemTime;
use std::{env, fs};

use lf_federations::{Finished, Lfz, Run};
use rustix::net::{AddressFamily, Protocol, SocketFlags, SocketType, socket_with};

use super::security::Encrypted;

/// The federation id of all of them, which no observer may see.
pub(crate) const ID: &str = "an id in confidence";
/// The variable that names the folder of a federation to the test in the namespace.
const FOLDER: &str = "LF_TEST_FEDERATION";
/// Protocols of Linux and of IP.
const ALL_PACKETS: u16 = 3;
const TCP: u8 = 6;
const UDP: u8 = 17;
/// The program of all these federations.
const PROGRAM: &str = "Confidential.lf";
/// One test after the other builds it, and hands out its keys.
static BUILDS: Mutex<()> = Mutex::new(());
/// The datagram that ends a recording.
const END: &[u8] = b"the recording ends here";

/// A federation of a source and a sink: programs, and keys if it is encrypted.
pub(crate) struct Prepared {
    folder: PathBuf,
}

impl Prepared {
    /// Runs `act` on a federation in a namespace. The test with this name calls this, and nothing else: once to build
    /// the program with this property and to start itself again, and there to act.
    pub(crate) fn in_namespace(test: &str, property: &str, act: impl FnOnce(&Self)) {
        if let Some(folder) = env::var_os(FOLDER) {
            return act(&Self { folder: folder.into() });
        }
        let builds = BUILDS.lock();
        let encrypted = build(property);
        let folder = encrypted.folder.path().join("federation");
        fs::create_dir(&folder).expect("it can be made");
        let programs = ["source", "sink"].map(|federate| (federate, encrypted.program(federate)));
        for (name, program) in programs.into_iter().chain([("lfz", Lfz::path().to_owned())]) {
            fs::copy(program, folder.join(name)).expect("it can be copied");
        }
        if is_encrypted(property) {
            let keys = folder.join("keys");
            let mut copy = Command::new("cp");
            copy.arg("-a").arg(encrypted.out.join("keys")).arg(keys);
            Run::start(copy).succeed();
        }
        drop(builds);
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--net", "sh", "-c", "ip link set lo up && exec \"$0\" \"$@\""]);
        command.arg(env::current_exe().expect("it runs")).args(["--exact", test, "--nocapture"]).env(FOLDER, &folder);
        let finished = Run::start(command).succeed();
        finished.line(&["test result: ok. 1 passed"]);
    }

    fn keys_of(&self, name: &str) -> Vec<String> {
        let keys = self.folder.join("keys").join(name);
        if keys.exists() { vec!["--keys".to_owned(), keys.to_str().expect("it is a text").to_owned()] } else { vec![] }
    }

    /// Starts the RTI; returns it and its port.
    pub(crate) fn rti(&self) -> (Run, u16) {
        let mut command = Command::new(self.folder.join("lfz"));
        command.args(["rti", "--port", "0", "-n", "2", "-i", ID, "-c", "on", "period", "5000000"]);
        command.args(self.keys_of("rti"));
        let mut rti = Run::start(command);
        let line = rti.wait_for("listening on TCP port");
        let port = line.rsplit(' ').next().and_then(|word| word.parse().ok()).expect("the line ends with the port");
        (rti, port)
    }

    /// Starts a federate.
    pub(crate) fn federate(&self, name: &str, port: u16) -> Run {
        let mut command = Command::new(self.folder.join(name));
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", ID]).args(self.keys_of(name));
        Run::start(command)
    }
}

fn is_encrypted(property: &str) -> bool {
    property.contains("security") || property.contains("TLS")
}

/// Builds the program with this property.
pub(crate) fn build(property: &str) -> Encrypted {
    let out = format!("confidential-{}", property.replace([' ', ':', ','], ""));
    let encrypted = Encrypted::of(&out, PROGRAM, property);
    if is_encrypted(property) {
        encrypted.lfz(&["keys", "new"], &[]);
    }
    encrypted.build();
    encrypted
}

/// All that went over the network.
#[derive(Default)]
pub(crate) struct Recording {
    /// The pieces of each direction of each TCP connection, by the ports of its sender and receiver, and the sequence
    /// number.
    streams: BTreeMap<(u16, u16), BTreeMap<u32, Vec<u8>>>,
    /// The datagrams, with the ports of their senders and receivers.
    pub(crate) datagrams: Vec<(u16, u16, Vec<u8>)>,
    has_ended: bool,
}

impl Recording {
    /// Returns the bytes of all directions of TCP connections whose ports are such.
    fn streams(&self, are_such: impl Fn(u16, u16) -> bool) -> Vec<Vec<u8>> {
        let such = self.streams.iter().filter(|((from, to), _)| are_such(*from, *to));
        such.map(|(_, pieces)| pieces.values().flatten().copied().collect()).collect()
    }

    /// Returns what each connection to this port has sent there.
    pub(crate) fn sent_to(&self, port: u16) -> Vec<Vec<u8>> {
        self.streams(|_, to| to == port)
    }

    /// Adds a packet of IPv4; those of nothing else are sent here.
    fn add(&mut self, packet: &[u8]) -> Option<()> {
        let number = |bytes: &[u8], place: usize| {
            Some(u16::from_be_bytes(*bytes.get(place..)?.first_chunk().expect("the headers are complete")))
        };
        let length = usize::from(number(packet, 2)?);
        let content = packet.get(usize::from(packet.first()? & 15) * 4..length)?;
        let ports = (number(content, 0)?, number(content, 2)?);
        match *packet.get(9)? {
            TCP => {
                let sequence = u32::from_be_bytes(*content.get(4..)?.first_chunk()?);
                let piece = content.get(usize::from(content.get(12)? >> 4) * 4..)?;
                if !piece.is_empty() {
                    self.streams.entry(ports).or_default().insert(sequence, piece.to_vec());
                }
            }
            UDP if content.get(8..)? == END => self.has_ended = true,
            UDP => self.datagrams.push((ports.0, ports.1, content.get(8..)?.to_vec())),
            _ => {}
        }
        Some(())
    }
}

/// A recording while others run.
pub(crate) struct Recorder {
    pub(crate) recording: Arc<Mutex<Recording>>,
    thread: JoinHandle<()>,
}

impl Recorder {
    /// Begins to record everything in this namespace.
    pub(crate) fn begin() -> Self {
        let all = NonZeroU32::new(ALL_PACKETS.to_be().into()).map(Protocol::from_raw);
        let socket = socket_with(AddressFamily::PACKET, SocketType::DGRAM, SocketFlags::CLOEXEC, all);
        // Only its functions that read are used, which are those of any socket.
        let socket = UdpSocket::from(socket.expect("this process is privileged in its namespace"));
        let recording = Arc::new(Mutex::new(Recording::default()));
        let shared = Arc::clone(&recording);
        let thread = thread::spawn(move || {
            let mut packet = vec![0; 1 << 16];
            while !shared.lock().unwrap().has_ended {
                let count = socket.recv(&mut packet).expect("packets can be read");
                let _ = shared.lock().unwrap().add(&packet[..count]);
            }
        });
        Self { recording, thread }
    }

    /// Ends the recording once all has been read that was sent before.
    pub(crate) fn end(self) -> Recording {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("there is a port");
        // The recorder may have had no memory for one of them.
        while !self.thread.is_finished() {
            socket.send_to(END, (Ipv4Addr::LOCALHOST, 9)).expect("it can be sent");
            thread::yield_now();
        }
        self.thread.join().expect("it does not panic");
        std::mem::take(&mut self.recording.lock().unwrap())
    }
}

/// The parts of the protocol that an observer recognizes.
struct Observer {
    /// The time of the run, in nanoseconds.
    times: std::ops::RangeInclusive<i64>,
}

impl Observer {
    fn sees(bytes: &[u8], text: &str) -> bool {
        bytes.windows(text.len()).any(|window| window == text.as_bytes())
    }

    /// Returns whether there is a time of the run in these bytes, such as that of a tag.
    fn sees_time(&self, bytes: &[u8]) -> bool {
        let numbers = bytes.windows(8).filter_map(|window| Some(i64::from_le_bytes(window.try_into().ok()?)));
        numbers.into_iter().any(|number| self.times.contains(&number))
    }
}

/// The values of the program.
const SECRETS: [&str; 2] = ["a logical secret", "physical secret!"];

/// Runs a federation in its namespace; returns what an observer has to see of it, by kind of connection: with the RTI,
/// between federates, datagrams.
fn observe(prepared: &Prepared) -> (Observer, [Vec<Vec<u8>>; 3]) {
    let nanoseconds = || {
        let time = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).expect("it is later");
        i64::try_from(time.as_nanos()).expect("it is not so late")
    };
    let before = nanoseconds();
    let recorder = Recorder::begin();
    let (rti, port) = prepared.rti();
    let federates = ["source", "sink"].map(|name| prepared.federate(name, port));
    let [_, sink]: [Finished; 2] = federates.map(Run::succeed);
    sink.line(&["came: true true"]);
    rti.succeed();
    let recording = recorder.end();
    // Tags are after the start, which is in the future until all have joined.
    let observer = Observer { times: before..=nanoseconds() + 1_000_000_000 };
    let datagrams = recording.datagrams.iter().map(|(.., bytes)| bytes.clone()).collect();
    let with_rti = recording.streams(|from, to| from == port || to == port);
    let direct = recording.streams(|from, to| from != port && to != port);
    // Both directions of two connections, and of one.
    assert_eq!((with_rti.len(), direct.len()), (4, 2));
    (observer, [with_rti, direct, datagrams])
}

/// Asserts that an observer of the federation sees nothing on its first `count` kinds of connections.
fn assert_unreadable(prepared: &Prepared, count: usize) {
    let (observer, kinds) = observe(prepared);
    for kind in &kinds[..count] {
        assert!(kind.iter().map(Vec::len).sum::<usize>() > 300, "{kind:?}");
        for bytes in kind {
            assert!(!SECRETS.iter().chain(&[ID]).any(|text| Observer::sees(bytes, text)), "{bytes:?}");
            assert!(!observer.sees_time(bytes), "{bytes:?}");
        }
    }
}

fn assert_all_unreadable(prepared: &Prepared) {
    assert_unreadable(prepared, 3);
}

/// TLS leaves the datagrams of the clocks open, as the warning W012 says.
fn assert_streams_unreadable(prepared: &Prepared) {
    assert_unreadable(prepared, 2);
}

/// Payloads go by way of the RTI, physical ones past it.
#[test]
fn nothing_of_an_encrypted_centralized_federation_is_readable() {
    let test = "recording::nothing_of_an_encrypted_centralized_federation_is_readable";
    Prepared::in_namespace(test, "security: noise", assert_all_unreadable);
}

/// All payloads go directly.
#[test]
fn nothing_of_an_encrypted_decentralized_federation_is_readable() {
    let test = "recording::nothing_of_an_encrypted_decentralized_federation_is_readable";
    let property = "security: noise, coordination: decentralized";
    Prepared::in_namespace(test, property, assert_all_unreadable);
}

/// LF's kind of encryption, on both kinds of streams.
#[test]
fn no_stream_of_a_centralized_federation_with_tls_is_readable() {
    let test = "recording::no_stream_of_a_centralized_federation_with_tls_is_readable";
    Prepared::in_namespace(test, "comm-type: TLS", assert_streams_unreadable);
}

/// All payloads go directly.
#[test]
fn no_stream_of_a_decentralized_federation_with_tls_is_readable() {
    let test = "recording::no_stream_of_a_decentralized_federation_with_tls_is_readable";
    Prepared::in_namespace(test, "comm-type: TLS, coordination: decentralized", assert_streams_unreadable);
}

/// The observer is no blind one: in a plain federation he sees everything, on each kind of connection.
#[test]
fn all_of_a_plain_federation_is_readable() {
    let test = "recording::all_of_a_plain_federation_is_readable";
    Prepared::in_namespace(test, "coordination: decentralized", |prepared: &Prepared| {
        let (observer, [with_rti, direct, datagrams]) = observe(prepared);
        assert!(with_rti.iter().any(|bytes| Observer::sees(bytes, ID)));
        assert!(direct.iter().any(|bytes| Observer::sees(bytes, ID)));
        for secret in SECRETS {
            assert!(direct.iter().any(|bytes| Observer::sees(bytes, secret)), "{secret}");
        }
        for kind in [with_rti, direct, datagrams] {
            assert!(kind.iter().any(|bytes| observer.sees_time(bytes)));
        }
    });
}
