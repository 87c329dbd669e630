// SPDX-License-Identifier: Apache-2.0
//! Timers, actions, ports and delayed connections: what happens at which tag, and in which order.
use crate::bench::{Builder, By, at, bench, entries, timing};
use lf_model::Policy::{Defer, Drop, Replace, Update};
use lf_model::prelude::*;
use lf_model::{ActionTiming, ModelError, after};

#[test]
fn timers_repeat_with_their_period_and_without_one_happen_once() {
    let mut bench = bench()
        .timer(0, 0, 3)
        .timer(1, 6, 0)
        .reaction(0, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "t0"))
        .reaction(0, &[By::Timer(1)], |cells, ctx| cells.log(ctx, "t1"))
        .build();
    assert_eq!(bench.steps(4), [at(0, 0), at(3, 0), at(6, 0), at(9, 0)]);
    let expected = [("t0", 0, 0), ("t0", 3, 0), ("t0", 6, 0), ("t1", 6, 0), ("t0", 9, 0)];
    assert_eq!(bench.log(), entries(&expected));
}

#[test]
fn presence_lasts_for_one_tag() {
    let mut bench = bench()
        .timer(0, 0, 2)
        .timer(1, 0, 4)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            let word = format!("{}{}", ctx.is_present(&cells.timers[0]), ctx.is_present(&cells.timers[1]));
            assert_eq!(ctx.get(&cells.timers[1]).is_some(), ctx.is_present(&cells.timers[1]));
            cells.log(ctx, word);
        })
        .build();
    bench.steps(3);
    assert_eq!(bench.log(), entries(&[("truetrue", 0, 0), ("truefalse", 2, 0), ("truetrue", 4, 0)]));
}

#[test]
fn a_connection_with_an_endless_delay_delivers_nothing() {
    let mut bench = bench()
        .delay(i64::MAX)
        .timer(0, 0, 2)
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.set(&mut cells.ports[0], 1))
        .build();
    // The queue has room for two values.
    assert_eq!(bench.steps(3), [at(0, 0), at(2, 0), at(4, 0)]);
}

#[test]
fn an_action_without_delay_happens_at_the_next_microstep() {
    let mut bench = bench()
        .reaction(0, &[By::Startup, By::Action(0)], |cells, ctx| {
            ctx.schedule(&mut cells.actions[0], Asap);
            assert_tag_is!(ctx, (T0, ctx.get_tag().microstep));
        })
        .build();
    assert_eq!(bench.steps(3), [at(0, 0), at(0, 1), at(0, 2)]);
}

#[test]
fn the_minimum_delay_adds_to_the_offset_and_leads_to_microstep_zero() {
    let mut bench = bench()
        .action(0, timing(100, None, Defer))
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.actions[0], Some(1), Asap);
            ctx.schedule_with_v(&mut cells.actions[0], Some(2), after!(40 ms));
        })
        .reaction(0, &[By::Action(0)], |cells, ctx| cells.log(ctx, ctx.get(&cells.actions[0]).unwrap()))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0), at(100, 0), at(140, 0)]);
    assert_eq!(bench.log(), entries(&[("1", 100, 0), ("2", 140, 0)]));
}

#[test]
fn scheduling_twice_at_one_tag_defers_to_the_next_microstep_and_overwrites_nothing() {
    let mut bench = bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.actions[0], Some(1), after!(2 ms));
            ctx.schedule_with_v(&mut cells.actions[0], Some(2), after!(2 ms));
            ctx.schedule_with_v(&mut cells.actions[0], Some(3), after!(1 ms));
            ctx.schedule(&mut cells.actions[0], after!(2 ms));
        })
        .reaction(0, &[By::Action(0)], |cells, ctx| {
            assert!(ctx.is_present(&cells.actions[0]));
            cells.log(ctx, format!("{:?}", ctx.get(&cells.actions[0])));
        })
        .build();
    bench.steps(9);
    let expected = [("Some(3)", 1, 0), ("Some(1)", 2, 0), ("Some(2)", 2, 1), ("None", 2, 2)];
    assert_eq!(bench.log(), entries(&expected));
}

#[test]
fn scheduling_twice_at_one_tag_can_keep_the_last_value_alone() {
    let mut bench = bench()
        .action(0, timing(0, None, Replace))
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.actions[0], Some(1), after!(2 ms));
            ctx.schedule_with_v(&mut cells.actions[0], Some(2), after!(1 ms));
            ctx.schedule_with_v(&mut cells.actions[0], Some(3), after!(2 ms));
            ctx.schedule_with_v(&mut cells.actions[0], Some(4), after!(3 ms));
        })
        .reaction(0, &[By::Action(0)], |cells, ctx| cells.log(ctx, ctx.get(&cells.actions[0]).unwrap()))
        .build();
    bench.steps(9);
    assert_eq!(bench.log(), entries(&[("2", 1, 0), ("3", 2, 0), ("4", 3, 0)]));
}

/// Schedules values 1, 2, 3 at 0, 1 and 12 ms with minimum delay 5 ms and spacing 10 ms; returns their tags.
fn spaced(timing: ActionTiming) -> Vec<(String, i64, u32)> {
    fn schedule(builder: Builder, index: usize, value: u32) -> Builder {
        builder.reaction(0, &[By::Timer(index)], move |cells, ctx| {
            if ctx.get_elapsed_logical_time() > delay!(5 ms) {
                ctx.schedule_with_v(&mut cells.actions[0], Some(3), Asap);
            } else {
                ctx.schedule_with_v(&mut cells.actions[0], Some(value), Asap);
            }
        })
    }
    let builder = bench().action(0, timing).timer(0, 0, 0).timer(1, 1, 11);
    let mut bench = schedule(schedule(builder, 0, 1), 1, 2)
        .reaction(0, &[By::Action(0)], |cells, ctx| cells.log(ctx, ctx.get(&cells.actions[0]).unwrap()))
        .build();
    while bench.engine.next_tag().unwrap() <= at(22, 0) {
        bench.step();
    }
    bench.log()
}

#[test]
fn minimum_spacing_defers_drops_replaces_or_updates() {
    let policy = |policy| spaced(timing(5, Some(10), policy));
    // 1 is due at 5, 2 at 6, 3 at 17.
    assert_eq!(policy(Defer), entries(&[("1", 5, 0), ("2", 15, 0)]), "and 3 at 25 ms");
    assert_eq!(policy(Drop), entries(&[("1", 5, 0), ("3", 17, 0)]));
    assert_eq!(policy(Replace), entries(&[("2", 5, 0), ("3", 17, 0)]));
    assert_eq!(policy(Update), entries(&[("2", 6, 0), ("3", 17, 0)]));
    assert_eq!(spaced(timing(5, None, Drop)), entries(&[("1", 5, 0), ("2", 6, 0), ("3", 17, 0)]));
}

#[test]
fn reactions_run_by_level_and_the_last_writer_of_a_port_counts() {
    let mut bench = bench()
        .reaction(2, &[By::Port(0), By::Port(1)], |cells, ctx| {
            cells.log(ctx, format!("{:?}{:?}", ctx.get(&cells.ports[0]), ctx.get(&cells.ports[1])));
        })
        .reaction(1, &[By::Port(0)], |cells, ctx| {
            let value = ctx.get(&cells.ports[0]).unwrap();
            ctx.set(&mut cells.ports[1], value + 1);
            ctx.set(&mut cells.ports[1], value + 2);
        })
        .timer(0, 0, 5)
        .reaction(0, &[By::Startup], |cells, ctx| ctx.set(&mut cells.ports[0], 10))
        .reaction(0, &[By::Startup], |cells, ctx| ctx.set_opt(&mut cells.ports[0], Some(20)))
        .reaction(3, &[By::Timer(0)], |cells, ctx| cells.log(ctx, ctx.is_present(&cells.ports[0])))
        .build();
    assert_eq!(bench.steps(3), [at(0, 0), at(0, 1), at(5, 0)]);
    let expected = [("Some(20)Some(22)", 0, 0), ("true", 0, 0), ("false", 5, 0)];
    assert_eq!(bench.log(), entries(&expected), "values are gone after the tag");
}

#[test]
fn a_connection_delayed_by_zero_arrives_a_microstep_later() {
    let mut bench = bench()
        .delay(0)
        .reaction(0, &[By::Startup], |cells, ctx| ctx.set(&mut cells.ports[0], 7))
        .reaction(1, &[By::Delayed], |cells, ctx| {
            let value = ctx.get(&cells.delayed.port).unwrap();
            cells.log(ctx, value);
            ctx.set(&mut cells.ports[0], value + 1);
        })
        .build();
    bench.steps(3);
    assert_eq!(bench.log(), entries(&[("7", 0, 1), ("8", 0, 2)]));
}

#[test]
fn values_that_a_delay_brings_to_one_tag_arrive_at_following_microsteps() {
    let mut bench = bench()
        .delay(5)
        .reaction(0, &[By::Startup, By::Action(0)], |cells, ctx| {
            let step = ctx.get_tag().microstep;
            ctx.set(&mut cells.ports[0], step);
            if step == 0 {
                ctx.schedule(&mut cells.actions[0], Asap);
            }
        })
        .reaction(1, &[By::Delayed], |cells, ctx| cells.log(ctx, ctx.get(&cells.delayed.port).unwrap()))
        .build();
    bench.steps(9);
    assert_eq!(bench.log(), entries(&[("0", 5, 0), ("1", 5, 1)]));
}

#[test]
fn a_thread_that_cannot_be_had_ends_the_program_after_the_reaction_with_the_first_error() {
    let mut bench = bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.fail(ModelError::NoThreadLeft { threads: 1 });
            ctx.fail(ModelError::NoThreadLeft { threads: 2 });
            cells.log(ctx, "the body goes on");
        })
        .build();
    let error = bench.failure();
    assert_eq!(error, ModelError::NoThreadLeft { threads: 1 });
    assert_eq!(
        error.to_string(),
        "spawn_physical_thread was called while all of the image's threads (1) were running: raise n in the target \
         property `platform: {user-threads: n}`, or set CONFIG_LF_USER_THREADS"
    );
    assert_eq!(bench.log(), entries(&[("the body goes on", 0, 0)]));
    assert!(bench.engine.is_done() && bench.engine.next_tag().is_none());
}

#[test]
fn a_full_action_ends_the_program_with_its_name_and_what_to_do() {
    let mut bench = bench()
        .timer(0, 0, 1)
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.schedule(&mut cells.actions[1], after!(1 sec)))
        .build();
    let error = bench.failure();
    assert_eq!(error, ModelError::ActionFull { action: "bench.a1", capacity: 4 });
    assert_eq!(
        error.to_string(),
        "action bench.a1 was scheduled while it held 4 pending events, which is all it has room for: \
         write @capacity(n) with a larger n before its declaration, or schedule it less often"
    );
    assert!(bench.engine.is_done() && bench.engine.next_tag().is_none());
}

#[test]
fn a_full_delayed_connection_ends_the_program_with_its_name() {
    let mut bench = bench()
        .delay(10)
        .timer(0, 0, 1)
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.set(&mut cells.ports[0], 1))
        .build();
    assert_eq!(bench.failure(), ModelError::DelayFull { connection: "bench.p3", capacity: 2 });
}

#[test]
fn an_event_scheduled_at_forever_never_happens_and_takes_no_room() {
    let mut bench = bench()
        .timer(0, 0, 1)
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.schedule(&mut cells.actions[0], After(Duration::MAX)))
        .build();
    assert_eq!(bench.steps(9).len(), 9);
}

#[test]
fn an_action_is_present_at_its_tag_only() {
    let mut bench = bench()
        .timer(0, 5, 5)
        .physical(timing(0, None, Defer))
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.schedule_with_v(&mut cells.actions[0], Some(7), after!(1 ms));
            let physical = cells.physical.clone();
            ctx.schedule_physical_with_v(&physical, Some(8), after!(2 ms)).unwrap();
        })
        .reaction(1, &[By::Action(0), By::Physical, By::Timer(0)], |cells, ctx| {
            let present = (ctx.is_present(&cells.actions[0]), ctx.is_present(&cells.physical));
            let values = (ctx.get(&cells.actions[0]), ctx.get(&cells.physical));
            cells.log(ctx, format!("{present:?} {values:?}"));
        })
        .build();
    bench.steps(4);
    let expected = [
        ("(true, false) (Some(7), None)", 1, 0),
        ("(false, true) (None, Some(8))", 2, 0),
        ("(false, false) (None, None)", 5, 0),
    ];
    assert_eq!(bench.log(), entries(&expected));
}
