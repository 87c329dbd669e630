// SPDX-License-Identifier: Apache-2.0
//! Tags that run in pieces, as in cycles without delay: reactions wait for inputs, messages come while the tag is open,
//! and absences are sent.
use crate::bench::{Bench, Builder, By, at, bench, entries};
use lf_model::{DeliverError, InputId, OutputId, Progress, Settings, Tag};

/// Level 0 sets the output's port, level 1 sends it, level 2 sees the input, level 3 runs by a timer.
fn asks() -> Builder {
    bench()
        .settings(Settings { federated: true, ..Settings::DEFAULT })
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            ctx.set(&mut cells.ports[1], 7);
            cells.log(ctx, "asked");
        })
        .sends(1)
        .reaction(2, &[By::Input], |cells, ctx| cells.log(ctx, ctx.get(&cells.input.port).unwrap()))
        .reaction(3, &[By::Timer(0)], |cells, ctx| {
            let answer = ctx.get(&cells.input.port);
            cells.log(ctx, format_args!("{answer:?}"));
        })
        .tells_absence()
}

fn limit(level: u16) -> Progress {
    Progress::LevelLimit { level }
}

#[test]
fn reactions_from_a_level_on_are_held_back_and_the_tag_stays_open() {
    let mut bench = asks().build();
    bench.begin(at(0, 0));
    for level in [0, 1, 2, 3, u16::MAX, u16::MAX] {
        assert_eq!(bench.advance_below(Some(level)), limit(level));
        assert!(bench.engine.is_in_tag(), "even if there is nothing left to run");
    }
    assert_eq!(bench.log(), entries(&[("asked", 0, 0), ("None", 0, 0)]));
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!(bench.log(), []);
}

#[test]
fn a_message_for_the_open_tag_takes_effect_before_its_reactions_run() {
    let mut bench = asks().build();
    bench.begin(at(0, 0));
    assert_eq!(bench.advance_below(Some(2)), limit(2));
    assert!(!bench.engine.had_network_input());
    bench.deliver(at(0, 0), 8).unwrap();
    assert!(bench.engine.had_network_input());
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!(bench.log(), entries(&[("asked", 0, 0), ("8", 0, 0), ("Some(8)", 0, 0)]));
    assert_eq!(bench.engine.next_tag(), Some(at(10, 0)), "the message is no event of another tag");
    bench.steps(1);
    assert_eq!(bench.log(), entries(&[("asked", 10, 0), ("None", 10, 0)]), "its value is gone");
}

#[test]
fn a_message_whose_reactions_have_been_passed_by_is_late() {
    let late = |tag: Tag, current| Err(DeliverError::Late { input: "other.out -> bench.in", tag, current });
    let mut bench = asks().build();
    bench.begin(at(0, 0));
    bench.advance_below(Some(4));
    assert_eq!(bench.deliver(at(0, 0), 8), late(at(0, 0), at(0, 0)), "level 3 has seen that nothing came");
    assert_eq!(bench.deliver(at(0, 0).before(), 8), late(at(0, 0).before(), at(0, 0)));
    bench.advance();
    assert_eq!(bench.deliver(at(0, 0), 8), late(at(0, 0), at(0, 0)), "the tag is complete");
    bench.begin(at(1, 0));
    bench.deliver(at(1, 0), 8).expect("the levels of an earlier tag do not count");
}

#[test]
fn a_second_message_for_the_open_tag_happens_a_microstep_later() {
    let mut bench = asks().build();
    bench.deliver(at(1, 0), 1).unwrap();
    bench.steps(1);
    bench.begin(at(1, 0));
    bench.deliver(at(1, 0), 2).unwrap();
    bench.advance();
    bench.steps(1);
    assert_eq!(bench.log()[2..], entries(&[("1", 1, 0), ("2", 1, 1)]));
    bench.engine.set_stop_tag(at(2, 0));
    bench.begin(at(2, 0));
    bench.deliver(at(2, 0), 3).unwrap();
    bench.deliver(at(2, 0), 4).expect("what comes after the stop tag is dropped");
    bench.advance();
    assert_eq!(bench.log(), entries(&[("3", 2, 0)]));
}

#[test]
fn without_an_event_or_a_value_absence_is_told_at_every_tag() {
    let mut bench = asks().build();
    let absent = |bench: &mut Bench| std::mem::take(&mut bench.host.absent);
    bench.steps(1);
    assert_eq!((absent(&mut bench), bench.host.sent.len()), (vec![], 1), "a value is there");
    bench.begin(at(4, 2));
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!((absent(&mut bench), bench.host.sent.len()), (vec![(9, 3, at(4, 2))], 1));
    bench.engine.set_stop_tag(at(6, 0));
    bench.steps(1);
    assert_eq!(absent(&mut bench), [(9, 3, at(6, 0))], "the last tag is one like the others");
    bench = asks().output_delay(5).build();
    bench.begin(at(0, 0).before().next_microstep());
    bench.advance();
    bench.begin(at(3, 0));
    bench.advance();
    assert_eq!(absent(&mut bench), [(9, 3, at(8, 0))], "the connection's delay counts");
    bench.engine.set_stop_tag(at(7, 0));
    bench.begin(at(6, 0));
    bench.advance();
    assert_eq!(absent(&mut bench), [], "nobody gets to a tag after the stop");
}

#[test]
fn absence_that_has_no_room_keeps_the_tag_open() {
    let mut bench = asks().build();
    bench.steps(1);
    bench.host.room = 0;
    bench.begin(at(1, 0));
    assert_eq!(bench.advance(), Progress::OutputFull { output: OutputId(0) });
    assert!(bench.engine.is_in_tag());
    bench.host.make_room();
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!(bench.host.absent.len(), 1);
}

#[test]
fn a_value_that_is_sent_on_to_another_federate_is_late_once_absence_was_told() {
    // A reaction to the input sets the output, which comes before the absence is sent.
    let mut bench = bench()
        .reaction(0, &[By::Input], |cells, ctx| ctx.set(&mut cells.ports[1], 9))
        .sends(1)
        .tells_absence()
        .build();
    bench.begin(at(0, 0));
    bench.advance_below(Some(0));
    bench.deliver(at(0, 0), 1).unwrap();
    bench.advance();
    assert_eq!((bench.host.sent.len(), bench.host.absent.len()), (1, 0));
    bench.begin(at(1, 0));
    bench.advance_below(Some(2));
    assert_eq!((bench.host.sent.len(), bench.host.absent.len()), (1, 1));
    assert!(matches!(bench.deliver(at(1, 0), 1), Err(DeliverError::Late { .. })));
    assert!(bench.engine.has_room(&mut bench.program, InputId(0)));
}
