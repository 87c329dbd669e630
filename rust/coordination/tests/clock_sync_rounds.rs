// SPDX-License-Identifier: Apache-2.0
//! The guarantees of the rounds over UDP, for any network and any clocks.

use std::net::Ipv4Addr;

use lf_coordination::clock_sync::{
    ClockCorrection, ClockFault, DRIFT_PPB_MAX, Exchange, Poll, ROUND_TIME_OUT, RTI_UDP_PORT, Responder, Round,
    SLEW_PPB_MAX, Tracker,
};
use lf_coordination::{Endpoint, IpAddress};
use lf_model::time::{Instant, Interval};
use lf_wire::Message;
use proptest::collection::vec;
use proptest::prelude::*;

const RTI: Endpoint = Endpoint { ip: IpAddress::V4(Ipv4Addr::LOCALHOST), port: RTI_UDP_PORT };
const MS: i64 = 1_000_000;
/// The RTI's clock is ahead by this much, at all times.
const AHEAD: i64 = 1_790_000_000_000_000_123;

fn bytes(message: &Message<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode(&mut bytes).unwrap();
    bytes
}

/// A federate that answers at once; returns the complete rounds.
#[derive(Default)]
struct Follower {
    responder: Responder,
    /// The RTI's clock, if that is known.
    physical: Option<Instant>,
    faults: Vec<ClockFault>,
    rounds: Vec<Round>,
}

impl Follower {
    /// Hears a message at this time of its own clock; whether it answers.
    fn hear_from(&mut self, from: Endpoint, own: i64, message: &Message<'_>) -> bool {
        let heard = self.responder.handle(Instant::from_nanos(own), self.physical, from, &bytes(message));
        self.rounds.extend(heard.round);
        self.faults.extend(heard.fault);
        if heard.answer {
            self.responder.answered(Instant::from_nanos(own));
        }
        heard.answer
    }

    fn hear(&mut self, own: i64, message: &Message<'_>) -> bool {
        self.hear_from(RTI, own, message)
    }
}

#[test]
fn a_round_is_t1_t3_t4_and_the_coded_probe() {
    let mut follower = Follower::default();
    assert!(follower.hear(10, &Message::T1(1_000)));
    assert!(!follower.hear(30, &Message::T4(1_020)));
    assert!(!follower.hear(37, &Message::CodedProbe(1_024)));
    let exchange = Exchange {
        t1: Instant::from_nanos(1_000),
        t2: Instant::from_nanos(10),
        t3: Instant::from_nanos(10),
        t4: Instant::from_nanos(1_020),
    };
    assert_eq!(follower.rounds, [Round { exchange, gap: Some(Interval::from_nanos(3)) }]);
}

#[test]
fn a_lost_datagram_costs_its_own_round_only() {
    let mut follower = Follower::default();
    // T4 is lost.
    assert!(follower.hear(0, &Message::T1(0)));
    assert!(follower.hear(10 * MS, &Message::T1(10 * MS)));
    follower.hear(11 * MS, &Message::T4(10 * MS + 7));
    // The coded probe is lost: the exchange still counts.
    assert!(follower.hear(20 * MS, &Message::T1(20 * MS)));
    let found: Vec<_> = follower.rounds.iter().map(|round| (round.exchange.t4, round.gap)).collect();
    assert_eq!(found, [(Instant::from_nanos(10 * MS + 7), None)]);
}

#[test]
fn stragglers_copies_and_strangers_are_not_taken_for_a_part_of_the_round() {
    let mut follower = Follower::default();
    assert!(follower.hear(0, &Message::T1(10 * MS)));
    assert!(!follower.hear(5, &Message::T1(10 * MS)), "a copy");
    assert!(!follower.hear(6, &Message::T1(9 * MS)), "an earlier one that comes later");
    let stranger = Endpoint::new(Ipv4Addr::LOCALHOST, 7);
    follower.hear_from(stranger, 7, &Message::T4(10 * MS + 1));
    follower.hear(7, &Message::T4(9 * MS));
    follower.hear(8, &Message::T4(10 * MS + 2));
    follower.hear_from(stranger, 9, &Message::CodedProbe(10 * MS + 3));
    assert_eq!(follower.rounds, []);
    follower.hear(10, &Message::CodedProbe(10 * MS + 4));
    assert_eq!(follower.rounds.len(), 1);
    assert_eq!(follower.rounds[0].exchange.t4, Instant::from_nanos(10 * MS + 2));
    // A false T1 from the future is believed for a limited time only.
    assert!(follower.hear(20 * MS, &Message::T1(i64::MAX)));
    assert!(!follower.hear(30 * MS, &Message::T1(30 * MS)));
    assert!(follower.hear(20 * MS + ROUND_TIME_OUT.as_nanos(), &Message::T1(40 * MS)));
}

/// Another program on the RTI's computer cannot steer the clock, cost rounds, or try that without a log event.
#[test]
fn rounds_of_another_port_are_told_and_count_only_when_the_first_is_silent() {
    let (mut follower, other) = (Follower::default(), Endpoint::new(Ipv4Addr::LOCALHOST, 4711));
    let mut now = 0;
    for _ in 0..100 {
        now += 10 * MS;
        assert!(follower.hear(now, &Message::T1(now)));
        for ahead in [3_600_000 * MS, i64::MAX - 1 - now] {
            assert!(!follower.hear_from(other, now + 1, &Message::T1(now + ahead)));
            follower.hear_from(other, now + 2, &Message::T4(now + ahead));
        }
        follower.hear(now + 3, &Message::T4(now + 3));
        follower.hear(now + 4, &Message::CodedProbe(now + 4));
    }
    assert_eq!(follower.rounds.len(), 100, "none is lost");
    let told = ClockFault::OtherPort { port: RTI_UDP_PORT, other: 4711 };
    assert!(follower.faults.iter().all(|fault| *fault == told) && follower.faults.len() == 400);
    assert!(!follower.hear_from(other, now + 9_000 * MS, &Message::T1(now + 9_000 * MS)));
    assert!(follower.hear_from(other, now + 11_000 * MS, &Message::T1(now + 11_000 * MS)));
}

#[test]
fn times_that_are_far_off_the_own_clock_are_told_and_ignored() {
    let mut follower = Follower { physical: Some(Instant::from_nanos(AHEAD)), ..Follower::default() };
    for time in [i64::MAX - 1, i64::MIN, 0, AHEAD + 3_600_000 * MS, AHEAD - 61_000 * MS] {
        assert!(!follower.hear(7, &Message::T1(time)), "{time}");
    }
    assert_eq!(follower.faults.len(), 5);
    assert_eq!(follower.faults[3], ClockFault::FarOff(Interval::from_secs(3_600)));
    assert!(follower.hear(8, &Message::T1(AHEAD)), "they do not cost a round");
    follower.hear(9, &Message::T4(i64::MAX));
    follower.hear(9, &Message::T4(AHEAD + 2));
    follower.hear(10, &Message::CodedProbe(AHEAD + 3));
    assert_eq!(follower.rounds.len(), 1);
}

#[test]
fn the_rti_waits_for_an_answer_as_long_as_answers_may_take() {
    let mut poll = Poll::NONE;
    assert!(!poll.answer(Instant::from_nanos(0)), "nothing was asked");
    assert!(poll.begin(Instant::from_nanos(0)));
    assert!(!poll.begin(Instant::from_nanos(999 * MS)), "its answer may still come");
    assert!(poll.begin(Instant::from_nanos(1_000 * MS)));
    assert!(poll.answer(Instant::from_nanos(1_001 * MS)));
    assert!(!poll.answer(Instant::from_nanos(1_001 * MS)), "a copy");
    // On a quick network a lost answer does not cost a second.
    let mut now = 1_001 * MS;
    for _ in 0..30 {
        now += MS;
        assert!(poll.begin(Instant::from_nanos(now)));
        assert!(poll.answer(Instant::from_nanos(now + 1)));
    }
    now += MS;
    assert!(poll.begin(Instant::from_nanos(now)));
    assert!(poll.begin(Instant::from_nanos(now + 100 * MS)));
    assert!(!poll.begin(Instant::from_nanos(now + 299 * MS)), "the time-out grows while answers fail to come");
    assert!(poll.begin(Instant::from_nanos(now + 300 * MS)));
}

/// The time-out falls by an eighth with each answer, and is eight times as long as the slowest of late needed.
#[test]
fn the_time_out_follows_the_answers() {
    let mut poll = Poll::NONE;
    let mut now = 0;
    let mut answered_after = |elapsed: i64, expected: i64| {
        assert!(poll.begin(Instant::from_nanos(now)));
        assert!(poll.answer(Instant::from_nanos(now + elapsed)));
        now += elapsed + 1;
        let mut unanswered = poll;
        assert!(unanswered.begin(Instant::from_nanos(now)));
        assert!(!unanswered.begin(Instant::from_nanos(now + expected - 1)), "{expected}");
        assert!(unanswered.begin(Instant::from_nanos(now + expected)), "{expected}");
    };
    answered_after(MS, 875 * MS);
    answered_after(MS, 765_625_000);
    answered_after(120 * MS, 960 * MS);
    answered_after(200 * MS, 1_000 * MS);
}

/// Bytes behind a message belong to nothing, so the datagram is not from an RTI.
#[test]
fn a_datagram_is_one_message() {
    let mut responder = Responder::default();
    let mut datagram = bytes(&Message::T1(1_000));
    datagram.push(0);
    let heard = responder.handle(Instant::from_nanos(10), None, RTI, &datagram);
    assert!(!heard.answer);
    datagram.pop();
    assert!(responder.handle(Instant::from_nanos(11), None, RTI, &datagram).answer);
}

/// The round of a T4 follows from its time, so no T1 may have the same time.
#[test]
fn no_round_begins_at_the_instant_at_which_the_last_was_answered() {
    let mut poll = Poll::NONE;
    assert!(poll.begin(Instant::from_nanos(0)));
    assert!(poll.answer(Instant::from_nanos(10)));
    assert!(!poll.begin(Instant::from_nanos(10)));
    assert!(poll.begin(Instant::from_nanos(11)));
    assert!(poll.answer(Instant::from_nanos(11)), "a coarse clock may not move within a round");
}

/// Datagrams of one round and of the next whose times fall on the same instant, as a random search found once.
#[test]
fn a_t3_that_comes_when_the_next_round_is_due_does_not_mix_them() {
    let slow = [Some(1_000), Some(4_000), Some(20_000), Some(21_000)];
    let quick = [Some(1_000), Some(30_000), Some(1_000), Some(1_000)];
    let rounds = play(&[&[slow][..], &[quick; 12]].concat());
    assert!(!rounds.is_empty());
    for Round { exchange: Exchange { t1, t2, t3, t4 }, .. } in rounds {
        assert!(t1.since(t2).as_nanos() <= AHEAD && AHEAD <= t4.since(t3).as_nanos());
    }
}

/// The times that the datagrams of a round take, in µs; none for a lost one.
type DatagramDelays = [Option<i64>; 4];

fn of_rounds(lost: u32, longest_us: i64) -> impl Strategy<Value = Vec<DatagramDelays>> {
    let one = || prop::option::weighted(1.0 - f64::from(lost) / 100.0, 0..longest_us);
    vec([one(), one(), one(), one()], 1..120)
}

/// Plays rounds of 5 ms between a [`Poll`] and a federate, in which datagrams overtake each other.
fn play(of_rounds: &[DatagramDelays]) -> Vec<Round> {
    let (mut poll, mut follower) = (Poll::NONE, Follower::default());
    // When, to the federate or the RTI, what.
    let mut under_way: Vec<(i64, Option<Message<'static>>, DatagramDelays)> = Vec::new();
    let mut now = 0;
    for delays in of_rounds {
        now += 5 * MS;
        loop {
            under_way.sort_by_key(|(at, ..)| std::cmp::Reverse(*at));
            let Some((at, message, delays)) = under_way.pop_if(|(at, ..)| *at <= now) else { break };
            let rti = at + AHEAD;
            let sent = |index: usize| delays[index].map(|us| at + 1_000 * us);
            match message {
                Some(message) if follower.hear(at, &message) => {
                    under_way.extend(sent(1).map(|at| (at, None, delays)));
                }
                None if poll.answer(Instant::from_nanos(rti)) => {
                    under_way.extend(sent(2).map(|at| (at, Some(Message::T4(rti)), delays)));
                    under_way.extend(sent(3).map(|at| (at, Some(Message::CodedProbe(rti)), delays)));
                }
                _ => {}
            }
        }
        if poll.begin(Instant::from_nanos(now + AHEAD)) {
            let t1 = Message::T1(now + AHEAD);
            under_way.extend(delays[0].map(|us| (now + 1_000 * us, Some(t1), *delays)));
        }
    }
    follower.rounds
}

/// Returns the time of a clock that gains `drift_ppb`, at a time of the RTI's.
fn own_clock(rti: i64, drift_ppb: i64) -> i64 {
    let drift = i128::from(rti) * i128::from(drift_ppb) / 1_000_000_000;
    rti + i64::try_from(drift).unwrap() - AHEAD
}

proptest! {
    // Each case of some is thousands of rounds.
    #![proptest_config(ProptestConfig { cases: 48, max_shrink_iters: 100, ..ProptestConfig::default() })]

    /// No matter what is lost or overtaken, the instants of an exchange belong together: they bound the offset.
    #[test]
    fn an_exchange_is_never_put_together_from_two_rounds(of_rounds in of_rounds(20, 40_000)) {
        for Round { exchange: Exchange { t1, t2, t3, t4 }, .. } in play(&of_rounds) {
            prop_assert!(t1.since(t2).as_nanos() <= AHEAD && AHEAD <= t4.since(t3).as_nanos());
        }
    }

    /// Where nothing is lost, and a round is over before the next, every round is complete. That of a coded probe which
    /// has overtaken its T4 counts when the next T1 comes.
    #[test]
    fn every_round_is_complete_where_nothing_is_lost(delays in vec(any::<[u8; 4]>(), 1..120)) {
        let in_us = |round: &[u8; 4]| round.map(|delay| Some(6 * i64::from(delay)));
        let of_rounds: Vec<DatagramDelays> = delays.iter().map(in_us).collect();
        prop_assert!(play(&of_rounds).len() + 2 >= of_rounds.len());
    }

    /// Offset and drift are found, however much jitter there is; if the drift is that of quartz, also though the
    /// federate's clock stands still now and then for a moment, but less exactly.
    #[test]
    fn the_line_follows_the_clock(
        // That of quartz, and more than any clock has.
        (drift_ppb, hiccups) in prop_oneof![
            (-100_000..100_000i64, any::<bool>()),
            (-20_000_000..20_000_000i64, Just(false)),
        ],
        jitter in 1..4_000_000i64,
        seed in any::<u32>(),
    ) {
        let mut tracker = Tracker::new();
        let mut random = u64::from(seed) | 1;
        let mut delay = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            50_000 + i64::try_from(random >> 33).unwrap() % jitter
        };
        let own = |rti: i64| own_clock(rti, drift_ppb);
        let begin = AHEAD;
        for round in 0..4_000 {
            let t1 = begin + round * 5 * MS;
            let (there, back) = (delay(), delay());
            let late = if hiccups && round % 10 == 7 { 3 * MS } else { 0 };
            let t2 = Instant::from_nanos(own(t1 + there) - late);
            let [t1, t4] = [t1, t1 + there + back].map(Instant::from_nanos);
            let exchange = Exchange { t1, t2, t3: t2, t4 };
            tracker.record(Round { exchange, gap: None });
        }
        let line = tracker.line().unwrap();
        let now = begin + 20_000 * MS;
        let error = line.offset_at(Instant::from_nanos(own(now))).as_nanos() - (now - own(now));
        // Of 100,000 clocks with hiccups the worst were wrong by 6.4 % of the jitter, and by 2 % per second.
        let (part, drift_part) = if hiccups { (10, 20) } else { (20, 100) };
        prop_assert!(error.abs() <= 1_000 + jitter / part, "wrong by {} ns: {:?}", error, line);
        // By the own clock: 1 / (1 + d) - 1.
        let expected = -drift_ppb * 1_000_000_000 / (1_000_000_000 + drift_ppb);
        let drift_error = i64::from(line.drift_ppb) - expected;
        prop_assert!(drift_error.abs() <= 2_000 + jitter / drift_part, "{:?}", line);
    }

    /// A clock that was set is followed, after the old line has been contradicted often enough.
    #[test]
    fn a_line_that_has_become_wrong_is_given_up(step in prop_oneof![MS..1_000 * MS, -1_000 * MS..-MS]) {
        let mut tracker = Tracker::new();
        for round in 0..2_000 {
            let own = round * 5 * MS;
            let rti = own + AHEAD + if round < 1_000 { 0 } else { step };
            let [t1, t2, t4] = [rti, own + 50, rti + 100].map(Instant::from_nanos);
            let exchange = Exchange { t1, t2, t3: t2, t4 };
            tracker.record(Round { exchange, gap: None });
        }
        let found = tracker.line().unwrap().offset_at(Instant::from_nanos(10_000 * MS)).as_nanos();
        prop_assert!((found - AHEAD - step).abs() < 1_000, "{}", found - AHEAD - step);
    }

    /// Clocks that show anything at all make no panic.
    #[test]
    fn any_instants_are_survived(all in vec((any::<[i64; 4]>(), any::<i64>()), 1..60)) {
        let mut tracker = Tracker::new();
        let mut clock = ClockCorrection::NONE;
        for ([t1, t2, t3, t4], now) in all {
            let [t1, t2, t3, t4] = [t1, t2, t3, t4].map(Instant::from_nanos);
            let exchange = Exchange { t1, t2, t3, t4 };
            tracker.record(Round { exchange, gap: Some(Interval::from_nanos(now)) });
            if let Some(line) = tracker.line() {
                clock.steer(Instant::from_nanos(now), &line, 1);
            }
        }
    }

    /// Any datagram from any sender is survived.
    #[test]
    fn any_datagram_is_survived(
        all in vec((any::<i64>(), any::<u16>(), vec(any::<u8>(), 0..12)), 1..60),
        physical: Option<i64>,
    ) {
        let mut responder = Responder::new();
        for (now, port, datagram) in all {
            let from = Endpoint::new(Ipv4Addr::LOCALHOST, port % 2);
            let heard = responder.handle(Instant::from_nanos(now), physical.map(Instant::from_nanos), from, &datagram);
            if heard.answer {
                responder.answered(Instant::from_nanos(now));
            }
        }
    }

    /// Physical time never runs backwards, and an event that is awaited is never jumped over: whatever the rounds say,
    /// physical time is past the event by no more than the time since the last look, a little faster.
    #[test]
    fn awaited_events_are_not_jumped_over(
        rounds in vec((0..50 * MS, -2_000 * MS..2_000 * MS, 0..20 * MS), 1..100),
        attenuation in 1..20u16,
        spacing in MS..200 * MS,
    ) {
        let fastest = |elapsed: i64| elapsed + elapsed * 3 / 20 + 2;
        let mut tracker = Tracker::new();
        let mut clock = ClockCorrection::with_offset(Interval::from_nanos(AHEAD));
        let mut now = 0_i64;
        let mut event = clock.physical(Instant::from_nanos(0)) + Interval::from_nanos(spacing);
        for (pause, error, width) in rounds {
            // The event loop waits for the event or the next datagram, whichever comes first.
            let datagram = now + pause;
            loop {
                let before = (now, clock.physical(Instant::from_nanos(now)));
                let due = clock.local(event).as_nanos().max(now + 1);
                now = due.min(datagram);
                let physical = clock.physical(Instant::from_nanos(now));
                prop_assert!(physical >= before.1, "time runs backwards");
                prop_assert!(physical.since(before.1).as_nanos() <= fastest(now - before.0), "time jumps");
                if physical >= event {
                    prop_assert!(physical.since(event).as_nanos() <= fastest(now - before.0));
                    event = event + Interval::from_nanos(spacing);
                }
                if now == datagram {
                    break;
                }
            }
            let t1 = now + AHEAD + error;
            let (t2, t4) = (Instant::from_nanos(now), Instant::from_nanos(t1 + width));
            let exchange = Exchange { t1: Instant::from_nanos(t1), t2, t3: t2, t4 };
            tracker.record(Round { exchange, gap: Some(Interval::from_nanos(0)) });
            if let Some(line) = tracker.line() {
                let before = clock.physical(Instant::from_nanos(now));
                clock.steer(Instant::from_nanos(now), &line, attenuation);
                prop_assert_eq!(clock.physical(Instant::from_nanos(now)), before, "a correction is no step");
            }
        }
        prop_assert_eq!(DRIFT_PPB_MAX + SLEW_PPB_MAX, 150_000_000);
    }
}
