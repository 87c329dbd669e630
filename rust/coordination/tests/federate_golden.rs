// SPDX-License-Identifier: Apache-2.0
//! The state machine of the federate against recordings of C federates: the tester's part is played from the file, and
//! what the federate sends is compared byte for byte.
//!
//! Two differences are allowed, and only these: a NET that repeats the federate's last NET is left out. The recorded
//! federates often send a NET twice, and always that of their last tag; the README of the recordings says that others
//! need not. So a NET in a recording is passed over if the NET before it, with or without other messages between the
//! two, is the same; and our federate never sends such a one. And after many tags with messages our federate sends
//! itself a `PORT_ABSENT` by way of the RTI, to see how far the RTI has come. Everything else has to be there, in the
//! same order, and nothing more.

use std::collections::VecDeque;
use std::net::Ipv4Addr;

use crate::federate_support::{Driver, NONCE, Program};
use lf_coordination::auth::answer_rti;
use lf_coordination::clock_sync::RTI_UDP_PORT;
use lf_coordination::federate::{ClockSync, Config, Disconnected, FederateError, Phase};
use lf_coordination::{Endpoint, FederateId, IpAddress};
use lf_model::time::{Instant, Interval};
use lf_testkit::golden::{Fill, Frame, Recording, Step};
use lf_wire::{DELAY_NONE, MessageType, RejectCode};

/// The RTI's clock is this much ahead of the federate's, as between 1970 and the boot of a board.
const RTI_AHEAD: Interval = Interval::from_nanos(1_790_000_000_000_000_123);
/// The time that a message takes.
const LATENCY: Interval = Interval::from_nanos(40_000);
const NET: u8 = 6;
const FED_NONCE: u8 = 100;
/// It asks for a stop in turn, which is nothing to a stock RTI.
const IN_TURN: [u8; 5] = [15, 0xff, 0xff, 0xff, 0xff];
const PACE_QUESTION: [u8; 17] = [23, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0, 0, 0, 0];
/// Where the federate awaits datagrams, and from where those of the RTI come.
const UDP_PORT: u16 = 40_000;
const RTI_UDP: Endpoint = Endpoint { ip: IpAddress::V4(Ipv4Addr::LOCALHOST), port: RTI_UDP_PORT };

struct Replay<'a> {
    driver: Driver<'a>,
    start: Instant,
    /// Times after the start at which the tester makes its first, second, … `send` after the start; where there is
    /// none, at once.
    send_times: &'a [Interval],
    sent_since_start: usize,
    last_net: Vec<u8>,
    /// From the federate, not looked at yet.
    datagrams: VecDeque<Vec<u8>>,
}

impl Replay<'_> {
    fn run(&mut self, steps: &[Step]) {
        for (index, step) in steps.iter().enumerate() {
            let at = format!("step {index}: {step:?}");
            match step {
                Step::Connect(_) => self.driver.connect(),
                Step::Recv(frame) => self.recv(frame, &at),
                Step::Send(frame) => self.send(frame, &at),
                Step::Silence(_) => self.silence(&at),
                Step::Close(_) | Step::ClosedByPeer(_) => {
                    self.silence(&at);
                    assert_eq!(self.driver.federate.handle_disconnected(), Ok(Disconnected::Ended), "{at}");
                }
                Step::UdpSend(frame) => self.send_datagram(frame, &at),
                Step::UdpRecv { frame, .. } => {
                    let found = self.datagrams.pop_front();
                    assert_eq!(found, frame.bytes.exact(), "{at}: found on the left");
                }
                other => panic!("not for a centralized federate: {other:?}"),
            }
            if !matches!(steps.get(index + 1), Some(Step::UdpRecv { .. })) {
                assert!(self.datagrams.is_empty(), "{at}: the federate answers {:02x?}", self.datagrams[0]);
            }
        }
    }

    /// Delivers a datagram of the RTI, and takes the answer.
    fn send_datagram(&mut self, frame: &Frame, at: &str) {
        self.silence(at);
        let bytes = self.clock(frame);
        let heard = self.driver.federate.handle_datagram(self.driver.now, RTI_UDP, &bytes);
        if let Some(answer) = heard.answer {
            self.driver.federate.answer_leaves(self.driver.now);
            let mut bytes = vec![0; answer.encoded_len()];
            answer.encode(&mut bytes).unwrap();
            self.datagrams.push_back(bytes);
        }
    }

    /// Asserts that the federate sends this frame next; runs its tags until it does.
    fn recv(&mut self, frame: &Frame, at: &str) {
        let expected = self.expected(frame);
        if expected[0] == NET && expected == self.last_net {
            // Left out. Nothing else may come in its place.
            return;
        }
        while self.driver.out.is_empty() {
            assert!(self.driver.step(Instant::FOREVER), "{at}: the federate does not go on");
        }
        let found = self.driver.out.pop_front().unwrap();
        if found == IN_TURN {
            return self.recv(frame, at);
        }
        if found == PACE_QUESTION {
            self.driver.receive(&PACE_QUESTION);
            return self.recv(frame, at);
        }
        assert!(found != self.last_net, "{at}: a NET is repeated");
        if found[0] == MessageType::UdpPort.byte() && frame.bytes.masked_len() > 0 {
            assert_eq!(frame.bytes.extract(&found).as_deref(), Some(&UDP_PORT.to_le_bytes()[..]), "{at}");
        } else if found[0] == FED_NONCE {
            assert_eq!(frame.bytes.extract(&found).as_deref(), Some(&NONCE[..]), "{at}");
        } else if frame.bytes.masked_len() > 0 && frame.tag.is_none() {
            // The federate's clock.
            let time = frame.bytes.extract(&found).unwrap_or_else(|| panic!("{at}: found {found:02x?}"));
            let told = Instant::from_nanos(i64::from_le_bytes(time.try_into().unwrap()));
            assert_eq!(told, self.physical(), "{at}");
        } else {
            assert_eq!(found, expected, "{at}: found on the left");
        }
        if found[0] == NET {
            self.last_net = found;
        }
    }

    /// Returns the frame with its tag in place.
    fn expected(&self, frame: &Frame) -> Vec<u8> {
        let time = frame.tag.map_or(0, |tag| self.start.as_nanos() + tag.time_ns);
        frame.bytes.fill_with(time.to_le_bytes())
    }

    fn send(&mut self, frame: &Frame, at: &str) {
        if self.start != Instant::NEVER {
            if let Some(time) = self.send_times.get(self.sent_since_start) {
                let until = self.driver.federate.clock().local(self.start + *time);
                while self.driver.step(until) {
                    self.silence(at);
                }
                self.driver.now = until;
            }
            self.sent_since_start += 1;
        }
        self.silence(at);
        let bytes = match &frame.fill {
            None => frame.bytes.exact().unwrap(),
            Some(Fill::PhysicalTime) => self.clock(frame),
            Some(Fill::Start) => {
                self.start = self.physical() + Interval::from_millis(300);
                frame.bytes.fill_with(self.start.as_nanos().to_le_bytes())
            }
            Some(Fill::TagTime) => self.expected(frame),
            // Over the type of the message, federate 0 and its nonce.
            Some(Fill::Hmac { key }) => {
                let proven = [&[frame.bytes.fill_with([])[0], 0, 0][..], &NONCE].concat();
                frame.bytes.fill_with(lf_testkit::golden::hmac(key, &proven))
            }
            Some(other) => panic!("not for a centralized federate: {other:?}"),
        };
        self.driver.receive(&bytes);
    }

    /// T1 or T4, filled in, and on its way for a while.
    fn clock(&mut self, frame: &Frame) -> Vec<u8> {
        const T4: u8 = 21;
        if frame.bytes.bytes()[0] == Some(T4) {
            self.driver.now = self.driver.now + LATENCY;
        }
        let bytes = frame.bytes.fill_with((self.driver.now + RTI_AHEAD).as_nanos().to_le_bytes());
        self.driver.now = self.driver.now + LATENCY;
        bytes
    }

    /// Nothing comes from the federate without its tags going on.
    fn silence(&self, at: &str) {
        assert!(self.driver.out.is_empty(), "{at}: the federate also sends {:02x?}", self.driver.out[0]);
    }

    fn physical(&self) -> Instant {
        self.driver.federate.clock().physical(self.driver.now)
    }
}

/// Replays a recording; returns the driver as it is in the end.
fn replay(name: &str, program: Program, send_times_ms: &[i64], check: impl FnOnce(&Driver<'_>)) {
    let recording = lf_testkit::golden::load(name).unwrap();
    let setup = recording.federate().unwrap();
    let upstream: Vec<_> = setup.upstream.iter().map(|id| (*id, DELAY_NONE)).collect();
    let mut config = Config::new(FederateId(setup.id), setup.federation_id.as_bytes());
    (config.upstream, config.downstream) = (&upstream, &setup.downstream);
    config.authentication = setup.auth.then_some(answer_rti);
    if name == "57-clock-sync-off" {
        config.clock_sync = ClockSync::Off;
    } else if name == "56-clock-sync-on" {
        config.clock_sync = ClockSync::On { trials: 10, attenuation: 10 };
        (config.udp_port, config.rti) = (Some(UDP_PORT), Some(RTI_UDP.ip));
    }
    let send_times: Vec<_> = send_times_ms.iter().map(|ms| Interval::from_millis(*ms)).collect();
    let driver = Driver::new(config, program, time_out(&recording), Instant::from_nanos(5_000_000_000));
    let mut replay = Replay {
        driver,
        start: Instant::NEVER,
        send_times: &send_times,
        sent_since_start: 0,
        last_net: vec![],
        datagrams: VecDeque::new(),
    };
    replay.run(&recording.steps);
    assert!(replay.send_times.len() <= replay.sent_since_start);
    check(&replay.driver);
}

/// Returns the program's time-out, from its command line: `-o 500 msec`.
fn time_out(recording: &Recording) -> Interval {
    match recording.federate().unwrap().arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["-o", number, "msec"] => Interval::from_millis(number.parse().unwrap()),
        ["-o", number, "sec"] => Interval::from_secs(number.parse().unwrap()),
        ref other => panic!("{other:?}"),
    }
}

fn resigned(driver: &Driver<'_>) {
    assert_eq!((driver.federate.phase(), driver.error), (Phase::Ended, None));
}

const ALWAYS: Program = Program::Source { sends: |_| true, stops: None };

#[test]
fn a_source_that_no_dnet_reaches() {
    replay("50-centralized-source", ALWAYS, &[], |driver| {
        resigned(driver);
        // All exchanges took equally long there and back, so the estimate is exact.
        assert_eq!(driver.federate.clock().physical(Instant::from_nanos(0)), Instant::from_nanos(0) + RTI_AHEAD);
    });
}

#[test]
fn a_source_with_dnets_leaves_out_nets_and_sends_the_one_that_is_needed_after_all() {
    // The notes of the recording say when the DNETs came.
    let program = Program::Source { sends: |number| number % 4 == 1, stops: None };
    replay("50b-centralized-source-dnet", program, &[50, 450, 650, 850, 1050], resigned);
}

#[test]
fn rounds_over_udp() {
    replay("56-clock-sync-on", ALWAYS, &[], |driver| {
        resigned(driver);
        let report = driver.federate.clock_sync_report().unwrap();
        assert_eq!((report.exchanges, report.calm, report.unused), (3, 3, 0));
        assert_eq!(driver.federate.clock().physical(driver.now), driver.now + RTI_AHEAD);
    });
}

#[test]
fn a_sink_with_grants_and_messages() {
    replay("51-centralized-sink", Program::Sink, &[], resigned);
}

#[test]
fn a_sink_that_is_asked_to_stop() {
    replay("51b-centralized-sink-stop", Program::Sink, &[], resigned);
}

#[test]
fn a_sink_whose_rti_fails() {
    replay("51c-centralized-sink-rti-failed", Program::Sink, &[], |driver| {
        assert_eq!((driver.federate.phase(), driver.error), (Phase::Failed, Some(FederateError::RtiFailed)));
    });
}

#[test]
fn a_source_that_requests_a_stop() {
    replay("53-stop-request", Program::Source { sends: |_| true, stops: Some(3) }, &[], resigned);
}

#[test]
fn a_source_that_authenticates() {
    replay("54-auth", ALWAYS, &[], resigned);
}

#[test]
fn a_source_whose_rti_has_another_key() {
    replay("54b-auth-wrong-rti", ALWAYS, &[], |driver| {
        assert_eq!((driver.federate.phase(), driver.error), (Phase::Failed, Some(FederateError::RtiNotAuthentic)));
    });
}

#[test]
fn a_source_without_clock_synchronization() {
    replay("57-clock-sync-off", ALWAYS, &[], resigned);
}

/// The recorded federate asks again on a connection that the RTI is about to close, for a minute. Ours takes a
/// rejection as final, logs its reason and advice, and does not send the RTI FAILED.
#[test]
#[allow(clippy::doc_markdown, reason = "the message's name in the protocol is no code")]
fn a_rejection_is_final() {
    let recording = lf_testkit::golden::load("55-rejected").unwrap();
    let setup = recording.federate().unwrap();
    let mut config = Config::new(FederateId(setup.id), setup.federation_id.as_bytes());
    config.downstream = &setup.downstream;
    let driver = Driver::new(config, ALWAYS, time_out(&recording), Instant::from_nanos(0));
    let mut replay = Replay {
        driver,
        start: Instant::NEVER,
        send_times: &[],
        sent_since_start: 0,
        last_net: vec![],
        datagrams: VecDeque::new(),
    };
    let until_rejected = recording.steps.iter().position(|step| matches!(step, Step::Send(_))).unwrap() + 1;
    replay.run(&recording.steps[..until_rejected]);
    let driver = replay.driver;
    assert_eq!(driver.error, Some(FederateError::Rejected(RejectCode::FederationIdMismatch)));
    assert_eq!((driver.federate.phase(), driver.out.len()), (Phase::Failed, 0));
}
