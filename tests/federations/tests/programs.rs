// SPDX-License-Identifier: Apache-2.0
//! The applications, from source to result.

use std::path::Path;

use lf_federations::{Lfz, programs, wait_for_ends};

#[test]
fn hello_world_is_one_process_with_its_own_output() {
    let run = Lfz::run("hello_world", Path::new("applications/hello_world/src/HelloWorld.lf"), &[]);
    let finished = run.finish();
    assert_eq!(finished.code(), 0, "{finished}");
    let greetings: Vec<&String> =
        finished.lines.iter().filter(|line| !line.starts_with("Compil") && !line.contains("info:")).collect();
    let expected = [
        "Hello, world!",
        "250 ms: 1",
        "500 ms: 2",
        "750 ms: 3",
        "1000 ms: 4",
        "Goodbye after 4 greetings of the timer.",
    ];
    assert_eq!(greetings, expected, "{finished}");
}

/// Both spellings of the log macros work, and `logging` says from which level on they are shown.
#[test]
fn bodies_print_and_log() {
    let finished = Lfz::run("talking", &programs().join("Talking.lf"), &[]).finish();
    assert_eq!(finished.code(), 0, "{finished}");
    let said = |line: &str| finished.lines.iter().any(|found| found == line);
    for line in ["by println", "by eprintln", "info: by info", "warn: by log::warn", "debug: by log::debug"] {
        assert!(said(line), "{line}: {finished}");
    }
    assert!(!finished.lines.iter().any(|line| line.contains("by log::trace")), "{finished}");
}

#[test]
fn the_message_test_receives_everything_in_order() {
    let run = Lfz::run("message_test", Path::new("applications/message_test/src/MessageTest.lf"), &[]);
    let finished = run.finish();
    assert_eq!(finished.code(), 0, "{finished}");
    let results: Vec<&str> = finished.of("receiver").filter(|line| line.starts_with("received")).collect();
    assert_eq!(results.len(), 1, "{finished}");
    assert!(results[0].starts_with("received 3000 of 3000 messages in order, "), "{finished}");
}

#[test]
fn the_smart_grid_isolates_the_fault() {
    let run = Lfz::run("smart_grid", Path::new("applications/smart_grid/src/SmartGrid.lf"), &[]);
    let finished = run.finish();
    assert_eq!(finished.code(), 0, "{finished}");
    for (federate, status) in [("a", "A: closed,"), ("b", "B: open,"), ("c", "C: open,"), ("d", "D: closed,")] {
        let lines: Vec<&str> = finished.of(federate).filter(|line| line.contains("reaction time")).collect();
        assert_eq!(lines.len(), 1, "{finished}");
        assert!(lines[0].starts_with(status), "{finished}");
    }
}

#[test]
fn two_runs_of_a_program_at_once_do_not_mix() {
    let file = programs().join("Endless.lf");
    Lfz::build("two_runs", &file);
    let mut runs = [Lfz::run("two_runs", &file, &[]), Lfz::run("two_runs", &file, &[])];
    for run in &mut runs {
        run.wait_for("the sink runs");
    }
    let [one, other] = runs;
    one.signal(rustix::process::Signal::INT);
    assert_eq!(one.finish().code(), 130);
    // The other one still has all of its participants.
    let participants = other.participants();
    assert_eq!(participants.len(), 3);
    other.signal(rustix::process::Signal::INT);
    assert_eq!(other.finish().code(), 130);
    wait_for_ends(&participants);
}
