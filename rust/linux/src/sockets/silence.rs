// SPDX-License-Identifier: Apache-2.0
//! Peers that are gone without a word while data is on its way to them.
//!
//! TCP's keep-alive notices only the silence of idle connections. For data that nobody acknowledges Linux goes on for a
//! quarter of an hour, and its user time-out would also end connections whose receiver is there, but takes nothing for
//! a time, which is how a federation slows a sender down. So it is looked at which connections get no answer: to what
//! they have sent and repeat, or to probes, which Linux sends where nothing can be sent. That is so while the receiver
//! has no room, and then it answers them; and while the computer's own link is down. A connection that has got no
//! answer for [`SILENCE`] is at its end.
//!
//! Linux goes through its whole table of connections to say that, which can take it ten milliseconds however few there
//! are. So a thread asks, and what it has heard is judged when the event loop comes by again.

use std::collections::BTreeMap;
use std::fs;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// How long a connection may get no answer; as long as a silent one is asked whether it is alive.
const SILENCE: Duration = Duration::from_secs(40);
/// How often it is looked.
pub(super) const LOOK_INTERVAL: Duration = Duration::from_secs(5);
/// Where Linux says what its connections do. Where it does not, all is as Linux has it.
const CONNECTIONS: [&str; 2] = ["/proc/self/net/tcp", "/proc/self/net/tcp6"];

/// Since when which connections get no answer. They are named by the inodes of their sockets.
#[derive(Debug)]
pub(super) struct Silence {
    /// When it was looked last, or this was made.
    looked: Instant,
    /// What a thread is about to hear of all connections.
    hearing: Option<Receiver<String>>,
    since: BTreeMap<u64, Instant>,
}

impl Silence {
    /// Nothing is known before the first interval is over, nor can anything have been repeated for long.
    pub(super) fn new(now: Instant) -> Self {
        Self { looked: now, hearing: None, since: BTreeMap::new() }
    }

    /// Says which connections have had no answer for too long, and looks again if it is time.
    pub(super) fn turn(&mut self, now: Instant) -> Vec<u64> {
        // What has been heard is judged before the next look forgets it.
        let gone = self.heard(now);
        if self.is_due(now) {
            self.look(now);
        }
        gone
    }

    /// Whether it is time to look.
    fn is_due(&self, now: Instant) -> bool {
        now.duration_since(self.looked) >= LOOK_INTERVAL
    }

    /// Begins to look. Without a thread nothing is heard, and all is as Linux has it.
    fn look(&mut self, now: Instant) {
        self.looked = now;
        let (tell, hear) = channel();
        let read = move || {
            // Whoever has asked may be gone.
            let _ = tell.send(CONNECTIONS.map(|file| fs::read_to_string(file).unwrap_or_default()).concat());
        };
        self.hearing = thread::Builder::new().spawn(read).ok().map(|_| hear);
    }

    /// Says which connections have had no answer for too long, once after each look.
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

/// The inode of a line's connection, if it waits for an answer to something that it has repeated already.
fn unanswered(line: &str) -> Option<u64> {
    // Behind the number, both addresses, the state and what is in the queues.
    let mut fields = line.split_ascii_whitespace().skip(5);
    let (timer, _) = fields.next()?.split_once(':')?;
    let repetitions = u32::from_str_radix(fields.next()?, 16).ok()?;
    let _user = fields.next()?;
    // Those since the last answer. One may be on its way.
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
    use super::{LOOK_INTERVAL, SILENCE, Silence};
    use std::fmt::Write as _;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    /// The inode of the connection with a board.
    fn board(number: u8) -> u64 {
        4200 + u64::from(number)
    }

    /// What Linux says: for each board its timer, how often it has repeated, and how many probes have had no answer.
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
    fn who_gets_no_answer_for_too_long_is_at_the_end() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        // Boards 4 and 8 have a closed window and answer, the last probe of 8 is on its way, 5 is asked whether it is
        // alive, 6 has just been sent something. To 7 nothing can be sent.
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
    fn what_linux_does_not_say_is_no_silence() {
        assert_eq!(Silence::new(Instant::now()).judge("", Instant::now()), []);
        assert_eq!(Silence::new(Instant::now()).judge("no: such lines", Instant::now()), []);
    }

    #[test]
    fn it_is_looked_now_and_then() {
        let now = Instant::now();
        let mut silence = Silence::new(now);
        for begin in [now, now + LOOK_INTERVAL] {
            assert!(!silence.is_due(begin + Duration::from_secs(4)));
            assert!(silence.is_due(begin + Duration::from_secs(5)));
            silence.look(begin + LOOK_INTERVAL);
        }
    }

    /// An event loop with nothing to do comes by only when it is time to look again.
    #[test]
    fn what_is_heard_is_judged_before_the_next_look() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        for (after, gone) in [(LOOK_INTERVAL, vec![]), (LOOK_INTERVAL + SILENCE, vec![board(2)])] {
            let (tell, hear) = channel();
            silence.hearing = Some(hear);
            tell.send(connections(&[(2, 1, 9, 0)])).expect("it is heard");
            assert_eq!(silence.turn(begin + after), gone);
        }
    }

    /// Nobody waits for what Linux says: it is there at some later look, or never.
    #[test]
    fn what_is_heard_is_judged_when_it_is_there() {
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
