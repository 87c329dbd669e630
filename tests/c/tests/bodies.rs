// SPDX-License-Identifier: Apache-2.0
//! Bodies in C run by the model's engine, with C's API, in virtual time.
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, reason = "a test program has no users")]
#[path = "../../../rust/model/tests/common/mod.rs"]
mod common;

use std::ffi::{CStr, c_char};

use common::{Clock, Host};
use lf_bodies_in_c::{Program, Storage, TABLES, sizes};
use lf_model as lf;

unsafe extern "C" {
    /// A text that does not change while no body runs.
    safe fn take_notes() -> *const c_char;
}

fn notes() -> String {
    // SAFETY: C gives a text that ends with a NUL, and no body runs.
    unsafe { CStr::from_ptr(take_notes()) }.to_str().expect("notes are in ASCII").to_owned()
}

const MS: i64 = 1_000_000;
const START: lf::Instant = lf::Instant::from_nanos(1_000 * MS);

fn at(ms: i64) -> lf::Tag {
    lf::Tag::at(START + lf::Interval::from_millis(ms))
}

/// A `point_t`, as C lays it out.
fn point(id: u8, volts: f64) -> Vec<u8> {
    let mut bytes = vec![0; sizes::LF_SIZE_0];
    bytes[0] = id;
    bytes[8..].copy_from_slice(&volts.to_le_bytes());
    bytes
}

#[test]
fn bodies_in_c_do_what_lf_says() {
    let clock: &'static Clock = Clock::new_static(0);
    let mut host = Host::new(clock);
    let mut program = Program::default();
    let mut storage = Storage::new();
    let settings = lf::Settings { federated: true, ..lf::Settings::DEFAULT };
    let mut engine = lf::Engine::new(&TABLES, &mut storage, settings);
    clock.set(START);
    engine.start(START);
    assert_eq!((sizes::LF_SIZE_0, sizes::LF_SIZE_1), (16, 4));

    let deliver = |engine: &mut lf::Engine<'_>, program: &mut Program, input, bytes: &[u8]| {
        engine.deliver(program, lf::InputId(input), at(15), bytes).map_err(|error| error.to_string())
    };
    assert_eq!(deliver(&mut engine, &mut program, 0, b"hello\0"), Ok(()));
    assert_eq!(deliver(&mut engine, &mut program, 1, &[4, 0, 0, 0, 5, 0, 0, 0]), Ok(()));
    assert_eq!(deliver(&mut engine, &mut program, 2, &point(1, 2.5)), Ok(()));
    for (input, bytes, because) in [
        (0, &b"hello"[..], "a text ends with its only NUL byte, but it has one elsewhere or none"),
        (1, &[4, 0, 0], "its elements take 4 bytes each, which does not divide 3"),
        (2, &[1], "its type takes 16 bytes, but it has 1"),
    ] {
        let error = deliver(&mut engine, &mut program, input, bytes).expect_err("the bytes are no value");
        assert!(error.contains(because), "{error}");
    }

    let mut from_outside = Vec::new();
    while !engine.is_done() {
        engine.drain_physical(&mut program, &host);
        let Some(tag) = engine.next_tag() else { break };
        clock.set(tag.time);
        engine.begin(&mut program, tag).expect("it is the next tag");
        engine.physical_events(&mut program, &mut |trigger, encode| {
            let mut bytes = [0; 8];
            let len = encode(&mut bytes).expect("it has a value").expect("there is room");
            from_outside.push((tag, trigger, bytes[..len].to_vec()));
        });
        assert_eq!(engine.advance(&mut program, &mut host, None), lf::Progress::Complete);
        if let Some(tag) = engine.take_stop_request() {
            engine.set_stop_tag(tag);
        }
        if tag == at(15) {
            let tardy = engine.deliver_tardy(&mut program, lf::InputId(2), at(10), &point(2, 0.0));
            assert_eq!(tardy, Ok(lf::Delivery::Tardy(at(15).next_microstep())));
        }
    }

    // What the thread has scheduled, as whoever records that gets it.
    assert_eq!(from_outside, [(at(12), lf::TriggerId(5), vec![77, 0, 0, 0])]);
    let seen = notes();
    let (seen, expected): (Vec<_>, Vec<_>) = (seen.lines().collect(), include_str!("notes.txt").lines().collect());
    assert_eq!(seen, expected);
    let list = vec![1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0];
    let sent = [
        (0, 0, at(0), list.clone()),
        (0, 1, at(15), b"hello\0".to_vec()),
        (0, 2, at(15), point(1, 2.5)),
        (0, 2, at(15).next_microstep(), point(3, 1.5)),
        (0, 0, at(20), list),
    ];
    assert_eq!(host.sent, sent);
}
