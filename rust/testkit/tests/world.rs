// SPDX-License-Identifier: Apache-2.0
//! Virtual time advances as participants have reasons to run, and a seed decides the rest.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use std::sync::Mutex;
use std::thread;

use lf_coordination::Deadline;
use lf_model::Outside as _;
use lf_model::time::{Instant, Interval};
use lf_runtime::platform::{Endpoint, Interest, Platform as _, Transfer};
use lf_testkit::network::address_of;
use lf_testkit::random::Random;
use lf_testkit::world::{
    ComputerSpeed, Conditions, Fault, LivenessViolation, Side, Thread, Threads, Virtual, Wires, World,
};

const MS: fn(i64) -> Interval = Interval::from_millis;
const PORT: u16 = 7;

fn world(seed: u64) -> World<Wires> {
    World::new(Wires::new(Conditions::seeded(seed)), Random::new(seed))
}

/// Returns the order of turns of three participants that begin at once, and one that begins later.
fn order(seed: u64) -> Vec<usize> {
    let mut world = world(seed);
    for begins in [10, 10, 10, 20] {
        world.join(Side::keep(0, 0), begins, ComputerSpeed::INSTANT);
    }
    std::iter::from_fn(|| world.next_turn(None)).collect()
}

#[test]
fn the_seed_decides_who_comes_first_at_one_time_and_nothing_else() {
    let orders: Vec<_> = (0..64).map(order).collect();
    assert!(orders.iter().all(|order| order[3] == 3), "{orders:?}");
    assert!((0..3).all(|first| orders.iter().any(|order| order[0] == first)), "{orders:?}");
    assert_eq!(orders, (0..64).map(order).collect::<Vec<_>>());
}

#[test]
fn time_goes_on_to_the_next_turn_but_not_beyond_the_limit() {
    let mut world = world(1);
    let me = world.join(Side::keep(0, 0), 10, ComputerSpeed::INSTANT);
    assert_eq!((world.next_turn(Some(9)), world.now()), (None, 0));
    assert_eq!((world.next_turn(Some(10)), world.now()), (Some(me), 10));
    world.after_turn(me, None);
    assert_eq!(world.next_turn(None), None, "it waits without end");
    world.schedule(me, 50);
    world.schedule(me, 30);
    assert_eq!((world.next_turn(None), world.now()), (Some(me), 30), "the earliest time counts");
    world.after_turn(me, Some(40));
    world.end(me);
    assert_eq!((world.next_turn(None), world.has_ended(me), world.left()), (None, true, 0));
}

#[test]
fn a_participant_that_computes_sees_nothing_meanwhile_and_is_late_for_its_next_turn() {
    let mut world = world(1);
    let side = Side::keep(0, 0);
    let speed = ComputerSpeed { turn_ns: (5, 5), wake_ns: 0 };
    let me = world.join(side, 0, speed);
    world.next_turn(None);
    assert_eq!((side.now(), world.now()), (5, 0), "its turn takes time, which is its own");
    side.work(100);
    world.after_turn(me, Some(20));
    world.next_turn(None);
    assert_eq!((world.now(), world.reactions()), (105, 1));
}

#[test]
fn a_clock_shows_its_offset_and_drift_and_a_deadline_is_when_it_shows_it() {
    // The second clock gains a thousandth.
    let (one, other) = (Side::keep(0, 0), Side::keep(500, 1_000_000));
    let begins = one.local();
    let shown = |side: &Side| side.local().since(begins).as_nanos();
    assert_eq!(shown(other), 500);
    for side in [one, other] {
        side.advance_to(1_000_000);
    }
    assert_eq!((shown(one), shown(other)), (1_000_000, 1_001_500));
    let deadline = other.local() + Interval::from_nanos(10_010);
    let at = other.virtual_time(Deadline::At(deadline)).unwrap();
    other.advance_to(at);
    let late = other.local().since(deadline).as_nanos();
    assert!((0..=20).contains(&late), "{late}");
    assert_eq!((other.virtual_time(Deadline::Now), other.virtual_time(Deadline::Never)), (Some(at), None));
}

#[test]
fn threads_of_a_program_act_on_the_way_each_at_its_time() {
    static SEEN: Mutex<Vec<(usize, Instant)>> = Mutex::new(Vec::new());
    let side = Side::keep(0, 0);
    side.advance_to(100);
    let begins = side.physical_time();
    side.start(Thread::new(&[10, 30], move |left| {
        SEEN.lock().unwrap().push((left, side.physical_time()));
        side.wake();
    }));
    assert_eq!(side.next_act(), Some(110));
    side.compute(25);
    assert!(side.take_woken() && !side.take_woken());
    side.end();
    side.compute(25);
    assert_eq!(*SEEN.lock().unwrap(), [(1, begins + Interval::from_nanos(10))], "the program was no more");
}

/// The behavior of a participant.
type Act = Box<dyn FnOnce(&mut Virtual) + Send>;

/// Runs these participants, each with a clock of its own, to their ends.
fn run(threads: &Threads, participants: Vec<Act>) {
    let platforms: Vec<_> = participants.iter().map(|_| threads.join(Interval::ZERO, Interval::ZERO)).collect();
    thread::scope(|scope| {
        for (mut platform, participant) in platforms.into_iter().zip(participants) {
            scope.spawn(move || {
                platform.begin();
                participant(&mut platform);
            });
        }
        threads.start();
    });
}

/// Waits for this long, whatever sockets are ready.
fn pass(platform: &mut Virtual, time: Interval) {
    let until = platform.now() + time;
    while platform.now() < until {
        platform.wait(Deadline::At(until), &mut |_, _| {});
    }
}

/// Repeats the question whenever sockets become ready, until there is an answer.
fn ask<T>(platform: &mut Virtual, mut question: impl FnMut(&mut Virtual) -> Option<T>) -> T {
    loop {
        if let Some(found) = question(platform) {
            return found;
        }
        platform.wait(Deadline::Never, &mut |_, _| {});
    }
}

/// Waits until it is interrupted.
fn wait_for_interruption(platform: &mut Virtual) {
    while !platform.interrupted() {
        platform.wait(Deadline::Never, &mut |_, _| {});
    }
}

#[test]
fn bytes_wake_who_waits_for_them_when_they_have_come() {
    for seed in 0..16 {
        let threads = Threads::new(Conditions { whole: true, ..Conditions::seeded(seed) });
        let server = |platform: &mut Virtual| {
            let listener = platform.listen(PORT).unwrap();
            platform.set_interest(listener, Interest::READ);
            let (socket, _) = ask(platform, |platform| platform.accept(listener).unwrap());
            platform.set_interest(socket, Interest::READ);
            let read = ask(platform, |platform| match platform.read(socket, &mut [0; 9]).unwrap() {
                Transfer::WouldBlock => None,
                other => Some(other),
            });
            assert_eq!(read, Transfer::Bytes(5));
        };
        let client = |platform: &mut Virtual| {
            pass(platform, MS(1));
            let socket = platform.connect(Endpoint::new(address_of(0), PORT)).unwrap();
            platform.set_interest(socket, Interest::WRITE);
            ask(platform, |platform| platform.connected(socket).ok());
            platform.set_interest(socket, Interest::NONE);
            pass(platform, MS(50));
            assert_eq!(platform.write(socket, b"hello"), Ok(Transfer::Bytes(5)));
            pass(platform, MS(1));
        };
        run(&threads, vec![Box::new(server), Box::new(client)]);
        assert_eq!(threads.violation(), None);
        assert!(threads.now() >= MS(52) && threads.now() < MS(53), "{:?}", threads.now());
    }
}

#[test]
fn a_participant_learns_at_once_that_it_is_interrupted_or_killed() {
    let threads = Threads::new(Conditions::seeded(1));
    threads.plan(MS(30), 0, Fault::Interrupt);
    threads.plan(MS(70), 1, Fault::Kill);
    let interrupted = |platform: &mut Virtual| {
        wait_for_interruption(platform);
        assert_eq!(platform.side().now(), 30_000_000);
    };
    let killed = |platform: &mut Virtual| {
        platform.listen(PORT).unwrap();
        wait_for_interruption(platform);
        assert!(platform.listen(PORT).is_err(), "its system is off");
    };
    run(&threads, vec![Box::new(interrupted), Box::new(killed)]);
    assert_eq!((threads.violation(), threads.now()), (None, MS(70)));
}

#[test]
fn a_world_in_which_nothing_happens_or_too_much_interrupts_all() {
    let stuck = Threads::new(Conditions::seeded(1));
    run(&stuck, vec![Box::new(wait_for_interruption), Box::new(|platform| pass(platform, MS(9)))]);
    assert_eq!((stuck.violation(), stuck.now()), (Some(LivenessViolation::Deadlock), MS(9)));
    let busy = Threads::new(Conditions::seeded(1));
    let restless = |platform: &mut Virtual| {
        while !platform.interrupted() {
            platform.wait(Deadline::Now, &mut |_, _| {});
        }
    };
    run(&busy, vec![Box::new(restless)]);
    assert_eq!((busy.violation(), busy.now()), (Some(LivenessViolation::Livelock), Interval::ZERO));
}
