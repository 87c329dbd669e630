// SPDX-License-Identifier: Apache-2.0
//! Peers that are gone without a word while data is in transit to them.
//!
//! TCP's keep-alive detects only the silence of idle connections. For unacknowledged data Linux goes on for a quarter
//! of an hour, and its user time-out would also end connections whose receiver is there, but accepts nothing for a
//! time, which is how a federation slows a sender down. So this module checks which connections get no answer: to data
//! that they have sent and repeat, or to probes, which Linux sends if nothing can be sent. That is so while the
//! receiver has no room, and then it answers the probes; and while the computer's own link is down. A connection
//! without an answer for [`SILENCE`] is ended.
//!
//! Linux goes through its whole table of connections for that, which can take it ten milliseconds however few there
//! are. So a thread reads the table, and the event loop evaluates it later.

use std::collections::BTreeMap;
use std::fs;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The time that a connection may get no answer; a silent one is probed for as long.
const SILENCE: Duration = Duration::from_secs(40);
/// The interval of the checks.
pub(super) const CHECK_INTERVAL: Duration = Duration::from_secs(5);
/// Linux's tables of connections. Without them, Linux's own time-outs apply.
const CONNECTIONS: [&str; 2] = ["/proc/self/net/tcp", "/proc/self/net/tcp6"];

/// The connections without an answer, by the inodes of their sockets, and since when.
#[derive(Debug)]
pub(super) struct Silence {
    /// The time of the last check, or of construction.
    looked: Instant,
    /// The table that a thread is reading.
    hearing: Option<Receiver<String>>,
    since: BTreeMap<u64, Instant>,
}

impl Silence {
    /// Returns the state before the first check: nothing can have been repeated for long.
    pub(super) fn new(now: Instant) -> Self {
        Self { looked: now, hearing: None, since: BTreeMap::new() }
    }

    /// Returns the connections that have had no answer for too long, and starts the next check if it is due.
    pub(super) fn poll(&mut self, now: Instant) -> Vec<u64> {
        // The result of the last check is evaluated before the next one replaces it.
        let gone = self.heard(now);
        if self.is_due(now) {
            self.look(now);
        }
        gone
    }

    /// Returns whether a check is due.
    fn is_due(&self, now: Instant) -> bool {
        now.duration_since(self.looked) >= CHECK_INTERVAL
    }

    /// Starts a check. Without a thread there is none, and Linux's own time-outs apply.
    fn look(&mut self, now: Instant) {
        self.looked = now;
        let (tell, hear) = channel();
        let read = move || {
            // The receiver may be gone.
            let _ = tell.send(CONNECTIONS.map(|file| fs::read_to_string(file).unwrap_or_default()).concat());
        };
        self.hearing = thread::Builder::new().spawn(read).ok().map(|_| hear);
    }

    /// Returns the connections that have had no answer for too long, once after each check.
    fn heard(&mut self, now: Instant) -> Vec<u64> {
        let Some(hearing) = &self.hearing else { return Vec::new() };
        match hearing.try_recv() {
            Err(TryRecvError::Empty) => Vec::new(),
            Err(TryRecvError::Disconnected) => {
                self.hearing = None;
                Vec::new()
            }
            Ok(connections) => {
                self.hearing = None;
                self.judge(&connections, now)
            }
        }
    }

    fn judge(&mut self, connections: &str, now: Instant) -> Vec<u64> {
        let silent = connections.lines().filter_map(unanswered);
        self.since = silent.map(|inode| (inode, self.since.get(&inode).copied().unwrap_or(now))).collect();
        let gone = self.since.iter().filter(|(_, since)| now.duration_since(**since) >= SILENCE);
        gone.map(|(inode, _)| *inode).collect()
    }
}

/// Returns the inode of a line's connection, if it waits for an answer to something that it has repeated already.
fn unanswered(line: &str) -> Option<u64> {
    // The fields behind the number, both addresses, the state and the queues.
    let mut fields = line.split_ascii_whitespace().skip(5);
    let (timer, _) = fields.next()?.split_once(':')?;
    let repetitions = u32::from_str_radix(fields.next()?, 16).ok()?;
    let _user = fields.next()?;
    // The probes since the last answer. One may be in transit.
    let probes: u32 = fields.next()?.parse().ok()?;
    let inode = fields.next()?.parse().ok()?;
    let is_unanswered = match timer {
        "01" => repetitions > 0,
        "04" => probes > 1,
        _ => false,
    };
    is_unanswered.then_some(inode)
}

#[cfg(test)]
mod tests {
    use super::{CHECK_INTERVAL, SILENCE, Silence};
    use std::fmt::Write as _;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    /// Returns the inode of the connection with a board.
    fn board(number: u8) -> u64 {
        4200 + u64::from(number)
    }

    /// Returns Linux's table: for each board its timer, its number of repetitions, and its number of probes without an
    /// answer.
    fn connections(boards: &[(u8, u8, u8, u8)]) -> String {
        let mut text = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n".to_owned();
        for (number, timer, repetitions, probes) in boards {
            let ends = if number % 2 == 0 {
                format!("0100000A:3AC5 {number:02X}00000A:1092")
            } else {
                format!("{:032X}:3AC5 {number:032X}:1092", 1)
            };
            let (queues, inode) = ("00000016:00000000", board(*number));
            let timer = format!("{timer:02X}:00000A21 {repetitions:08X}     0        {probes} {inode} 2 0");
            let _ = writeln!(text, "   0: {ends} 01 {queues} {timer}");
        }
        text
    }

    #[test]
    fn a_connection_without_an_answer_for_too_long_ends() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        // Boards 4 and 8 have a closed window and answer, the last probe of 8 is in transit, 5 is probed for liveness,
        // 6 has just been sent something. To 7 nothing can be sent.
        let text = connections(&[
            (2, 1, 1, 0),
            (3, 1, 9, 0),
            (4, 4, 0, 0),
            (5, 2, 0, 1),
            (6, 1, 0, 0),
            (7, 4, 0, 9),
            (8, 4, 0, 1),
        ]);
        assert_eq!(silence.judge(&text, begin), []);
        assert_eq!(silence.judge(&text, begin + SILENCE / 2), []);
        assert_eq!(silence.judge(&text, begin + SILENCE), [board(2), board(3), board(7)]);
    }

    #[test]
    fn an_acknowledgement_begins_anew() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        assert_eq!(silence.judge(&connections(&[(2, 1, 3, 0)]), begin), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 0, 0)]), begin + SILENCE / 2), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 1, 0)]), begin + SILENCE), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 9, 0)]), begin + SILENCE * 2), [board(2)]);
    }

    #[test]
    fn a_connection_that_linux_does_not_report_is_not_silent() {
        assert_eq!(Silence::new(Instant::now()).judge("", Instant::now()), []);
        assert_eq!(Silence::new(Instant::now()).judge("no: such lines", Instant::now()), []);
    }

    #[test]
    fn connections_are_checked_at_intervals() {
        let now = Instant::now();
        let mut silence = Silence::new(now);
        for begin in [now, now + CHECK_INTERVAL] {
            assert!(!silence.is_due(begin + Duration::from_secs(4)));
            assert!(silence.is_due(begin + Duration::from_secs(5)));
            silence.look(begin + CHECK_INTERVAL);
        }
    }

    /// An event loop with nothing to do calls only when a check is due.
    #[test]
    fn a_report_is_judged_before_the_next_check() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        for (after, gone) in [(CHECK_INTERVAL, vec![]), (CHECK_INTERVAL + SILENCE, vec![board(2)])] {
            let (tell, hear) = channel();
            silence.hearing = Some(hear);
            tell.send(connections(&[(2, 1, 9, 0)])).expect("it is heard");
            assert_eq!(silence.poll(begin + after), gone);
        }
    }

    /// No call waits for Linux's table: it is there at some later check, or never.
    #[test]
    fn a_report_is_judged_once_it_is_complete() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        assert_eq!(silence.heard(begin), []);
        let (tell, hear) = channel();
        silence.hearing = Some(hear);
        assert_eq!(silence.heard(begin), []);
        for now in [begin, begin + SILENCE] {
            let (tell, hear) = channel();
            silence.hearing = Some(hear);
            tell.send(connections(&[(2, 1, 9, 0)])).expect("it is heard");
            let gone = if now == begin { vec![] } else { vec![board(2)] };
            assert_eq!(silence.heard(now), gone);
            assert_eq!(silence.heard(now), []);
        }
        drop(tell);
    }
}
