// SPDX-License-Identifier: Apache-2.0
//! Every target runs a fixed number of inputs: recorded, mutated and random ones, the same in every run.

use lf_fuzz::{RawStep, TARGETS, Target};
use lf_testkit::golden::{Fill, Recording, Step};
use lf_testkit::random::Random;

/// The number of inputs for each target.
const RUNS: u64 = 60_000;
/// The length of the longest random input in bytes.
const BYTES_MAX: u64 = 600;

/// Returns the bytes that the tester of a recording sends, with arbitrary values for the masked ones.
fn bytes(step: &Step) -> Option<(u8, Vec<u8>)> {
    let (Step::Send(frame) | Step::Recv(frame)) = step else { return None };
    let connection = u8::try_from(frame.connection % 8).unwrap_or_default();
    let filled = match &frame.fill {
        Some(Fill::TagTime | Fill::Start) => 1_000_000_000i64.to_le_bytes(),
        _ => [1; 8],
    };
    Some((connection, frame.bytes.fill_with(filled)))
}

/// Returns a recording as the input of each target that can use it.
fn corpus(recording: &Recording) -> Vec<(&'static str, Vec<u8>)> {
    let mut wire = vec![255, 255, 15, 7];
    let (mut rti, mut federate) = (vec![0, 3], vec![0b0100_1011]);
    for step in &recording.steps {
        match step {
            Step::Connect(connection) => {
                RawStep::Connect(u8::try_from(*connection % 8).unwrap_or_default()).write(&mut rti);
            }
            Step::Close(connection) => {
                RawStep::Close(u8::try_from(*connection % 8).unwrap_or_default()).write(&mut rti);
            }
            _ => {}
        }
        let Some((connection, said)) = bytes(step) else { continue };
        wire.extend(&said);
        match (step, recording.federate()) {
            (Step::Send(_), None) => RawStep::Say(connection, said).write(&mut rti),
            (Step::Recv(_), None) => {
                RawStep::Read(connection).write(&mut rti);
                federate.extend(said);
            }
            (Step::Send(_), Some(_)) => federate.extend(said),
            _ => {}
        }
    }
    if let Some(setup) = recording.rti() {
        rti[1] = u8::try_from(setup.federates).unwrap_or(u8::MAX).wrapping_sub(1);
    }
    vec![("wire_raw", wire), ("rti_raw", rti), ("federate_raw", federate)]
}

/// Changes a few bytes, truncates, duplicates or joins inputs.
fn mutate(random: &mut Random, input: &mut Vec<u8>, other: &[u8]) {
    for _ in 0..=random.below(6) {
        let at = random.index(input.len());
        match random.below(5) {
            0 if !input.is_empty() => input[at] = random.byte(),
            1 if !input.is_empty() => input[at] ^= 1 << random.below(8),
            2 => input.truncate(at.max(1)),
            3 => input.insert(at, random.byte()),
            _ => {
                let from = random.index(other.len());
                let piece: Vec<u8> = other[from..].iter().take(random.count(1, 60)).copied().collect();
                input.splice(at..at, piece);
            }
        }
    }
}

fn run(name: &str, target: Target) {
    let recordings = lf_testkit::golden::load_all().unwrap_or_else(|error| panic!("{error}"));
    let corpus: Vec<_> = recordings.iter().flat_map(corpus).filter(|(wanted, _)| *wanted == name).collect();
    for (_, input) in &corpus {
        target(input);
    }
    for index in 0..RUNS {
        let mut random = Random::new(index);
        let mut input = match corpus.get(random.index(2 * corpus.len().max(1))) {
            Some((_, input)) => input.clone(),
            None => (0..random.below(BYTES_MAX)).map(|_| random.byte()).collect(),
        };
        if let Some((_, other)) = corpus.get(random.index(corpus.len())) {
            mutate(&mut random, &mut input, other);
        }
        let outcome = std::panic::catch_unwind(|| target(&input));
        assert!(outcome.is_ok(), "{name} fails for input {index}: {input:?}");
    }
}

fn run_named(name: &str) {
    let (name, target) = TARGETS.iter().find(|(target, _)| *target == name).expect("there is such a target");
    run(name, *target);
}

#[test]
fn wire_takes_bytes_for_what_they_are() {
    run_named("wire_raw");
}

#[test]
fn wire_gives_messages_back_as_they_were() {
    run_named("wire_structured");
}

#[test]
fn rti_survives_any_bytes() {
    run_named("rti_raw");
}

#[test]
fn rti_survives_any_federates() {
    run_named("rti_structured");
}

#[test]
fn federate_survives_any_bytes() {
    run_named("federate_raw");
}

#[test]
fn federate_survives_any_rti_and_event_loop() {
    run_named("federate_structured");
}

#[test]
fn encrypted_connections_take_nothing_of_strangers() {
    run_named("secure_raw");
}

#[test]
fn encrypted_content_comes_in_order_or_not_at_all() {
    run_named("secure_structured");
}
