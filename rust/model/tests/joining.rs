// SPDX-License-Identifier: Apache-2.0
//! A program that joins its federation after the start.
use crate::bench::{Bench, By, START, at, bench, entries};
use lf_model::{Interval, Settings, Tag};

/// Returns a program with a timeout of 50 ms, which joins at this tag.
fn joined(first: Tag) -> Bench {
    bench()
        .joins(first)
        .settings(Settings { timeout: Some(Interval::from_millis(50)), ..Settings::DEFAULT })
        .timer(0, 0, 10)
        .timer(1, 3, 0)
        .reaction(0, &[By::Startup], |cells, ctx| {
            assert_eq!((ctx.get_effective_start(), ctx.get_start_time()), (ctx.get_tag(), START));
            cells.log(ctx, "startup");
        })
        .reaction(0, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "first"))
        .reaction(0, &[By::Timer(1)], |cells, ctx| cells.log(ctx, "second"))
        .reaction(1, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"))
        .build()
}

/// Elapsed times and the timeout count from the start of the federation.
#[test]
fn timers_count_from_the_first_tag() {
    let mut bench = joined(at(32, 2));
    assert_eq!(bench.steps(9), [at(32, 2), at(35, 0), at(42, 0), at(50, 0)]);
    assert_eq!(
        bench.log(),
        entries(&[("startup", 32, 2), ("first", 32, 2), ("second", 35, 0), ("first", 42, 0), ("shutdown", 50, 0)])
    );
}

#[test]
fn one_that_joins_after_the_timeout_has_one_tag() {
    let mut bench = joined(at(60, 1));
    assert_eq!(bench.steps(9), [at(60, 1)]);
    assert_eq!(bench.log(), entries(&[("startup", 60, 1), ("first", 60, 1), ("shutdown", 60, 1)]));
}

#[test]
fn a_body_can_stop_its_federate_alone() {
    let mut bench = bench()
        .settings(Settings { federated: true, ..Settings::DEFAULT })
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            cells.log(ctx, "timer");
            ctx.stop();
        })
        .reaction(1, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0), at(0, 1)]);
    assert_eq!(bench.log(), entries(&[("timer", 0, 0), ("shutdown", 0, 1)]));
    assert_eq!(bench.engine.take_stop_request(), None, "the RTI is not asked");
}
