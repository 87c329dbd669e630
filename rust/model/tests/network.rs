// SPDX-License-Identifier: Apache-2.0
//! Messages to and from other federates: order, back-pressure in both directions, and what is refused.
use crate::bench::{Builder, By, at, bench, entries};
use lf_model::{DeliverError, InputId, ModelError, OutputId, PayloadError, Progress, Settings, Tag};

fn receiver() -> Builder {
    bench()
        .settings(Settings { federated: true, ..Settings::DEFAULT })
        .reaction(0, &[By::Input], |cells, ctx| cells.log(ctx, ctx.get(&cells.input.port).unwrap()))
}

#[test]
fn messages_happen_in_order_of_tag_however_they_come() {
    let mut bench = receiver().build();
    bench.deliver(at(8, 1), 81).unwrap();
    bench.deliver(at(3, 0), 30).unwrap();
    assert_eq!(bench.steps(9), [at(0, 0), at(3, 0), at(8, 1)]);
    assert_eq!(bench.log(), entries(&[("30", 3, 0), ("81", 8, 1)]));
}

#[test]
fn a_second_message_for_one_tag_happens_a_microstep_later() {
    let mut bench = receiver().build();
    bench.deliver(at(3, 0), 1).unwrap();
    bench.deliver(at(3, 0), 2).unwrap();
    bench.steps(9);
    assert_eq!(bench.log(), entries(&[("1", 3, 0), ("2", 3, 1)]));
}

/// Messages without a tag happen when they come, after the delay, in the order in which they come, and never at a tag
/// that has begun.
#[test]
fn messages_of_a_physical_connection_happen_when_they_come() {
    let mut bench = receiver().physical_connections().delay(2).timer(0, 30, 0).build();
    bench.engine.deliver_physical(&mut bench.program, InputId(0), at(-9, 0).time, &1u32.to_le_bytes()).unwrap();
    bench.engine.deliver_physical(&mut bench.program, InputId(0), at(4, 0).time, &2u32.to_le_bytes()).unwrap();
    let full = bench.engine.deliver_physical(&mut bench.program, InputId(0), at(4, 0).time, &3u32.to_le_bytes());
    assert!(matches!(full, Err(DeliverError::Full { .. })));
    assert_eq!(bench.steps(1), [at(0, 0)]);
    bench.engine.deliver_physical(&mut bench.program, InputId(0), at(4, 0).time, &3u32.to_le_bytes()).unwrap();
    assert_eq!(bench.steps(9), [at(6, 0), at(6, 1), at(30, 0)]);
    bench.engine.deliver_physical(&mut bench.program, InputId(0), at(7, 0).time, &4u32.to_le_bytes()).unwrap();
    assert_eq!(bench.steps(9), [at(30, 1)]);
    assert_eq!(bench.log(), entries(&[("1", 0, 0), ("2", 6, 0), ("3", 6, 1), ("4", 30, 1)]));
}

#[test]
fn a_full_input_asks_to_wait_and_takes_the_message_after_a_tag() {
    let mut bench = receiver().build();
    bench.deliver(at(1, 0), 1).unwrap();
    assert!(bench.engine.has_room(&mut bench.program, InputId(0)));
    bench.deliver(at(2, 0), 2).unwrap();
    assert!(!bench.engine.has_room(&mut bench.program, InputId(0)));
    let full = DeliverError::Full { input: "other.out -> bench.in", capacity: 2 };
    assert_eq!(bench.deliver(at(3, 0), 3), Err(full));
    assert_eq!(bench.steps(2), [at(0, 0), at(1, 0)]);
    assert!(bench.engine.has_room(&mut bench.program, InputId(0)));
    bench.deliver(at(3, 0), 3).unwrap();
    bench.steps(9);
    assert_eq!(bench.log(), entries(&[("1", 1, 0), ("2", 2, 0), ("3", 3, 0)]));
}

#[test]
fn late_messages_wrong_payloads_and_unknown_ports_are_refused() {
    let mut bench = receiver().build();
    let input = "other.out -> bench.in";
    let before = at(0, 0).before();
    let late = DeliverError::Late { input, tag: before, current: before };
    assert_eq!(bench.deliver(before, 1), Err(late), "before the start");
    bench.steps(1);
    assert_eq!(bench.deliver(Tag::NEVER, 1), Err(DeliverError::Late { input, tag: Tag::NEVER, current: at(0, 0) }));
    assert!(matches!(bench.deliver(at(0, 0), 1), Err(DeliverError::Late { .. })), "the current tag has passed");
    let mut deliver = |port, bytes: &[u8]| bench.engine.deliver(&mut bench.program, InputId(port), at(1, 0), bytes);
    let error = PayloadError::Length { expected: 4, found: 3 };
    assert_eq!(deliver(0, &[1, 2, 3]), Err(DeliverError::Payload { input, error }));
    assert_eq!(deliver(7, &[0; 4]), Err(DeliverError::NoSuchPort { port: 7 }));
    assert!(!bench.engine.has_room(&mut bench.program, InputId(7)));
    assert_eq!(bench.engine.next_tag(), None, "nothing of it has happened");
}

#[test]
fn messages_for_after_the_stop_or_for_ever_are_dropped() {
    let mut bench = receiver().build();
    bench.engine.set_stop_tag(at(5, 0));
    for tag in [at(5, 1), Tag::FOREVER] {
        bench.deliver(tag, 1).unwrap();
    }
    assert_eq!(bench.steps(9), [at(0, 0), at(5, 0)]);
    assert_eq!(bench.log(), []);
}

#[test]
fn the_engine_knows_whether_a_tag_had_messages() {
    let mut bench = receiver().timer(0, 2, 0).build();
    bench.deliver(at(1, 0), 1).unwrap();
    let had: Vec<bool> = (0..3).map(|_| (bench.step(), bench.engine.had_network_input()).1).collect();
    assert_eq!(had, [false, true, false]);
}

fn sender() -> Builder {
    bench()
        .timer(0, 0, 10)
        .reaction(0, &[By::Timer(0)], |cells, ctx| {
            ctx.set(&mut cells.ports[1], 7);
            cells.log(ctx, "set");
        })
        .sends(1)
        .reaction(2, &[By::Port(1)], |cells, ctx| cells.log(ctx, "after"))
}

#[test]
fn values_are_sent_with_the_connections_delay() {
    let sent = |builder: Builder| {
        let mut bench = builder.build();
        bench.steps(1);
        bench.host.sent
    };
    let message = |tag| vec![(9, 3, tag, vec![7, 0, 0, 0])];
    assert_eq!(sent(sender()), message(at(0, 0)));
    assert_eq!(sent(sender().output_delay(0)), message(at(0, 1)));
    assert_eq!(sent(sender().output_delay(25)), message(at(25, 0)));
}

#[test]
fn a_tag_whose_output_has_no_room_stays_open_and_is_resumed() {
    let mut bench = sender().build();
    bench.host.room = 0;
    let full = Progress::OutputFull { output: OutputId(0) };
    assert_eq!(bench.step(), Some((at(0, 0), full)));
    assert!(bench.engine.is_in_tag());
    assert_eq!(bench.advance(), full, "still no room");
    assert_eq!(bench.log(), entries(&[("set", 0, 0)]), "nothing runs twice, nothing overtakes");
    // Messages for later tags are taken meanwhile.
    bench.deliver(at(1, 0), 1).unwrap();
    bench.host.make_room();
    assert_eq!(bench.advance(), Progress::Complete);
    assert_eq!(bench.host.sent.len(), 1);
    assert_eq!(bench.log(), entries(&[("after", 0, 0)]));
    assert_eq!(bench.engine.next_tag(), Some(at(1, 0)));
}

#[test]
fn messages_that_would_arrive_after_the_stop_are_not_sent() {
    let mut bench = sender().output_delay(5).build();
    bench.engine.set_stop_tag(at(12, 0));
    bench.steps(9);
    let tags: Vec<Tag> = bench.host.sent.iter().map(|sent| sent.2).collect();
    assert_eq!(tags, [at(5, 0)]);
}

#[test]
fn a_value_that_cannot_be_written_ends_the_program() {
    let mut bench =
        bench().reaction(0, &[By::Startup], |cells, ctx| ctx.set(&mut cells.ports[1], u32::MAX)).sends(1).build();
    let error = ModelError::Encode { output: "bench.out -> other.in", error: PayloadError::Nul };
    assert_eq!(bench.failure(), error);
    assert_eq!(bench.advance(), Progress::Failed(error), "it has failed for good");
}
