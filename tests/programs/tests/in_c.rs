// SPDX-License-Identifier: Apache-2.0
//! Bodies in C run by the model's engine, with C's API.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]
#![expect(unsafe_code, reason = "the bodies' notes are C's")]

use std::ffi::{CStr, c_char};

use lf_linux::model::{Delivery, Engine, EngineStorage as _, InputId, Instant, Interval, Settings, Tag};
use lf_programs::in_c::node::federate::{NodeFederate, Storage, TABLES};
use lf_testkit::host::{Clock, Host};

unsafe extern "C" {
    /// The notes of the bodies: a text that ends with a NUL.
    #[link_name = "notes"]
    static NOTES: [c_char; 4096];
}

const START: Instant = Instant::from_nanos(1_000_000_000);

fn at(ms: i64) -> Tag {
    Tag::at(START + Interval::from_millis(ms))
}

/// Returns a `point_t`, as C lays it out.
fn point(id: u8, volts: f64) -> Vec<u8> {
    let mut bytes = vec![0; 16];
    bytes[0] = id;
    bytes[8..].copy_from_slice(&volts.to_le_bytes());
    bytes
}

#[test]
fn bodies_in_c_do_what_lf_says() {
    let mut host = Host::new(Clock::new_static(START.as_nanos()));
    let (mut program, mut storage) = (NodeFederate::new(), Storage::new());
    let mut engine = Engine::new(&TABLES, &mut storage, Settings { federated: true, ..Settings::DEFAULT });
    engine.start(START);
    let mut deliver = |input, bytes: &[u8]| {
        engine.deliver(&mut program, InputId(input), at(15), bytes).map_err(|error| error.to_string())
    };
    assert_eq!(deliver(0, b"hello\0"), Ok(()));
    assert_eq!(deliver(1, &[4, 0, 0, 0, 5, 0, 0, 0]), Ok(()));
    assert_eq!(deliver(2, &point(1, 2.5)), Ok(()));
    for (input, bytes, because) in [
        (0, &b"hello"[..], "a text ends with its only NUL byte, but it has one elsewhere or none"),
        (1, &[4, 0, 0], "its elements take 4 bytes each, which does not divide 3"),
        (2, &[1], "its type takes 16 bytes, but it has 1"),
    ] {
        let error = deliver(input, bytes).expect_err("the bytes are no value");
        assert!(error.contains(because), "{error}");
    }
    host.run(&mut engine, &mut program, |engine, program, tag| {
        if tag == at(15) {
            let tardy = engine.deliver_tardy(program, InputId(2), at(10), &point(2, 0.0));
            assert_eq!(tardy, Ok(Delivery::Tardy(at(15).next_microstep())));
        }
    });

    // SAFETY: C ends the text with a NUL, and no body runs any more.
    let seen = unsafe { CStr::from_ptr(NOTES.as_ptr()) }.to_str().unwrap();
    let (seen, expected): (Vec<_>, Vec<_>) = (seen.lines().collect(), include_str!("in_c.txt").lines().collect());
    assert_eq!(seen, expected);
    let list = vec![1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0];
    let sent = [
        (1, 0, at(0), list.clone()),
        (1, 1, at(15), b"hello\0".to_vec()),
        (1, 2, at(15), point(1, 2.5)),
        (1, 2, at(15).next_microstep(), point(3, 1.5)),
        (1, 0, at(20), list),
    ];
    assert_eq!(host.sent, sent);
}
