// SPDX-License-Identifier: Apache-2.0
//! Physical actions from other threads, and deadlines.
use crate::bench::{Bench, Builder, By, START, at, bench, entries, timing};
use lf_model::prelude::*;
use lf_model::{
    Env, Instant, Interval, Outgoing, Outside, Part, Policy, Progress, ReactionId, ReactionStep, ScheduleError,
    SendError, Settings,
};
use lf_testkit::host::Clock;

thread_local! {
    static LINK: std::cell::RefCell<Option<(PhysicalLink, PhysicalActionRef<u32>)>> =
        const { std::cell::RefCell::new(None) };
}

/// Returns a program whose startup hands a link and the physical action out, as to a thread, and that logs the action.
fn with_link() -> Builder {
    bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            let act = cells.physical.clone();
            LINK.set(Some((ctx.physical_link(), act)));
        })
        .reaction(1, &[By::Physical], |cells, ctx| cells.log(ctx, format!("{:?}", ctx.get(&cells.physical))))
}

/// Posts a value at a physical time in ms, as a thread does.
fn post(bench: &Bench, ms: i64, value: u32, offset: Offset) -> Result<(), ScheduleError> {
    bench.clock.set(START + Interval::from_millis(ms));
    LINK.with_borrow(|link| {
        let (link, act) = link.as_ref().unwrap();
        link.schedule_physical_with_v(act, Some(value), offset)
    })
}

#[test]
fn a_physical_event_happens_at_its_physical_time_and_wakes_the_event_loop() {
    let mut bench = with_link().timer(0, 0, 20).build();
    bench.steps(1);
    let wakes = bench.clock.wakes();
    post(&bench, 7, 1, Asap).unwrap();
    post(&bench, 8, 2, after!(10 ms)).unwrap();
    assert_eq!(bench.clock.wakes(), wakes + 2);
    assert_eq!(bench.engine.next_tag(), Some(at(20, 0)), "it is not seen before it is drained");
    assert_eq!(bench.steps(3), [at(7, 0), at(18, 0), at(20, 0)]);
    assert_eq!(bench.log(), entries(&[("Some(1)", 7, 0), ("Some(2)", 18, 0)]));
    LINK.set(None);
}

/// A physical connection inside a federate: the delay counts from physical time, not from the tag.
#[test]
fn a_physical_connection_delays_from_physical_time() {
    let mut bench = bench()
        .physical_connections()
        .delay(5)
        .timer(0, 0, 0)
        .timer(1, 40, 0)
        .reaction(0, &[By::Timer(0), By::Timer(1)], |cells, ctx| ctx.set(&mut cells.ports[0], 1))
        .reaction(1, &[By::Delayed], |cells, ctx| cells.log(ctx, ctx.get(&cells.delayed.port).unwrap()))
        .build();
    let mut run = |tag, physical_ms| {
        bench.clock.set(START + Interval::from_millis(physical_ms));
        bench.engine.begin(&mut bench.program, tag).unwrap();
        assert_eq!(bench.engine.advance(&mut bench.program, &mut bench.host, None), Progress::Complete);
        bench.engine.next_tag()
    };
    assert_eq!(run(at(0, 0), 20), Some(at(25, 0)));
    assert_eq!(run(at(25, 0), 25), Some(at(40, 0)));
    // Physical time is behind: never at a tag that has begun.
    assert_eq!(run(at(40, 0), 30), Some(at(40, 1)));
    assert_eq!(run(at(40, 1), 31), None);
    assert_eq!(bench.log(), entries(&[("1", 25, 0), ("1", 40, 1)]));
}

/// A recording has what came from outside at a tag that begins, and nothing else.
#[test]
fn what_comes_from_outside_is_told_when_its_tag_begins() {
    let mut bench = bench()
        .physical_connections()
        .delay(5)
        .timer(0, 0, 0)
        .reaction(0, &[By::Startup], |cells, ctx| {
            LINK.set(Some((ctx.physical_link(), cells.physical.clone())));
        })
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.set(&mut cells.ports[0], 258))
        .reaction(1, &[By::Delayed, By::Physical], |_, _| {})
        .build();
    let told = |bench: &mut Bench| {
        let mut told = Vec::new();
        bench.engine.physical_events(&mut bench.program, &mut |trigger, encode| {
            told.push((trigger.0, encode(&mut [0; 8]).map(Result::unwrap)));
        });
        told
    };
    bench.begin(at(0, 0));
    assert_eq!(told(&mut bench), [], "timers and startup come from within");
    assert_eq!(bench.advance(), Progress::Complete);
    let connected = bench.engine.next_tag().unwrap();
    post(&bench, 2, 7, Asap).unwrap();
    bench.engine.drain_physical(&mut bench.program, &bench.host);
    bench.begin(at(2, 0));
    assert_eq!(told(&mut bench), [(6, None)], "the cells of a bench do not tell their values");
    assert_eq!(bench.advance(), Progress::Complete);
    bench.begin(connected);
    assert_eq!(told(&mut bench), [(7, None)]);
    LINK.set(None);
}

/// An environment of one program that keeps the steps of its reactions.
struct Watching {
    clock: &'static Clock,
    steps: Vec<ReactionStep>,
}

impl Env for Watching {
    fn outside(&self) -> &'static dyn Outside {
        self.clock
    }
    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        Ok(())
    }
    fn step(&mut self, step: ReactionStep, _worker: Option<(u16, Instant)>) {
        self.steps.push(step);
    }
}

/// The environment receives the begin and the end of each reaction if it records steps.
#[test]
fn steps_of_reactions_are_recorded_on_demand() {
    let steps = |record| {
        let mut bench = bench()
            .reaction(0, &[By::Startup], |cells, ctx| ctx.set(&mut cells.ports[0], 1))
            .reaction(1, &[By::Port(0)], |_, _| {})
            .build();
        let mut watching = Watching { clock: bench.clock, steps: Vec::new() };
        bench.engine.record_steps(record);
        bench.begin(at(0, 0));
        assert_eq!(bench.engine.advance(&mut bench.program, &mut watching, None), Progress::Complete);
        watching.steps
    };
    let of = |reaction| {
        let id = ReactionId(reaction);
        [ReactionStep::Begins(id, Part::Body), ReactionStep::Ends(id)]
    };
    assert_eq!(steps(true), [of(0), of(1)].concat());
    assert_eq!(steps(false), []);
}

/// Bodies see the clock as it is, and the start as it was.
#[test]
fn bodies_read_physical_time() {
    let mut bench = bench()
        .timer(0, 10, 0)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            let (start, now) = (ctx.get_start_time(), ctx.get_physical_time());
            cells.log(ctx, format!("{} {}", (now - start).as_nanos(), ctx.get_elapsed_physical_time().as_nanos()));
        })
        .build();
    assert_eq!(bench.engine.start_time(), START);
    bench.steps(1);
    bench.begin(at(10, 0));
    bench.clock.set(START + Interval::from_millis(12));
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!(bench.log(), entries(&[("12000000 12000000", 10, 0)]));
}

/// An interrupt posts at the time that it has noted; the program does not wait for posters.
#[test]
fn a_poster_schedules_now_or_at_the_time_of_another_clock() {
    let mut bench = with_link().build();
    bench.steps(1);
    bench.clock.set(START + Interval::from_millis(4));
    let poster = LINK.with_borrow(|link| link.as_ref().map(|(link, act)| link.poster(act))).unwrap();
    LINK.with_borrow(|link| {
        let (link, act) = link.as_ref().unwrap();
        link.schedule_physical(act, Asap).unwrap();
    });
    bench.clock.set(START + Interval::from_millis(5));
    poster.clone().post(Some(1)).unwrap();
    let earlier = Clock::new_static((START + Interval::from_millis(3)).as_nanos());
    poster.post_by(earlier, Some(2)).unwrap();
    assert_eq!(bench.steps(9), [at(3, 0), at(4, 0), at(5, 0)]);
    assert_eq!(bench.log(), entries(&[("Some(2)", 3, 0), ("None", 4, 0), ("Some(1)", 5, 0)]));
    LINK.set(None);
    assert!(bench.engine.stop_if_idle(&bench.host));
}

#[test]
fn the_minimum_delay_counts_from_physical_time_and_spacing_holds() {
    let mut bench = with_link().physical(timing(5, Some(10), Policy::Drop)).build();
    bench.steps(1);
    for (ms, value) in [(2, 1), (4, 2), (13, 3)] {
        post(&bench, ms, value, Asap).unwrap();
    }
    assert_eq!(bench.steps(9), [at(7, 0), at(18, 0)]);
    assert_eq!(bench.log(), entries(&[("Some(1)", 7, 0), ("Some(3)", 18, 0)]));
    LINK.set(None);
}

#[test]
fn an_event_for_a_time_that_has_passed_happens_at_the_next_microstep() {
    // As with `fast`, where logical time runs ahead of physical time.
    let mut bench = with_link().timer(0, 0, 50).build();
    assert_eq!(bench.steps(2), [at(0, 0), at(50, 0)]);
    post(&bench, 3, 1, Asap).unwrap();
    post(&bench, 4, 2, Asap).unwrap();
    bench.steps(2);
    assert_eq!(bench.log(), entries(&[("Some(1)", 50, 1), ("Some(2)", 50, 2)]));
    LINK.set(None);
}

#[test]
fn a_burst_waits_in_the_inbox_and_one_too_large_is_told_to_its_thread() {
    let mut bench = with_link().build();
    bench.steps(1);
    // Four fit into the inbox; three of them into the queue at once.
    for value in 0..4 {
        post(&bench, 5, value, Asap).unwrap();
    }
    let error = post(&bench, 5, 9, Asap).unwrap_err();
    assert_eq!(error, ScheduleError { capacity: 4 });
    assert!(error.to_string().contains("write @capacity(n) with a larger n"), "{error}");
    bench.steps(9);
    let expected = [("Some(0)", 5, 0), ("Some(1)", 5, 1), ("Some(2)", 5, 2), ("Some(3)", 5, 3)];
    assert_eq!(bench.log(), entries(&expected));
    LINK.set(None);
}

#[test]
fn reactions_schedule_physical_actions_too() {
    let mut bench = bench()
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.physical, Some(1), after!(3 ms));
            ctx.schedule_physical(&cells.physical, after!(4 ms)).unwrap();
        })
        .reaction(1, &[By::Physical], |cells, ctx| cells.log(ctx, format!("{:?}", ctx.get(&cells.physical))))
        .build();
    // Between the tag's time and the reaction, 2 ms go by.
    bench.engine.begin(&mut bench.program, at(0, 0)).unwrap();
    bench.clock.set(START + Interval::from_millis(2));
    bench.advance();
    assert_eq!(bench.steps(2), [at(5, 0), at(6, 0)]);
    assert_eq!(bench.log(), entries(&[("Some(1)", 5, 0), ("None", 6, 0)]));
}

#[test]
fn a_thread_can_ask_for_a_stop_at_its_physical_time() {
    let stop = |bench: &Bench, ms| {
        bench.clock.set(START + Interval::from_millis(ms));
        LINK.with_borrow(|link| link.as_ref().unwrap().0.request_stop(after!(2 ms)));
    };
    let mut alone = with_link().timer(0, 0, 100).build();
    alone.steps(1);
    stop(&alone, 140);
    stop(&alone, 141);
    assert_eq!(alone.steps(9), [at(100, 0), at(142, 0)]);

    let mut federated = with_link().settings(Settings { federated: true, ..Settings::DEFAULT }).build();
    federated.steps(1);
    stop(&federated, 30);
    federated.engine.drain_physical(&mut federated.program, &federated.host);
    assert_eq!(federated.engine.take_stop_request(), Some(at(32, 0)));
    LINK.set(None);
}

#[test]
fn a_link_knows_the_time() {
    let mut bench = with_link().build();
    bench.steps(1);
    post(&bench, 12, 0, Asap).unwrap();
    LINK.with_borrow(|link| {
        let (link, _) = link.as_ref().unwrap();
        assert_eq!(link.get_start_time(), START);
        assert_eq!(link.get_physical_time() - link.get_start_time(), delay!(12 ms));
        assert_eq!(link.get_elapsed_physical_time(), delay!(12 ms));
    });
    LINK.set(None);
}

/// Runs a reaction with a deadline that begins this many nanoseconds after its tag.
fn with_deadline(deadline_ms: i64, lag_ns: i64) -> Vec<(String, i64, u32)> {
    let mut bench = bench()
        .timer(0, 10, 0)
        .reaction(0, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "body"))
        .deadline(deadline_ms, |cells, ctx| {
            assert!(ctx.get_elapsed_physical_time() >= ctx.get_elapsed_logical_time());
            cells.log(ctx, "handler");
        })
        .build();
    bench.steps(1);
    bench.engine.begin(&mut bench.program, at(10, 0)).unwrap();
    bench.clock.set(at(10, 0).time + Interval::from_nanos(lag_ns));
    bench.advance();
    bench.log()
}

#[test]
fn a_missed_deadline_runs_the_handler_in_place_of_the_body() {
    assert_eq!(with_deadline(5, 5_000_000), entries(&[("body", 10, 0)]), "just in time");
    assert_eq!(with_deadline(5, 5_000_001), entries(&[("handler", 10, 0)]));
    assert_eq!(with_deadline(0, 0), entries(&[("handler", 10, 0)]), "a deadline of zero is always missed");
}

#[test]
fn a_deadline_is_checked_when_its_reaction_begins() {
    let mut bench = bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.set(&mut cells.ports[2], 1);
            // The reaction before takes its time.
            CLOCK.with(|clock| clock.get().unwrap().set(START + Interval::from_millis(9)));
        })
        .reaction(1, &[By::Port(2)], |cells, ctx| cells.log(ctx, "body"))
        .deadline(5, |cells, ctx| cells.log(ctx, "handler"))
        .build();
    CLOCK.set(Some(bench.clock));
    bench.steps(1);
    assert_eq!(bench.log(), entries(&[("handler", 0, 0)]));
}

thread_local! {
    static CLOCK: std::cell::Cell<Option<&'static lf_testkit::host::Clock>> = const { std::cell::Cell::new(None) };
}
