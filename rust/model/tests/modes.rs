// SPDX-License-Identifier: Apache-2.0
//! Modes: what is active, what stands still meanwhile, and what is dropped.
use crate::bench::{Builder, By, Cells, at, bench, entries, timing};
use lf_model::prelude::*;
use lf_model::{Interval, ModeId, Policy, Settings, Transition};

const RESET: fn(u16) -> Transition = |mode| Transition::reset(ModeId(mode));
const HISTORY: fn(u16) -> Transition = |mode| Transition::history(ModeId(mode));

/// Two modes, 0 and 1, of one instance, and a timer 0 outside of them that changes from one to the other.
fn two_modes(period: i64, to_one: Transition, to_zero: Transition) -> Builder {
    bench()
        .modes(&[(0, None, true), (0, None, false)])
        .timer(0, period, period)
        .reaction(0, &[By::Timer(0)], move |_, ctx| ctx.set_mode(to_one))
        .in_mode(0)
        .reaction(0, &[By::Timer(0)], move |_, ctx| ctx.set_mode(to_zero))
        .in_mode(1)
}

#[test]
fn reactions_of_the_active_mode_run_and_a_change_takes_effect_a_microstep_later() {
    let mut bench = two_modes(10, RESET(1), RESET(0))
        .reaction(1, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "zero"))
        .in_mode(0)
        .reaction(1, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "one"))
        .in_mode(1)
        .reaction(1, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "always"))
        .reaction(2, &[By::Reset], |cells, ctx| cells.log(ctx, "reset one"))
        .in_mode(1)
        .build();
    assert_eq!(bench.steps(4), [at(0, 0), at(10, 0), at(10, 1), at(20, 0)]);
    assert_eq!(bench.engine.next_tag(), Some(at(30, 0)), "nothing is to run where mode 0 is entered");
    let expected = [("zero", 10, 0), ("always", 10, 0), ("reset one", 10, 1), ("one", 20, 0), ("always", 20, 0)];
    assert_eq!(bench.log(), entries(&expected));
    assert_eq!(bench.program.cells.resets, [1, 0]);
}

#[test]
fn the_last_mode_that_is_set_at_a_tag_counts() {
    let mut bench = bench()
        .modes(&[(0, None, true), (0, None, false), (0, None, false)])
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |_, ctx| {
            ctx.set_mode(RESET(1));
            ctx.set_mode(HISTORY(2));
        })
        .in_mode(0)
        .reaction(1, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "one"))
        .in_mode(1)
        .reaction(1, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "two"))
        .in_mode(2)
        .build();
    bench.steps(2);
    assert_eq!(bench.log(), entries(&[("two", 10, 0)]));
    assert!(bench.program.cells.resets.is_empty(), "two is entered by history");
}

/// Returns a program in which the timer, the action and the delayed connection of mode 0 each have an event 7 ms, or a
/// microstep, ahead.
fn with_events(to_zero: Transition) -> Builder {
    two_modes(10, HISTORY(1), to_zero)
        .timer(1, 17, 100)
        .trigger_in(3, 0)
        .action(0, timing(7, None, Policy::Defer))
        .trigger_in(4, 0)
        .trigger_in(5, 0)
        .delay(7)
        .trigger_in(7, 0)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.actions[0], Some(3), Asap);
            ctx.schedule(&mut cells.actions[1], Asap);
            ctx.set(&mut cells.ports[0], 4);
        })
        .in_mode(0)
        .reaction(1, &[By::Timer(1)], |cells, ctx| cells.log(ctx, "timer"))
        .in_mode(0)
        .reaction(1, &[By::Action(0)], |cells, ctx| cells.log(ctx, ctx.get(&cells.actions[0]).unwrap()))
        .in_mode(0)
        .reaction(1, &[By::Action(1)], |cells, ctx| cells.log(ctx, "at once"))
        .in_mode(0)
        .reaction(1, &[By::Delayed], |cells, ctx| cells.log(ctx, ctx.get(&cells.delayed.port).unwrap()))
        .in_mode(0)
}

#[test]
fn events_of_a_mode_wait_while_it_is_not_active() {
    let mut bench = with_events(HISTORY(0)).build();
    assert_eq!(bench.steps(5), [at(0, 0), at(10, 0), at(20, 0), at(20, 1), at(27, 0)]);
    let expected = [("at once", 20, 1), ("timer", 27, 0), ("3", 27, 0), ("4", 27, 0)];
    assert_eq!(bench.log(), entries(&expected));
    assert_eq!(bench.engine.next_tag(), Some(at(30, 0)));
}

#[test]
fn reset_drops_events_and_lets_timers_begin_again() {
    let mut bench = with_events(RESET(0)).build();
    assert_eq!(bench.steps(4), [at(0, 0), at(10, 0), at(20, 0), at(30, 0)]);
    assert_eq!(bench.engine.next_tag(), Some(at(40, 0)), "the action and the connection of this round wait again");
    assert_eq!(bench.log(), []);
    let mut bench = with_events(RESET(0)).timer(0, 10, 10).timer(1, 3, 0).build();
    bench.steps(5);
    assert_eq!(bench.log(), entries(&[("timer", 3, 0), ("timer", 23, 0)]));
}

#[test]
fn a_timer_at_the_tag_of_its_mode_comes_a_microstep_later() {
    let timer = |to_one| {
        two_modes(10, to_one, HISTORY(0))
            .timer(1, 0, 4)
            .trigger_in(3, 1)
            .reaction(1, &[By::Timer(1)], |cells, ctx| cells.log(ctx, "timer"))
            .in_mode(1)
            .build()
    };
    for transition in [RESET(1), HISTORY(1)] {
        let mut bench = timer(transition);
        bench.steps(5);
        assert_eq!(bench.log(), entries(&[("timer", 10, 1), ("timer", 14, 0), ("timer", 18, 0)]));
    }
}

/// Runs a watchdog of 15 ms in mode 0, which is left 10 ms after the watchdog's start, and entered again at 20 ms.
fn with_watchdog(to_zero: Transition) -> Vec<(String, i64, u32)> {
    let mut bench = two_modes(10, RESET(1), to_zero)
        .watchdog(15)
        .trigger_in(9, 0)
        .reaction(0, &[By::Startup], |cells, ctx| ctx.start_watchdog(&mut cells.watchdog, Duration::ZERO))
        .in_mode(0)
        .reaction(1, &[By::Watchdog], |cells, ctx| cells.log(ctx, "expired"))
        .in_mode(0)
        .build();
    bench.steps(6);
    bench.log()
}

#[test]
fn a_watchdog_stands_still_with_its_mode_and_a_reset_stops_it() {
    assert_eq!(with_watchdog(HISTORY(0)), entries(&[("expired", 25, 0)]));
    assert_eq!(with_watchdog(RESET(0)), []);
}

#[test]
fn the_spacing_of_an_action_is_one_of_its_modes_time() {
    let mut bench = two_modes(10, HISTORY(1), HISTORY(0))
        .action(0, timing(0, Some(15), Policy::Defer))
        .trigger_in(4, 0)
        .reaction(0, &[By::Startup, By::Timer(0)], |cells, ctx| ctx.schedule(&mut cells.actions[0], Asap))
        .in_mode(0)
        .reaction(1, &[By::Action(0)], |cells, ctx| cells.log(ctx, "action"))
        .in_mode(0)
        .build();
    bench.steps(6);
    // At 10 ms, one is put off until 15 ms; the mode stands still from 10 ms to 20 ms.
    assert_eq!(bench.log(), entries(&[("action", 0, 1), ("action", 25, 0)]));
}

#[test]
fn events_that_threads_schedule_for_an_inactive_mode_do_not_happen() {
    let mut bench = two_modes(10, HISTORY(1), HISTORY(0))
        .timer(1, 8, 10)
        .physical(timing(5, None, Policy::Defer))
        .trigger_in(6, 0)
        .reaction(1, &[By::Timer(1)], |cells, ctx| {
            let (value, act) = (ctx.get_elapsed_logical_time().as_millis(), cells.physical.clone());
            ctx.schedule_physical_with_v(&act, u32::try_from(value).ok(), Asap).unwrap();
        })
        .reaction(1, &[By::Physical], |cells, ctx| cells.log(ctx, ctx.get(&cells.physical).unwrap()))
        .in_mode(0)
        .build();
    bench.steps(11);
    assert_eq!(bench.log(), entries(&[("8", 23, 0), ("28", 43, 0)]));
}

#[test]
fn a_reset_drops_the_events_of_a_physical_action() {
    let scheduled = |to_zero| {
        let mut bench = two_modes(10, HISTORY(1), to_zero)
            .physical(timing(15, None, Policy::Defer))
            .trigger_in(6, 0)
            .reaction(1, &[By::Startup], |cells, ctx| ctx.schedule(&mut cells.physical, Asap))
            .reaction(1, &[By::Physical], |cells, ctx| cells.log(ctx, "action"))
            .in_mode(0)
            .build();
        bench.steps(6);
        bench.log()
    };
    assert_eq!(scheduled(HISTORY(0)), entries(&[("action", 25, 0)]));
    assert_eq!(scheduled(RESET(0)), []);
}

#[test]
fn startup_comes_once_per_mode_and_shutdown_where_it_came() {
    let settings = Settings { timeout: Some(Interval::from_millis(50)), ..Settings::DEFAULT };
    let mut bench = bench()
        .settings(settings)
        .modes(&[(0, None, true), (0, None, false), (0, None, false)])
        .timer(0, 10, 10)
        .reaction(0, &[By::Timer(0)], |_, ctx| ctx.set_mode(HISTORY(1)))
        .in_mode(0)
        .reaction(0, &[By::Timer(0)], |_, ctx| ctx.set_mode(HISTORY(0)))
        .in_mode(1);
    for (mode, names) in ["zero", "one", "two"].into_iter().enumerate() {
        let mode = u16::try_from(mode).unwrap();
        bench = bench
            .reaction(1, &[By::Startup], move |cells, ctx| cells.log(ctx, format!("startup {names}")))
            .in_mode(mode)
            .reaction(1, &[By::Shutdown], move |cells, ctx| cells.log(ctx, format!("shutdown {names}")))
            .in_mode(mode);
    }
    let mut bench = bench.build();
    bench.steps(10);
    let expected = [("startup zero", 0, 0), ("startup one", 10, 1), ("shutdown zero", 50, 0), ("shutdown one", 50, 0)];
    assert_eq!(bench.log(), entries(&expected));
    assert!(bench.engine.is_done());
}

/// Modes 0 and 1 contain nothing but another instance in mode 0, which has modes 2 and 3.
fn nested(inner: Transition, to_one: Transition, to_zero: Transition) -> Builder {
    bench()
        .modes(&[(0, None, true), (0, None, false), (1, Some(0), true), (1, Some(0), false)])
        .timer(0, 10, 10)
        .reaction(0, &[By::Timer(0)], move |_, ctx| ctx.set_mode(to_one))
        .in_mode(0)
        .reaction(0, &[By::Timer(0)], move |_, ctx| ctx.set_mode(to_zero))
        .in_mode(1)
        .reaction(0, &[By::Timer(0)], move |_, ctx| ctx.set_mode(inner))
        .in_mode(2)
        .timer(1, 4, 100)
        .trigger_in(3, 3)
        .reaction(1, &[By::Timer(1)], |cells, ctx| cells.log(ctx, "timer"))
        .in_mode(3)
        .reaction(1, &[By::Reset], |cells, ctx| cells.log(ctx, "reset"))
        .in_mode(3)
        .reaction(1, &[By::Startup], |cells, ctx| cells.log(ctx, "startup"))
        .in_mode(3)
}

#[test]
fn a_mode_entered_inside_one_that_is_left_waits_with_it() {
    let mut bench = nested(RESET(3), HISTORY(1), HISTORY(0)).build();
    bench.steps(5);
    let expected = [("reset", 20, 1), ("startup", 20, 1), ("timer", 24, 0)];
    assert_eq!(bench.log(), entries(&expected));
}

#[test]
fn a_reset_reaches_what_is_contained_and_takes_it_to_its_initial_mode() {
    let mut bench = nested(RESET(3), HISTORY(1), RESET(0)).build();
    bench.steps(9);
    assert_eq!(bench.log(), [], "mode 3 is never active");
    assert_eq!(bench.program.cells.resets, [3, 0, 2, 3, 0, 2, 3, 0, 2, 3, 0, 2]);
}

#[test]
fn a_change_at_the_last_tag_does_not_happen() {
    let settings = Settings { timeout: Some(Interval::from_millis(10)), ..Settings::DEFAULT };
    let mut bench = two_modes(10, RESET(1), RESET(0)).settings(settings).build();
    assert_eq!(bench.steps(5), [at(0, 0), at(10, 0)]);
    assert!(bench.program.cells.resets.is_empty());
}

/// The first of two reactors changes its mode every 10 ms; the second one is in mode 3 from 20 ms to 50 ms.
#[test]
fn a_change_of_one_reactors_mode_leaves_those_of_another_one_as_they_are() {
    let settings = Settings { timeout: Some(Interval::from_millis(60)), ..Settings::DEFAULT };
    let at_ms = |ms: u128, mode| {
        move |_: &mut Cells, ctx: &mut ReactionContext<'_>| {
            if ctx.get_elapsed_logical_time().as_millis() == ms {
                ctx.set_mode(HISTORY(mode));
            }
        }
    };
    let log = |word: &'static str| move |cells: &mut Cells, ctx: &mut ReactionContext<'_>| cells.log(ctx, word);
    let mut bench = bench()
        .settings(settings)
        .modes(&[(0, None, true), (0, None, false), (1, None, true), (1, None, false)])
        .timer(0, 10, 10)
        .timer(1, 25, 100)
        .trigger_in(3, 2)
        .reaction(0, &[By::Timer(0)], |_, ctx| ctx.set_mode(HISTORY(1)))
        .in_mode(0)
        .reaction(0, &[By::Timer(0)], |_, ctx| ctx.set_mode(HISTORY(0)))
        .in_mode(1)
        .reaction(0, &[By::Startup], log("startup of 0"))
        .in_mode(0)
        .reaction(0, &[By::Timer(0)], at_ms(20, 3))
        .in_mode(2)
        .reaction(0, &[By::Timer(0)], at_ms(50, 2))
        .in_mode(3)
        .reaction(1, &[By::Startup], log("startup of 3"))
        .in_mode(3)
        .reaction(1, &[By::Timer(0)], log("mode 3"))
        .in_mode(3)
        .reaction(1, &[By::Reset], log("reset"))
        .in_mode(2)
        .reaction(1, &[By::Timer(1)], log("timer"))
        .in_mode(2)
        .build();
    bench.steps(20);
    let expected = [
        ("startup of 0", 0, 0),
        ("startup of 3", 20, 1),
        ("mode 3", 30, 0),
        ("mode 3", 40, 0),
        ("mode 3", 50, 0),
        // It had 5 ms left when its mode was left.
        ("timer", 55, 0),
    ];
    assert_eq!(bench.log(), entries(&expected));
    assert!(bench.engine.is_done(), "at the last tag, mode 3 has been left");
}
