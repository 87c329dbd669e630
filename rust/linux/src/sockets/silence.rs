// SPDX-License-Identifier: Apache-2.0
//! Peers that are gone without a word while data is on its way to them.
//!
//! TCP's keep-alive notices only the silence of idle connections. For data that nobody acknowledges Linux goes on for a
//! quarter of an hour, and its user time-out would also end connections whose receiver is there, but takes nothing for
//! a time, which is how a federation slows a sender down. So it is looked at which connections repeat what they have
//! sent: one that has done nothing else for [`SILENCE`] is at its end.
//!
//! Linux goes through its whole table of connections to say that, which can take it ten milliseconds however few there
//! are. So a thread asks, and what it has heard is judged when the event loop comes by again.

use std::collections::BTreeMap;
use std::fs;
use std::net::SocketAddrV4;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// How long a connection may repeat what it has sent; as long as a silent one is asked whether it is alive.
const SILENCE: Duration = Duration::from_secs(40);
/// How often it is looked.
pub(super) const LOOK_INTERVAL: Duration = Duration::from_secs(5);
/// Where Linux says what its connections do. Where it does not, all is as Linux has it.
const CONNECTIONS: &str = "/proc/self/net/tcp";

/// The addresses of both ends of a connection, this one's first.
pub(super) type Ends = (SocketAddrV4, SocketAddrV4);

/// Since when which connections repeat what they have sent.
#[derive(Debug)]
pub(super) struct Silence {
    /// When it was looked last, or this was made.
    looked: Instant,
    /// What a thread is about to hear of all connections.
    hearing: Option<Receiver<String>>,
    since: BTreeMap<Ends, Instant>,
}

impl Silence {
    /// Nothing is known before the first interval is over, nor can anything have been repeated for long.
    pub(super) fn new(now: Instant) -> Self {
        Self { looked: now, hearing: None, since: BTreeMap::new() }
    }

    /// Says which connections have been repeating for too long, and looks again if it is time.
    pub(super) fn turn(&mut self, now: Instant) -> Vec<Ends> {
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
            let _ = tell.send(fs::read_to_string(CONNECTIONS).unwrap_or_default());
        };
        self.hearing = thread::Builder::new().spawn(read).ok().map(|_| hear);
    }

    /// Says which connections have been repeating for too long, once after each look.
    fn heard(&mut self, now: Instant) -> Vec<Ends> {
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

    fn judge(&mut self, connections: &str, now: Instant) -> Vec<Ends> {
        let repeating = connections.lines().filter_map(repeating);
        self.since = repeating.map(|ends| (ends, self.since.get(&ends).copied().unwrap_or(now))).collect();
        let gone = self.since.iter().filter(|(_, since)| now.duration_since(**since) >= SILENCE);
        gone.map(|(ends, _)| *ends).collect()
    }
}

/// The connection of a line, if it waits for the acknowledgement of something that it has repeated already.
fn repeating(line: &str) -> Option<Ends> {
    let mut fields = line.split_ascii_whitespace().skip(1);
    let own = address(fields.next()?)?;
    let peer = address(fields.next()?)?;
    // Its state, and what is in its queues.
    let mut fields = fields.skip(2);
    let waits_for_acknowledgement = fields.next()?.starts_with("01:");
    let repetitions = u32::from_str_radix(fields.next()?, 16).ok()?;
    (waits_for_acknowledgement && repetitions > 0).then_some((own, peer))
}

/// An address as Linux writes it: the four bytes as one number of this computer, and the port.
fn address(text: &str) -> Option<SocketAddrV4> {
    let (ip, port) = text.split_once(':')?;
    let ip = u32::from_str_radix(ip, 16).ok()?.to_ne_bytes();
    Some(SocketAddrV4::new(ip.into(), u16::from_str_radix(port, 16).ok()?))
}

#[cfg(test)]
mod tests {
    use super::{Ends, LOOK_INTERVAL, SILENCE, Silence};
    use std::fmt::Write as _;
    use std::net::{Ipv4Addr, SocketAddrV4};
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    const RTI: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), 15045);

    fn board(number: u8) -> Ends {
        (RTI, SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, number), 4242))
    }

    /// What Linux says: for each board its timer, and how often it has repeated.
    fn connections(boards: &[(u8, u8, u8)]) -> String {
        let mut text = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n".to_owned();
        for (number, timer, repetitions) in boards {
            let hex = |end: SocketAddrV4| format!("{:08X}:{:04X}", u32::from_ne_bytes(end.ip().octets()), end.port());
            let (own, peer) = board(*number);
            let (own, peer) = (hex(own), hex(peer));
            let queues = "00000016:00000000";
            let _ = writeln!(text, "   0: {own} {peer} 01 {queues} {timer:02X}:00000A21 {repetitions:08X}     0");
        }
        text
    }

    #[test]
    fn who_repeats_for_too_long_is_at_the_end() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        // Board 4 has a closed window, 5 is asked whether it is alive, 6 has just been sent something.
        let text = connections(&[(2, 1, 1), (3, 1, 9), (4, 4, 0), (5, 2, 0), (6, 1, 0)]);
        assert_eq!(silence.judge(&text, begin), []);
        assert_eq!(silence.judge(&text, begin + SILENCE / 2), []);
        assert_eq!(silence.judge(&text, begin + SILENCE), [board(2), board(3)]);
    }

    #[test]
    fn an_acknowledgement_begins_anew() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        assert_eq!(silence.judge(&connections(&[(2, 1, 3)]), begin), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 0)]), begin + SILENCE / 2), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 1)]), begin + SILENCE), []);
        assert_eq!(silence.judge(&connections(&[(2, 1, 9)]), begin + SILENCE * 2), [board(2)]);
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
            tell.send(connections(&[(2, 1, 9)])).expect("it is heard");
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
            tell.send(connections(&[(2, 1, 9)])).expect("it is heard");
            let gone = if now == begin { vec![] } else { vec![board(2)] };
            assert_eq!(silence.heard(now), gone);
            assert_eq!(silence.heard(now), []);
        }
        drop(tell);
    }
}
