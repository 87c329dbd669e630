// SPDX-License-Identifier: Apache-2.0
//! Messages that come after their tag: when they take effect, which reactions see them, and their intended tags.
use crate::bench::{Bench, Builder, By, Cells, MS, at, bench, entries};
use lf_model::prelude::Asap;
use lf_model::{Delivery, InputId, Interval, ReactionContext, Settings};

fn program() -> Builder {
    bench().settings(Settings { federated: true, ..Settings::DEFAULT }).timer(0, 0, 10).tardy()
}

/// Logs a word, the input's value and the milliseconds and microsteps that it was meant for.
fn log_input(word: &'static str) -> impl FnMut(&mut Cells, &mut ReactionContext<'_>) {
    move |cells, ctx| {
        let intended = ctx.get_intended_tag(&cells.input.port);
        let value = ctx.get(&cells.input.port).map_or_else(|| "nothing".to_owned(), |value| value.to_string());
        let (ms, microstep) = (intended.offset_from_t0.as_nanos() / u128::from(MS.unsigned_abs()), intended.microstep);
        cells.log(ctx, format!("{word} {value} for {ms}.{microstep}"));
    }
}

/// Runs all that is before and at 20 ms.
fn to_20_ms(bench: &mut Bench) {
    while bench.engine.next_tag().is_some_and(|tag| tag <= at(20, 0)) {
        bench.step();
    }
    bench.log();
}

#[test]
fn a_tardy_message_happens_at_the_next_microstep_and_runs_handlers_in_place_of_bodies() {
    let builder = program().reaction(0, &[By::Input], log_input("body")).handles_tardy(log_input("tardy"));
    let mut bench = builder.reaction(1, &[By::Input], log_input("other")).build();
    to_20_ms(&mut bench);
    assert_eq!(bench.deliver_tardy(at(13, 2), 7), Delivery::Tardy(at(20, 1)));
    assert_eq!(bench.deliver_tardy(at(25, 0), 8), Delivery::InTime(at(25, 0)));
    assert_eq!(bench.steps(2), [at(20, 1), at(25, 0)]);
    let expected = [
        ("tardy 7 for 13.2", 20, 1),
        ("other 7 for 13.2", 20, 1),
        ("body 8 for 25.0", 25, 0),
        ("other 8 for 25.0", 25, 0),
    ];
    assert_eq!(bench.log(), entries(&expected));
}

/// One after the other, none overtaken by what was sent later, and that is tardy too where it has to give way.
#[test]
fn tardy_messages_of_one_input_stay_in_order() {
    let mut bench = program().reaction(0, &[By::Input], log_input("body")).build();
    to_20_ms(&mut bench);
    assert_eq!(bench.deliver_tardy(at(12, 0), 1), Delivery::Tardy(at(20, 1)));
    assert_eq!(bench.deliver_tardy(at(13, 0), 2), Delivery::Tardy(at(20, 2)));
    bench.steps(1);
    assert_eq!(bench.deliver_tardy(at(20, 2), 3), Delivery::Tardy(at(20, 3)));
    bench.steps(2);
    let expected = [("body 1 for 12.0", 20, 1), ("body 2 for 13.0", 20, 2), ("body 3 for 20.2", 20, 3)];
    assert_eq!(bench.log(), entries(&expected));
}

/// A reaction at that tag that is triggered by one without a handler is tardy too; by a handler, or later, it is not.
#[test]
fn reactions_without_a_handler_hand_tardiness_on_within_the_tag() {
    let set = |port: usize| move |cells: &mut Cells, ctx: &mut ReactionContext<'_>| ctx.set(&mut cells.ports[port], 1);
    let log = |word: &'static str| move |cells: &mut Cells, ctx: &mut ReactionContext<'_>| cells.log(ctx, word);
    let mut bench = program()
        .delay(0)
        .reaction(0, &[By::Input], set(0))
        .reaction(1, &[By::Port(0)], log("after a body"))
        .handles_tardy(move |cells, ctx| {
            cells.log(ctx, "handled");
            ctx.set(&mut cells.ports[2], 1);
        })
        .reaction(2, &[By::Port(2)], log("after a handler"))
        .handles_tardy(log("never"))
        .reaction(3, &[By::Delayed], log("later"))
        .handles_tardy(log("never"))
        .build();
    to_20_ms(&mut bench);
    bench.deliver_tardy(at(11, 0), 1);
    bench.steps(2);
    assert_eq!(bench.log(), entries(&[("handled", 20, 1), ("after a handler", 20, 1), ("later", 20, 2)]));
    bench.deliver_tardy(at(30, 0), 1);
    bench.steps(2);
    assert_eq!(bench.log(), entries(&[("after a body", 30, 0), ("later", 30, 1)]));
}

#[test]
fn all_readers_of_a_tardy_input_see_the_intended_tag_at_that_tag_only() {
    let log = |word: &'static str| move |cells: &mut Cells, ctx: &mut ReactionContext<'_>| cells.log(ctx, word);
    let builder = program().reaction(0, &[By::Input], |cells, ctx| ctx.set(&mut cells.ports[2], 1));
    let builder =
        builder.reaction(1, &[By::Timer(0), By::Port(1)], log_input("body")).handles_tardy(log("told")).reads_input();
    let set = |cells: &mut Cells, ctx: &mut ReactionContext<'_>| ctx.set(&mut cells.ports[1], 1);
    let mut bench = builder.reaction(0, &[By::Input], set).build();
    to_20_ms(&mut bench);
    bench.deliver_tardy(at(11, 0), 1);
    bench.steps(2);
    assert_eq!(bench.log(), entries(&[("told", 20, 1), ("body nothing for 30.0", 30, 0)]));
}

/// A deadline is not looked at where a handler deals with the message; where none does, it is.
#[test]
fn a_handler_comes_before_a_missed_deadline() {
    for handles in [true, false] {
        let builder = program().reaction(0, &[By::Input], log_input("body")).deadline(0, log_input("missed"));
        let builder = if handles { builder.handles_tardy(log_input("tardy")) } else { builder };
        let mut bench = builder.build();
        to_20_ms(&mut bench);
        bench.deliver_tardy(at(11, 0), 1);
        bench.steps(1);
        let word = if handles { "tardy 1 for 11.0" } else { "missed 1 for 11.0" };
        assert_eq!(bench.log(), entries(&[(word, 20, 1)]));
    }
}

/// As in an open tag of a cycle, it is in time as long as no reaction has run that could see it.
#[test]
fn a_message_for_the_open_tag_is_tardy_only_when_its_level_has_been_reached() {
    for (limit, delivery) in [(1, Delivery::InTime(at(0, 0))), (2, Delivery::Tardy(at(0, 1)))] {
        let nothing = |_: &mut Cells, _: &mut ReactionContext<'_>| {};
        let mut bench = program()
            .reaction(1, &[By::Input, By::Timer(0)], log_input("body"))
            .reaction(0, &[By::Timer(0)], nothing)
            .build();
        bench.begin(at(0, 0));
        bench.advance_below(Some(limit));
        assert_eq!(bench.deliver_tardy(at(0, 0), 5), delivery);
        bench.advance();
        let seen = if limit == 1 { "body 5 for 0.0" } else { "body nothing for 0.0" };
        assert_eq!(bench.log(), entries(&[(seen, 0, 0)]));
    }
}

/// Values that were sent at several microsteps come at one tag where the connection has a delay. The second is in time,
/// though the tag is over, until the microstep begins to which it is put off.
#[test]
fn a_second_message_for_one_tag_is_in_time_until_the_next_microstep() {
    let mut bench = program().reaction(0, &[By::Input], log_input("body")).build();
    bench.deliver_tardy(at(20, 0), 1);
    to_20_ms(&mut bench);
    assert_eq!(bench.deliver_tardy(at(20, 0), 2), Delivery::InTime(at(20, 1)));
    bench.steps(1);
    assert_eq!(bench.deliver_tardy(at(20, 0), 3), Delivery::InTime(at(20, 2)));
    bench.steps(2);
    assert_eq!(bench.deliver_tardy(at(20, 0), 4), Delivery::Tardy(at(30, 1)));
}

#[test]
fn messages_after_the_last_tag_do_not_happen() {
    let mut bench = program().reaction(0, &[By::Input, By::Timer(0)], log_input("body")).build();
    bench.engine.set_stop_tag(at(20, 0));
    assert_eq!(bench.deliver_tardy(at(20, 1), 1), Delivery::AfterStop);
    bench.steps(2);
    bench.begin(at(20, 0));
    bench.advance_below(Some(1));
    assert_eq!(bench.deliver_tardy(at(20, 0), 2), Delivery::Lost);
    bench.advance();
    assert!(bench.engine.is_done());
    assert_eq!(bench.deliver_tardy(at(20, 0), 3), Delivery::Lost);
    assert_eq!(bench.deliver_tardy(at(3, 0), 4), Delivery::Lost);
}

#[test]
fn a_body_can_change_how_long_tags_wait() {
    let raise = |_: &mut Cells, ctx: &mut ReactionContext<'_>| {
        ctx.set_max_wait(ctx.max_wait().saturating_add(Interval::from_nanos(5)));
    };
    let mut bench = program().reaction(0, &[By::Timer(0)], raise).build();
    let before = bench.engine.max_wait(InputId(0));
    bench.steps(2);
    assert_eq!(bench.engine.max_wait(InputId(0)), before.saturating_add(Interval::from_nanos(10)));
    assert_eq!(bench.engine.max_wait(InputId(9)), Interval::ZERO, "there is no such input");
}

#[test]
fn a_second_message_for_one_tag_is_tardy_when_the_next_microstep_is_over() {
    let mut bench = program()
        .reaction(0, &[By::Input], log_input("body"))
        .reaction(1, &[By::Timer(0)], |cells, ctx| ctx.schedule(&mut cells.actions[0], Asap))
        .build();
    bench.deliver_tardy(at(20, 0), 1);
    to_20_ms(&mut bench);
    assert_eq!(bench.steps(1), [at(20, 1)]);
    assert_eq!(bench.deliver_tardy(at(20, 0), 2), Delivery::Tardy(at(20, 2)));
}

#[test]
fn what_would_take_effect_after_the_stop_is_lost() {
    let mut bench = program().reaction(0, &[By::Input], log_input("body")).build();
    bench.engine.set_stop_tag(at(20, 1));
    to_20_ms(&mut bench);
    assert_eq!(bench.deliver_tardy(at(20, 2), 1), Delivery::AfterStop);
    assert_eq!(bench.deliver_tardy(at(13, 0), 2), Delivery::Tardy(at(20, 1)), "the stop itself is not after it");
    assert_eq!(bench.deliver_tardy(at(13, 0), 3), Delivery::Lost, "it would follow the first one");
    assert_eq!(bench.steps(9), [at(20, 1)]);
    assert_eq!(bench.deliver_tardy(at(14, 0), 4), Delivery::Lost);
    assert_eq!(bench.engine.next_tag(), None);
    assert_eq!(bench.log(), entries(&[("body 2 for 13.0", 20, 1)]));
}
