// SPDX-License-Identifier: Apache-2.0
//! `lfz rti` over TCP answers as the stock RTI did in the recordings.
//!
//! The RTI reads several connections, so the test has to force the order in which it reads messages on different ones:
//! after each message of a joined federate, the tester asks for an address on the same connection and waits for the
//! answer.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream, UdpSocket};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use lf_federations::{Lfz, TIME_OUT};
use lf_testkit::golden::replay::{Received, Rti, replay};
use lf_wire::{Decoded, KIND_TRANSIENT, Limits, Message, decode, decode_to_transient};

/// No message in the recordings is longer.
const LIMITS: Limits = Limits { payload_bytes_max: 1 << 20, federation_id_bytes_max: 255, neighbors_max: 100 };
/// Type bytes of messages of a federate.
const TRANSIENT_FED_IDS: u8 = 103;
const UDP_PORT: u8 = 254;
const TIMESTAMP: u8 = 2;
const RESIGN: u8 = 4;
const FAILED: u8 = 25;

/// The number of the connection of a federate's second instance is by so much greater.
const SECOND: u16 = 100;

struct Tcp {
    port: u16,
    connections: BTreeMap<u16, Connection>,
    /// Federates that may query addresses.
    joined: BTreeSet<u16>,
    /// The UDP ports of federates, each with the sender of its last datagram.
    datagrams: BTreeMap<u16, (UdpSocket, Option<SocketAddr>)>,
}

struct Connection {
    stream: TcpStream,
    /// The received bytes that are not read yet.
    bytes: Vec<u8>,
    ended: bool,
    /// Whether the federate is transient.
    is_transient: bool,
}

impl Connection {
    /// Reads the available bytes; waits for at least one byte or the end.
    fn read(&mut self) -> io::Result<()> {
        let mut buffer = [0; 8 * 1024];
        match self.stream.read(&mut buffer) {
            Ok(0) => self.ended = true,
            Ok(length) => self.bytes.extend_from_slice(&buffer[..length]),
            Err(error) if error.kind() == io::ErrorKind::ConnectionReset => self.ended = true,
            Err(error) => return Err(error),
        }
        Ok(())
    }

    /// Takes the answer to an address query out of the received bytes; it is the last message before a further action.
    fn take_address(&mut self) -> io::Result<()> {
        let mut start = 0;
        while !self.ended {
            let rest = &self.bytes[start..];
            let decoded =
                if self.is_transient { decode_to_transient(rest, &LIMITS, |_| true) } else { decode(rest, &LIMITS) };
            match decoded {
                Ok(Decoded::Complete { message: Message::AddressQueryReply { .. }, len }) => {
                    self.bytes.drain(start..start + len);
                    return Ok(());
                }
                Ok(Decoded::Complete { len, .. }) => start += len,
                Ok(Decoded::Incomplete { .. }) => self.read()?,
                Err(error) => return Err(io::Error::other(format!("{error:?}"))),
            }
        }
        Err(io::Error::other("the connection has ended"))
    }
}

impl Rti for Tcp {
    type Error = io::Error;

    fn connect(&mut self, connection: u16) -> io::Result<()> {
        let stream = TcpStream::connect(("127.0.0.1", self.port))?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TIME_OUT))?;
        self.connections
            .insert(connection, Connection { stream, bytes: Vec::new(), ended: false, is_transient: false });
        Ok(())
    }

    fn send(&mut self, connection: u16, bytes: &[u8]) -> io::Result<()> {
        let open = self.connections.get_mut(&connection).ok_or(io::ErrorKind::NotConnected)?;
        open.stream.write_all(bytes)?;
        open.is_transient |= bytes.first() == Some(&TRANSIENT_FED_IDS) && bytes.get(4) == Some(&KIND_TRANSIENT);
        // A second instance of a federate waits until the first one has left.
        let is_second = connection.checked_sub(SECOND).is_some_and(|first| self.joined.contains(&first));
        match bytes.first() {
            Some(&UDP_PORT) if is_second => {}
            // Clock synchronization follows the port, and then only times may come.
            Some(&UDP_PORT) if self.datagrams.is_empty() => {
                self.joined.insert(connection);
            }
            Some(&TIMESTAMP) => {
                self.joined.insert(connection);
            }
            Some(&(RESIGN | FAILED)) => {
                self.joined.remove(&connection);
            }
            _ => {}
        }
        if self.joined.contains(&connection) {
            let [low, high] = (connection % SECOND).to_le_bytes();
            open.stream.write_all(&[13, low, high])?;
            open.take_address()?;
        }
        Ok(())
    }

    fn close(&mut self, connection: u16) -> io::Result<()> {
        self.joined.remove(&connection);
        if let Some(open) = self.connections.remove(&connection) {
            // The other side may have closed it already.
            let _ = open.stream.shutdown(Shutdown::Both);
        }
        Ok(())
    }

    fn now(&mut self) -> i64 {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX)
    }

    fn wait_until(&mut self, _: i64) -> io::Result<()> {
        Err(io::Error::other("a test does not sleep"))
    }

    fn bind(&mut self, federate: u16) -> io::Result<u16> {
        let socket = UdpSocket::bind(("127.0.0.1", 0))?;
        socket.set_read_timeout(Some(TIME_OUT))?;
        let port = socket.local_addr()?.port();
        self.datagrams.insert(federate, (socket, None));
        Ok(port)
    }

    fn send_datagram(&mut self, federate: u16, bytes: &[u8]) -> io::Result<()> {
        let (socket, rti) = self.datagrams.get(&federate).ok_or(io::ErrorKind::NotConnected)?;
        socket.send_to(bytes, rti.ok_or(io::ErrorKind::NotConnected)?).map(drop)
    }

    fn receive_datagram(&mut self, federate: u16) -> io::Result<Vec<u8>> {
        let (socket, rti) = self.datagrams.get_mut(&federate).ok_or(io::ErrorKind::NotConnected)?;
        let mut bytes = [0; 64];
        let (count, from) = socket.recv_from(&mut bytes)?;
        *rti = Some(from);
        Ok(bytes[..count].to_vec())
    }

    fn receive(&mut self, connection: u16, bytes: usize, end: bool) -> io::Result<Received> {
        let open = self.connections.get_mut(&connection).ok_or(io::ErrorKind::NotConnected)?;
        while !open.ended && (open.bytes.len() < bytes || end) {
            open.read()?;
        }
        Ok(Received { bytes: std::mem::take(&mut open.bytes), ended: open.ended })
    }
}

fn play(name: &str) {
    play_with(name, None);
}

/// Plays a recording, with an RTI that leaves a trace in this folder if one is given.
fn play_with(name: &str, trace: Option<&Path>) {
    let recording = lf_testkit::golden::load(name).unwrap_or_else(|error| panic!("{error}"));
    let setup = recording.rti().expect("it is the recording of an RTI");
    let federates = setup.federates.to_string();
    // The recorded RTI lets the others go on when a federate fails.
    let transients = setup.transient_federates.to_string();
    let mut arguments = vec!["--go-on-after-loss", "-n", &federates, "-nt", &transients, "-i", &setup.federation_id];
    arguments.extend(setup.options.iter().map(String::as_str));
    let (rti, port) = match trace {
        None => Lfz::rti(&arguments),
        Some(folder) => {
            arguments.extend(["-t", "--trace-csv", "messages.csv"]);
            Lfz::rti_in(folder, &arguments)
        }
    };
    let mut tcp = Tcp { port, connections: BTreeMap::new(), joined: BTreeSet::new(), datagrams: BTreeMap::new() };
    if let Err(difference) = replay(&recording, &mut tcp) {
        panic!("{difference}");
    }
    let finished = rti.finish();
    assert_eq!(finished.code(), setup.exit_code.expect("the recorded RTI ended"), "{finished}");
}

lf_testkit::recordings! {
    play;
    handshake: "01-handshake",
    reject_federation_id: "02-reject-federation-id",
    reject_id_in_use: "04-reject-id-in-use",
    two_federates: "06-two-federates",
    chain: "07-chain",
    after: "10-after",
    dnet: "17-dnet",
    stop: "20-stop",
    failed: "23-failed",
    large_message: "26-large-message",
    auth: "28-auth-accepted",
    clock_sync_on: "31-clock-sync-on",
    start_time_multiple: "32-start-time-multiple",
    random_dag_40: "33-random-dag-40",
    transient_present_from_the_start: "0.13/04-present-from-the-start",
    transient_absent_at_the_start: "0.13/05-absent-at-the-start",
    transient_joins_in_the_past: "0.13/07-joins-in-the-past",
    hot_swap: "0.13/15-hot-swap",
    dnet_only_downstream_absent: "0.13/20b-dnet-only-downstream-absent",
    messages_to_absent: "0.13/22-messages-to-absent",
    stop_while_absent: "0.13/26-stop-while-absent",
    rejections_while_running: "0.13/34-rejections-while-running",
    start_barrier: "0.13/38-start-barrier",
    transient_after: "0.13/40-after",
}

/// The trace of one recording has everything but the times, in the order of each direction of a connection.
#[test]
fn a_trace_has_every_message_with_its_tag() {
    let folder = tempfile::tempdir().expect("there is a folder for such");
    play_with("06-two-federates", Some(folder.path()));
    let trace = std::fs::read_to_string(folder.path().join("messages.csv")).expect("the RTI has written it");
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("physical_ns,direction,federate,message,tag_ns,microstep,to,bytes"));
    let rows: Vec<(i64, &str)> = lines
        .map(|line| line.split_once(',').expect("it has columns"))
        .map(|(time, rest)| (time.parse().expect("it is a number"), rest))
        .collect();
    assert!(rows.is_sorted_by_key(|(time, _)| *time), "{trace}");
    // The RTI may read the tester's query before or after it has written the results of the previous message.
    let of = |way: &str, federate: &str| {
        let start = format!("{way},{federate},");
        let own = rows.iter().map(|(_, rest)| *rest).filter(|rest| rest.starts_with(&start));
        own.filter(|rest| !rest.contains("ADDRESS_QUERY")).collect::<Vec<_>>()
    };
    let all = ["0", "1"].map(|federate| [of("received", federate), of("sent", federate)].concat());
    insta::with_settings!({
        snapshot_path => "../programs/traces",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!("two_federates", all.concat().join("\n"));
    });
}

/// LF's own format has a record for each message except those without a number in it.
#[test]
fn the_trace_for_the_tools_of_lf_has_a_record_for_each_message() {
    let folder = tempfile::tempdir().expect("there is a folder for such");
    play_with("06-two-federates", Some(folder.path()));
    let text = std::fs::read_to_string(folder.path().join("messages.csv")).expect("the RTI has written it");
    let trace = std::fs::read(folder.path().join("rti.lft")).expect("the RTI has written it, too");
    let without_number = ["NEIGHBOR_STRUCTURE", "UDP_PORT"];
    let lines = text.lines().skip(1).filter(|line| !without_number.iter().any(|name| line.contains(name)));
    // Each has its physical time and its federate.
    let number = |column: Option<&str>| column.and_then(|text| text.parse::<i64>().ok()).expect("it is a number");
    let lines = lines.map(|line| line.split(',')).map(|mut columns| (number(columns.next()), number(columns.nth(1))));
    let long = |bytes: &[u8]| i64::from_le_bytes(bytes.try_into().expect("they are 8"));
    let int = |bytes: &[u8]| i32::from_le_bytes(bytes.try_into().expect("they are 4"));
    let start = long(&trace[..8]);
    let records = trace[16..].chunks(64).map(|record| (long(&record[40..48]) - start, int(&record[20..24])));
    let records = records.map(|(time, federate)| (time, i64::from(federate)));
    assert_eq!(records.collect::<Vec<_>>(), lines.collect::<Vec<_>>(), "{text}");
}

/// The datagrams of clock synchronization are in the trace too, with the federate at the other end.
#[test]
fn a_trace_has_the_rounds_over_udp() {
    let folder = tempfile::tempdir().expect("there is a folder for such");
    play_with("31-clock-sync-on", Some(folder.path()));
    let trace = std::fs::read_to_string(folder.path().join("messages.csv")).expect("the RTI has written it");
    let messages = trace.lines().map(|line| line.split(',').skip(1).take(3).collect::<Vec<_>>().join(" "));
    let rounds = messages.filter(|line| [" T1", " T3", " T4", "_PROBE"].iter().any(|name| line.ends_with(name)));
    let round = ["sent 0 T1", "received 0 T3", "sent 0 T4", "sent 0 CODED_PROBE"];
    // In the second round the RTI discards an answer.
    let second = [&round[..2], &round[1..]].concat();
    let over_tcp = [&round[..3], &round[..3]].concat();
    let expected = [&over_tcp[..], &round, &second, &round, &round].concat();
    let rounds: Vec<String> = rounds.take(expected.len()).collect();
    assert_eq!(rounds, expected, "{trace}");
}
