// SPDX-License-Identifier: Apache-2.0
//! Plays the federates of a recording against an RTI, wherever that runs, and compares its answers.
//!
//! After every action, the bytes on each connection have to equal the recorded ones wherever nothing is masked; the
//! order between connections does not matter. The replay allows one deviation: the recorded RTI, after a RESIGN, waits
//! for the federate to close its connection before it reads the others. An RTI that reads them at once is equally
//! correct, so the RESIGN and the close are one action for the other connections.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::hmac;
use super::recording::{Fill, Frame, Recording, Role, Step};

/// The bytes that arrived on a connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Whether the RTI has closed its direction.
    pub ended: bool,
}

/// The RTI under test. Connections have the numbers of the recording.
pub trait Rti {
    /// The reason why the RTI cannot be reached.
    type Error: fmt::Display;

    /// Opens a connection.
    ///
    /// # Errors
    /// If it cannot be opened.
    fn connect(&mut self, connection: u16) -> Result<(), Self::Error>;

    /// Sends bytes.
    ///
    /// # Errors
    /// If they cannot be sent.
    fn send(&mut self, connection: u16, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Closes a connection, at once and in both directions.
    ///
    /// # Errors
    /// If it cannot be closed.
    fn close(&mut self, connection: u16) -> Result<(), Self::Error>;

    /// Takes all bytes that arrived on a connection since the last call. Waits, as long as is reasonable, until there
    /// are `bytes` bytes, and for the end of the connection if `end`. Need not wait longer, but has to return all bytes
    /// that are there.
    ///
    /// # Errors
    /// If the connection cannot be read.
    fn receive(&mut self, connection: u16, bytes: usize, end: bool) -> Result<Received, Self::Error>;

    /// Returns the time of the tester's clock, in nanoseconds.
    fn now(&mut self) -> i64;

    /// Waits until the tester's clock shows this time, in nanoseconds.
    ///
    /// # Errors
    /// If this tester does not wait.
    fn wait_until(&mut self, time_ns: i64) -> Result<(), Self::Error>;

    /// Opens a UDP port for a federate; returns its number.
    ///
    /// # Errors
    /// If it cannot be opened.
    fn bind(&mut self, federate: u16) -> Result<u16, Self::Error>;

    /// Sends a datagram of a federate to the source of its last received one.
    ///
    /// # Errors
    /// If it cannot be sent.
    fn send_datagram(&mut self, federate: u16, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Waits for the next datagram to a federate, as long as is reasonable.
    ///
    /// # Errors
    /// If none arrives.
    fn receive_datagram(&mut self, federate: u16) -> Result<Vec<u8>, Self::Error>;
}

/// The place where a replay differed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Name of the recording.
    pub recording: String,
    /// The step, counted from 0: the action after which it differed.
    pub step: usize,
    /// The difference.
    pub reason: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, step {}: {}", self.recording, self.step, self.reason)
    }
}

impl std::error::Error for Difference {}

/// Plays a recording of role `rti`.
///
/// # Errors
/// Returns the first [`Difference`], or the reason that prevented the replay.
pub fn replay<R: Rti>(recording: &Recording, rti: &mut R) -> Result<(), Difference> {
    let mut replay =
        Replay { rti, open: BTreeSet::new(), varying: BTreeMap::new(), ports: BTreeMap::new(), start: None };
    let fail = |step: usize, reason: String| Difference { recording: recording.name.clone(), step, reason };
    if !matches!(recording.role, Role::Rti(_)) {
        return Err(fail(0, "this is not the recording of an RTI".into()));
    }
    let mut index = 0;
    while index < recording.steps.len() {
        let first = index;
        let (action, mut expected, mut next) = round(&recording.steps, index);
        let mut outcome = replay.act(action);
        if let Some((connection, close)) = resignation(action, recording.steps.get(next)) {
            let (own, others): (Vec<_>, Vec<_>) = expected.into_iter().partition(|step| of(step) == Some(connection));
            outcome = outcome.and_then(|()| replay.check(connection, &own)).and_then(|()| replay.act(close));
            let (_, later, after) = round(&recording.steps, next);
            expected = others.into_iter().chain(later).collect();
            next = after;
        }
        outcome.and_then(|()| replay.check_all(&expected)).map_err(|reason| fail(first, reason))?;
        index = next;
    }
    Ok(())
}

/// Returns the action at `index`, the recorded answers to it, and the index of the next action.
fn round(steps: &[Step], index: usize) -> (&Step, Vec<&Step>, usize) {
    let is_expectation =
        |step: &&Step| matches!(step, Step::Recv(_) | Step::UdpRecv { .. } | Step::ClosedByPeer(_) | Step::Silence(_));
    let expected: Vec<_> = steps[index + 1..].iter().take_while(is_expectation).collect();
    let next = index + 1 + expected.len();
    (&steps[index], expected, next)
}

/// Returns the connection and the close, if a federate resigns and then closes its connection.
fn resignation<'r>(action: &Step, next: Option<&'r Step>) -> Option<(u16, &'r Step)> {
    match (action, next) {
        (Step::Send(Frame { connection, message, .. }), Some(close @ Step::Close(closed)))
            if message == "RESIGN" && connection == closed =>
        {
            Some((*connection, close))
        }
        _ => None,
    }
}

/// Returns the connection of an expectation.
fn of(step: &Step) -> Option<u16> {
    match step {
        Step::Recv(frame) => Some(frame.connection),
        Step::ClosedByPeer(connection) => Some(*connection),
        _ => None,
    }
}

struct Replay<'r, R> {
    rti: &'r mut R,
    open: BTreeSet<u16>,
    /// The last bytes on each connection where the recording masks them.
    varying: BTreeMap<u16, Vec<u8>>,
    /// The UDP ports of the federates.
    ports: BTreeMap<u16, u16>,
    /// The start time, once it is known, if it varies.
    start: Option<i64>,
}

impl<R: Rti> Replay<'_, R> {
    fn act(&mut self, step: &Step) -> Result<(), String> {
        let done = match step {
            Step::Connect(connection) => {
                self.open.insert(*connection);
                self.rti.connect(*connection)
            }
            Step::Send(frame) => {
                let bytes = self.filled(frame)?;
                self.rti.send(frame.connection, &bytes)
            }
            Step::Close(connection) => {
                self.open.remove(connection);
                self.rti.close(*connection)
            }
            Step::Until(after_start) => {
                let start = self.start.ok_or("the start time is not known")?;
                self.rti.wait_until(start + after_start)
            }
            Step::UdpBind(federate) => self.rti.bind(*federate).map(|port| {
                self.ports.insert(*federate, port);
            }),
            Step::UdpSend(frame) => {
                let bytes = self.filled(frame)?;
                self.rti.send_datagram(frame.connection, &bytes)
            }
            other => return Err(format!("this replay cannot do {other:?}")),
        };
        done.map_err(|error| format!("{step:?}: {error}"))
    }

    /// Returns the bytes to send, with the proof of a federate that authenticates: over the type of its message and the
    /// RTI's nonce.
    fn filled(&mut self, frame: &Frame) -> Result<Vec<u8>, String> {
        match &frame.fill {
            None => frame.bytes.exact().ok_or_else(|| "nothing says how to fill the masked bytes".to_owned()),
            Some(Fill::Hmac { key }) => {
                let message_type = frame.bytes.bytes().first().copied().flatten();
                let nonce = self.varying.get(&frame.connection).ok_or("no nonce has come")?;
                let proven: Vec<u8> = message_type.into_iter().chain(nonce.iter().copied()).collect();
                Ok(frame.bytes.fill_with(hmac(key, &proven)))
            }
            Some(Fill::UdpPort) => {
                let port = self.ports.get(&frame.connection).ok_or("no UDP port is open")?;
                Ok(frame.bytes.fill_with(port.to_le_bytes()))
            }
            Some(Fill::PhysicalTime) => Ok(frame.bytes.fill_with(self.rti.now().to_le_bytes())),
            Some(Fill::TagTime) => {
                let tag = frame.tag.ok_or("no tag is there")?;
                let start = self.start.ok_or("the start time is not known")?;
                Ok(frame.bytes.fill_with((start + tag.time_ns).to_le_bytes()))
            }
            Some(other) => Err(format!("this replay cannot fill in {other:?}")),
        }
    }

    fn check_all(&mut self, expected: &[&Step]) -> Result<(), String> {
        for connection in self.open.clone() {
            let own: Vec<_> = expected.iter().copied().filter(|step| of(step) == Some(connection)).collect();
            self.check(connection, &own)?;
        }
        // The receiver checks the source of each datagram: T4 goes to the source of T3.
        for step in expected {
            let Step::UdpRecv { frame, .. } = step else { continue };
            let found = self.rti.receive_datagram(frame.connection).map_err(|error| format!("{step:?}: {error}"))?;
            if !frame.bytes.matches(&found) {
                return Err(format!(
                    "federate {} should get {}, but got {}",
                    frame.connection,
                    frame.message,
                    hex(&found)
                ));
            }
        }
        Ok(())
    }

    /// Checks the time of a tag, where the start time varies; the first one shows the start time.
    fn check_time(&mut self, frame: &Frame, varying: &[u8]) -> Result<(), String> {
        let (Some(tag), Some((_, last))) = (frame.tag, varying.split_last_chunk()) else { return Ok(()) };
        let found = i64::from_le_bytes(*last);
        let expected = *self.start.get_or_insert(found - tag.time_ns) + tag.time_ns;
        let text = || format!("{} should have the time {expected}, but has {found}", frame.message);
        if found == expected { Ok(()) } else { Err(text()) }
    }

    fn check(&mut self, connection: u16, expected: &[&Step]) -> Result<(), String> {
        let frames: Vec<&Frame> = expected.iter().filter_map(|step| frame(step)).collect();
        let len = frames.iter().map(|frame| frame.bytes.len()).sum();
        let end = expected.iter().any(|step| matches!(step, Step::ClosedByPeer(_)));
        let received =
            self.rti.receive(connection, len, end).map_err(|error| format!("connection {connection}: {error}"))?;
        let mut rest = &received.bytes[..];
        for frame in frames {
            let (found, after) = rest.split_at(rest.len().min(frame.bytes.len()));
            if !frame.bytes.matches(found) {
                let (message, bytes) = (&frame.message, &frame.bytes);
                let found = hex(rest);
                return Err(format!("connection {connection} should get {message} ({bytes}), but got {found:?}"));
            }
            if let Some(varying) = frame.bytes.extract(found).filter(|varying| !varying.is_empty()) {
                self.check_time(frame, &varying).map_err(|reason| format!("connection {connection}: {reason}"))?;
                self.varying.insert(connection, varying);
            }
            rest = after;
        }
        if !rest.is_empty() {
            return Err(format!("connection {connection} got {} which nothing accounts for", hex(rest)));
        }
        if received.ended && !end {
            return Err(format!("connection {connection} was closed, which nothing accounts for"));
        }
        if end && !received.ended {
            return Err(format!("connection {connection} should be closed by the RTI, but is open"));
        }
        if end {
            // No more bytes can come, so there is nothing more to compare.
            self.open.remove(&connection);
        }
        Ok(())
    }
}

fn frame(step: &Step) -> Option<&Frame> {
    match step {
        Step::Recv(frame) => Some(frame),
        _ => None,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
