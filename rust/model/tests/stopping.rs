// SPDX-License-Identifier: Apache-2.0
//! The end of a program: requests, timeouts, grants, and having nothing left to do; and tags that must not begin.
use crate::bench::{By, at, bench, entries};
use lf_model::prelude::*;
use lf_model::{Interval, ModelError, Settings, Tag};

const FEDERATED: Settings = Settings { federated: true, ..Settings::DEFAULT };

fn timeout(ms: i64) -> Settings {
    Settings { timeout: Some(Interval::from_millis(ms)), ..Settings::DEFAULT }
}

#[test]
fn a_stop_happens_at_the_next_microstep_with_what_is_due_there() {
    let mut bench = bench()
        .timer(0, 0, 4)
        .reaction(0, &[By::Startup], |cells, ctx| {
            ctx.set(&mut cells.ports[0], 43);
            ctx.schedule_with_v(&mut cells.actions[0], Some(1), Asap);
            ctx.schedule_with_v(&mut cells.actions[0], Some(2), after!(1 ms));
            ctx.request_stop(Asap);
            assert!(!ctx.is_shutdown());
        })
        .reaction(0, &[By::Action(0)], |cells, ctx| cells.log(ctx, ctx.get(&cells.actions[0]).unwrap()))
        .reaction(1, &[By::Shutdown], |cells, ctx| {
            assert!(ctx.is_shutdown() && !ctx.is_present(&cells.ports[0]));
            cells.log(ctx, "shutdown");
            // Idempotent: it is the last tag already.
            ctx.request_stop(Asap);
        })
        .build();
    assert_eq!(bench.steps(9), [at(0, 0), at(0, 1)]);
    assert_eq!(bench.log(), entries(&[("1", 0, 1), ("shutdown", 0, 1)]));
    assert!(bench.engine.is_done());
}

#[test]
fn a_timeout_ends_the_program_at_its_tag_and_includes_what_happens_there() {
    let mut bench = bench()
        .settings(timeout(50))
        .timer(0, 0, 25)
        .reaction(0, &[By::Timer(0)], |cells, ctx| cells.log(ctx, "timer"))
        .reaction(1, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0), at(25, 0), at(50, 0)]);
    assert_eq!(bench.log(), entries(&[("timer", 0, 0), ("timer", 25, 0), ("timer", 50, 0), ("shutdown", 50, 0)]));
}

#[test]
fn a_timeout_of_zero_starts_and_stops_at_one_tag() {
    let mut bench = bench()
        .settings(timeout(0))
        .reaction(0, &[By::Startup], |cells, ctx| {
            cells.log(ctx, "startup");
            ctx.schedule(&mut cells.actions[0], Asap);
        })
        .reaction(0, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"))
        .build();
    assert_eq!(bench.steps(9), [at(0, 0)]);
    assert_eq!(bench.log(), entries(&[("startup", 0, 0), ("shutdown", 0, 0)]));
}

#[test]
fn a_stop_requested_for_later_lets_events_happen_until_then() {
    let mut bench = bench().timer(0, 0, 3).reaction(0, &[By::Startup], |_, ctx| ctx.request_stop(after!(7 ms))).build();
    assert_eq!(bench.steps(9), [at(0, 0), at(3, 0), at(6, 0), at(7, 0)]);
}

#[test]
fn a_federate_reports_the_request_and_goes_on_until_the_stop_is_granted() {
    let mut bench = bench()
        .settings(FEDERATED)
        .timer(0, 0, 2)
        .reaction(0, &[By::Timer(0)], |_, ctx| {
            if ctx.get_tag() == tag!(T0 + 2 ms) {
                ctx.request_stop(after!(1 ms));
                ctx.request_stop(Asap);
            }
        })
        .reaction(1, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"))
        .build();
    assert_eq!(bench.steps(1), [at(0, 0)]);
    assert_eq!(bench.engine.take_stop_request(), None);
    assert_eq!(bench.steps(2), [at(2, 0), at(4, 0)]);
    assert_eq!(bench.engine.take_stop_request(), Some(at(2, 1)), "the earliest of those that were asked for");
    assert_eq!(bench.engine.take_stop_request(), None, "it is reported once");
    bench.engine.set_stop_tag(at(7, 3));
    bench.engine.set_stop_tag(at(9, 0));
    assert_eq!(bench.steps(9), [at(6, 0), at(7, 3)], "a stop is never put off");
    assert_eq!(bench.log(), entries(&[("shutdown", 7, 3)]));
}

/// A request for the last tag itself is none.
#[test]
fn a_federate_does_not_ask_for_a_stop_that_it_has_been_granted() {
    let mut bench = bench()
        .settings(FEDERATED)
        .timer(0, 0, 2)
        .reaction(0, &[By::Timer(0)], |_, ctx| ctx.request_stop(after!(3 ms)))
        .build();
    bench.engine.set_stop_tag(at(3, 0));
    bench.steps(1);
    assert_eq!(bench.engine.take_stop_request(), None);
    bench.engine.set_stop_tag(at(2, 5));
    assert_eq!(bench.steps(9), [at(2, 0), at(2, 5)], "an earlier stop is one");
}

#[test]
fn a_program_that_stops_alone_goes_on_sending_until_the_others_stop() {
    let mut bench = bench().settings(FEDERATED).timer(0, 0, 2).build();
    bench.steps(2);
    bench.engine.stop_alone(at(5, 1));
    bench.engine.stop_alone(at(9, 0));
    assert_eq!(bench.steps(9), [at(4, 0), at(5, 1)], "a stop is never put off");
    assert!(!bench.engine.has_sent_all(), "what it sends for later arrives");
    bench.engine.stop_alone(Tag::NEVER);
    assert_eq!(bench.steps(9), [], "it has stopped");
    let mut bench = crate::bench::bench().settings(FEDERATED).timer(0, 0, 2).build();
    bench.steps(2);
    assert!(!bench.engine.has_sent_all());
    bench.engine.stop_alone(at(1, 0));
    bench.engine.set_stop_tag(at(2, 1));
    assert_eq!(bench.steps(9), [at(2, 1)], "the earliest is the next microstep");
    assert!(bench.engine.has_sent_all());
}

#[test]
fn a_stop_granted_for_the_past_happens_at_the_next_microstep() {
    let mut bench = bench().settings(FEDERATED).timer(0, 0, 2).build();
    bench.steps(2);
    bench.engine.set_stop_tag(at(1, 0));
    assert_eq!(bench.steps(9), [at(2, 1)]);
}

#[test]
fn without_events_the_program_stops_unless_something_can_still_happen() {
    let idle = || bench().reaction(0, &[By::Shutdown], |cells, ctx| cells.log(ctx, "shutdown"));
    let mut ends = idle().build();
    assert_eq!(ends.steps(9), [at(0, 0)]);
    assert!(ends.engine.stop_if_idle(&ends.host));
    assert_eq!(ends.steps(9), [at(0, 1)], "shutdown happens even if nothing else does");
    assert_eq!(ends.log(), entries(&[("shutdown", 0, 1)]));
    assert!(!ends.engine.stop_if_idle(&ends.host), "it has stopped");

    let mut stays = idle().settings(Settings { keepalive: true, ..Settings::DEFAULT }).build();
    stays.steps(9);
    assert!(!stays.engine.stop_if_idle(&stays.host));
    assert_eq!(stays.engine.next_tag(), None);

    let mut waits = idle().settings(timeout(30)).build();
    waits.steps(1);
    assert!(!waits.engine.stop_if_idle(&waits.host));
    assert_eq!(waits.steps(9), [at(30, 0)], "a timeout is waited for");

    let mut busy = idle().timer(0, 10, 0).build();
    assert!(!busy.engine.stop_if_idle(&busy.host));
}

#[test]
fn a_physical_thread_with_a_link_keeps_the_program_up_until_it_ends() {
    let mut bench = bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            let link = ctx.physical_link();
            let second = link.clone();
            cells.log.clear();
            LINKS.with_borrow_mut(|links| links.extend([link, second]));
        })
        .build();
    bench.steps(1);
    assert!(!bench.engine.stop_if_idle(&bench.host));
    LINKS.with_borrow_mut(Vec::pop);
    assert!(!bench.engine.stop_if_idle(&bench.host));
    let wakes = bench.clock.wakes();
    LINKS.with_borrow_mut(Vec::pop);
    assert_eq!(bench.clock.wakes(), wakes + 1, "the event loop may have waited for that thread alone");
    assert!(bench.engine.stop_if_idle(&bench.host));
    assert_eq!(bench.steps(9), [at(0, 1)]);
}

thread_local! {
    static LINKS: std::cell::RefCell<Vec<PhysicalLink>> = const { std::cell::RefCell::new(Vec::new()) };
}

#[test]
fn tags_begin_in_order_one_at_a_time_and_none_is_skipped() {
    let mut bench = bench().timer(0, 0, 2).reaction(0, &[By::Timer(0)], |_, _| {}).build();
    let begin = |bench: &mut crate::bench::Bench, tag: Tag| bench.engine.begin(&mut bench.program, tag);
    assert_eq!(begin(&mut bench, at(2, 0)), Err(ModelError::TagOrder { tag: at(2, 0), against: at(0, 0) }));
    assert_eq!(begin(&mut bench, at(0, 0)), Ok(()));
    assert_eq!(begin(&mut bench, at(2, 0)), Err(ModelError::NotReady { tag: at(2, 0) }));
    bench.advance();
    assert_eq!(begin(&mut bench, at(0, 0)), Err(ModelError::TagOrder { tag: at(0, 0), against: at(0, 0) }));
    // A tag without events may begin, as one that the RTI grants.
    assert_eq!(begin(&mut bench, at(1, 0)), Ok(()));
    bench.advance();
    assert_eq!(bench.steps(1), [at(2, 0)]);
}
