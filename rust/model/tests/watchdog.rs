// SPDX-License-Identifier: Apache-2.0
//! Watchdogs: when they expire, and what keeps them from it.
use crate::bench::{Builder, By, at, bench, entries};
use lf_model::prelude::*;

/// Returns a program with a watchdog of 10 ms that logs when it expires.
fn watched() -> Builder {
    bench().watchdog(10).reaction(1, &[By::Watchdog], |cells, ctx| {
        assert!(ctx.is_present(&cells.watchdog) && ctx.get(&cells.watchdog).is_some());
        cells.log(ctx, "expired");
    })
}

#[test]
fn a_watchdog_expires_after_its_timeout_and_what_is_added_to_it() {
    for (additional, expires) in [(delay!(0), 10), (delay!(5 ms), 15)] {
        let start = move |cells: &mut crate::bench::Cells, ctx: &mut ReactionContext<'_>| {
            ctx.start_watchdog(&mut cells.watchdog, additional);
        };
        let mut bench = watched().reaction(0, &[By::Startup], start).build();
        assert_eq!(bench.steps(9), [at(0, 0), at(expires, 0)], "it runs once until a reaction starts it again");
        assert_eq!(bench.log(), entries(&[("expired", expires, 0)]));
    }
}

#[test]
fn starting_a_watchdog_again_replaces_its_event() {
    let mut bench = watched()
        .timer(0, 0, 4)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            assert!(!ctx.is_present(&cells.watchdog));
            if ctx.get_tag() <= tag!(T0 + 8 ms) {
                ctx.start_watchdog(&mut cells.watchdog, delay!(0));
                ctx.start_watchdog(&mut cells.watchdog, delay!(1 ms));
            }
        })
        .build();
    bench.steps(8);
    assert_eq!(bench.log(), entries(&[("expired", 19, 0)]));
}

#[test]
fn a_watchdog_that_is_stopped_does_not_expire() {
    let mut bench = watched()
        .timer(0, 0, 7)
        .reaction(0, &[By::Timer(0)], |cells, ctx| match ctx.get_tag() {
            tag if tag == tag!(T0) => ctx.start_watchdog(&mut cells.watchdog, delay!(0)),
            _ => ctx.stop_watchdog(&mut cells.watchdog),
        })
        .build();
    assert_eq!(bench.steps(4), [at(0, 0), at(7, 0), at(14, 0), at(21, 0)]);
    assert_eq!(bench.log(), []);
}

#[test]
fn a_watchdog_can_be_started_where_it_expires() {
    let mut bench = watched()
        .reaction(0, &[By::Startup, By::Watchdog], |cells, ctx| ctx.start_watchdog(&mut cells.watchdog, delay!(0)))
        .build();
    bench.steps(4);
    assert_eq!(bench.log(), entries(&[("expired", 10, 0), ("expired", 20, 0), ("expired", 30, 0)]));
}

#[test]
fn a_restart_at_the_tag_of_expiry_is_too_late() {
    let mut bench = watched()
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |cells, ctx| ctx.start_watchdog(&mut cells.watchdog, delay!(0)))
        .build();
    bench.steps(3);
    assert_eq!(bench.log(), entries(&[("expired", 10, 0), ("expired", 20, 0)]));
}

#[test]
fn a_watchdog_without_a_timeout_expires_at_the_next_microstep_and_one_without_end_never() {
    let mut bench = watched()
        .watchdog(0)
        .reaction(0, &[By::Startup], |cells, ctx| ctx.start_watchdog(&mut cells.watchdog, delay!(0)))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0), at(0, 1)]);
    let mut bench = watched()
        .reaction(0, &[By::Startup], |cells, ctx| ctx.start_watchdog(&mut cells.watchdog, Duration::MAX))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0)]);
}
