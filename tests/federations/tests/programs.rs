// SPDX-License-Identifier: Apache-2.0
//! The applications, from source to result.

use std::path::Path;

use lf_federations::{Lfz, Run, is_of_build, programs, wait_for_ends};

#[test]
fn hello_world_is_one_process_with_its_own_output() {
    let run = Lfz::run("hello_world", Path::new("applications/hello_world/src/HelloWorld.lf"), &[]);
    let finished = run.succeed();
    let greetings: Vec<&String> =
        finished.lines.iter().filter(|line| !is_of_build(line) && !line.contains("info:")).collect();
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

/// Both spellings of the log macros work, and `logging` sets the level from which on they are shown.
#[test]
fn bodies_print_and_log() {
    let finished = Lfz::run("talking", &programs().join("Talking.lf"), &[]).succeed();
    let said = |line: &str| finished.lines.iter().any(|found| found == line);
    for line in ["by println", "by eprintln", "info: by info", "warn: by log::warn", "debug: by log::debug"] {
        assert!(said(line), "{line}: {finished}");
    }
    assert!(!finished.lines.iter().any(|line| line.contains("by log::trace")), "{finished}");
}

/// The target property applies to the output of C, too.
#[test]
fn bodies_in_c_print_what_logging_lets_through() {
    let finished = Lfz::run("talking_in_c", &programs().join("TalkingInC.lf"), &[]).succeed();
    let said: Vec<&str> = finished.lines.iter().filter(|line| line.contains("by ")).map(String::as_str).collect();
    let expected = ["by lf_print", "WARNING: by lf_print_warning", "LOG: by lf_print_log", "LOG: by LF_PRINT_LOG"];
    assert_eq!(said, expected, "{finished}");
    let finished = Lfz::run("quiet_in_c", &programs().join("QuietInC.lf"), &[]).succeed();
    let said: Vec<&str> = finished.lines.iter().filter(|line| line.contains("by ")).map(String::as_str).collect();
    assert_eq!(said, ["WARNING: by lf_print_warning", "by printf"], "{finished}");
}

#[test]
fn values_may_be_larger_than_the_stack_of_a_process() {
    let finished = Lfz::run("large_arrays", &programs().join("LargeArrays.lf"), &[]).succeed();
    let said: Vec<&str> = finished.of("sink").filter(|line| line.contains(" bytes of ")).collect();
    assert_eq!(said, ["1000000 bytes of 1", "1000000 bytes of 2", "1000000 bytes of 3"], "{finished}");
}

#[test]
fn the_message_test_receives_everything_in_order() {
    let run = Lfz::run("message_test", Path::new("applications/message_test/src/MessageTest.lf"), &[]);
    let finished = run.succeed();
    let results: Vec<&str> = finished.of("receiver").filter(|line| line.starts_with("received")).collect();
    assert_eq!(results.len(), 1, "{finished}");
    assert!(results[0].starts_with("received 3000 of 3000 messages in order, "), "{finished}");
}

#[test]
fn the_smart_grid_isolates_the_fault() {
    let run = Lfz::run("smart_grid", Path::new("applications/smart_grid/src/SmartGrid.lf"), &[]);
    let finished = run.succeed();
    for (federate, status) in [("a", "A: closed,"), ("b", "B: open,"), ("c", "C: open,"), ("d", "D: closed,")] {
        let lines: Vec<&str> = finished.of(federate).filter(|line| line.contains("reaction time")).collect();
        assert_eq!(lines.len(), 1, "{finished}");
        assert!(lines[0].starts_with(status), "{finished}");
    }
}

/// Nine programs run, eight of which are the members of a bank. The voter masks the fault of three sensors at each tag.
#[test]
fn eight_sensors_of_a_bank_are_heard_at_once() {
    let finished = Lfz::run("voter", Path::new("applications/voter/src/Voter.lf"), &[]).succeed();
    let votes: Vec<&str> = finished.of("voter").filter(|line| line.contains(" values: ")).collect();
    let expected: Vec<String> = (1..=11)
        .map(|vote| format!("info: vote {vote} of {} values: {}", if vote <= 5 { 8 } else { 7 }, 200 + 10 * vote))
        .collect();
    assert_eq!(votes, expected, "{finished}");
}

/// No RTI grants tags in this program, so on a busy computer a message may be tardy. Then the units choose the safe
/// state, and B and C open all the same.
#[test]
fn the_smart_grid_without_grants_isolates_the_fault() {
    let programs = ["After", "ShortAfter", "AfterAndWaits", "Waits"];
    let runs = programs.map(|name| {
        let file = format!("applications/smart_grid/src/SmartGrid{name}.lf");
        Lfz::run(&format!("smart_grid_{name}"), Path::new(&file), &[])
    });
    for run in runs {
        let finished = run.succeed();
        for (federate, status) in [("b", "B: open,"), ("c", "C: open,")] {
            assert!(finished.of(federate).any(|line| line.starts_with(status)), "{finished}");
        }
    }
}

#[test]
fn messages_that_go_from_federate_to_federate_all_come_in_order() {
    let path = |name: &str| format!("applications/message_test/src/{name}.lf");
    let finished = Lfz::run("message_test_direct", Path::new(&path("MessageTestDecentralized")), &[]).succeed();
    assert!(
        finished.of("receiver").any(|line| line.starts_with("received 3000 of 3000 messages in order")),
        "{finished}"
    );
    let finished = Lfz::run("message_delay", Path::new(&path("MessageDelay")), &[]).succeed();
    assert!(finished.of("delays").any(|line| line.starts_with("1000 messages, delay in us: median ")), "{finished}");
}

/// The bounds of a run are the input of the computed offsets.
#[test]
fn a_run_can_be_measured() {
    let file = Path::new("applications/smart_grid/src/SmartGridAfter.lf");
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let bounds = folder.path().join("bounds.yaml");
    let bounds = bounds.to_str().expect("it is a text");
    let finished = Lfz::run("measured", file, &["--measure", bounds]).succeed();
    finished.line(&["12 messages measured"]);
    let mut command = Lfz::command(["plan"]);
    command.arg(file).args(["--stp", bounds]);
    let plan = Run::start(command).succeed();
    plan.line(&["smallest safe offsets of SmartGridAfter"]);
    let centralized = Path::new("applications/smart_grid/src/SmartGrid.lf");
    let refused = Lfz::run("measured-not", centralized, &["--measure", bounds]).finish();
    assert_eq!(refused.code(), 1, "{refused}");
    refused.line(&["does not ask for decentralized coordination"]);
}

/// They share cargo's files, and a second run of the first one changes nothing in it.
#[test]
fn programs_of_the_same_name_in_different_folders_stay_apart() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let run = |name: &str| {
        let file = folder.path().join(name).join("Same.lf");
        Lfz::run(&format!("same_name_{name}"), &file, &[]).finish()
    };
    for name in ["one", "other"] {
        let own = folder.path().join(name);
        std::fs::create_dir(&own).expect("there is room for a folder");
        let program =
            format!("target Rust\nmain reactor {{\n  reaction(startup) {{= println!(\"this is {name}\"); =}}\n}}\n");
        std::fs::write(own.join("Same.lf"), program).expect("there is room for a file");
    }
    for name in ["one", "other", "one", "other"] {
        let finished = run(name);
        assert_eq!(finished.code(), 0, "{finished}");
        finished.line(&["this is", name]);
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

/// Arrays, texts, structs and arrays in ports arrive as they were sent.
#[test]
fn bodies_in_c_send_all_kinds_of_values() {
    let finished = Lfz::run("payloads_in_c", &programs().join("PayloadsInC.lf"), &[]).succeed();
    let said: Vec<&str> = finished.of("sink").filter(|line| !line.contains("info:")).collect();
    let expected = [
        "1: another, 1 elements with the sum 10, 1 and 1.5, 2",
        "later 100",
        "2: two, 2 elements with the sum 41, 2 and 2.5, 4",
        "later 200",
    ];
    assert_eq!(said, expected, "{finished}");
}

/// Structs, lists, texts and times are the same for bodies in C and in Rust.
#[test]
fn federates_in_two_languages_understand_each_other() {
    let finished = Lfz::run("languages", &programs().join("Languages.lf"), &[]).succeed();
    let said = |federate: &str| -> Vec<String> {
        finished.of(federate).filter(|line| !line.contains("info:")).map(str::to_owned).collect()
    };
    let ready = |ready: bool| format!("ready: Some({ready})");
    assert_eq!(said("relay"), [ready(false), ready(true), ready(true), ready(true)], "{finished}");
    let expected: Vec<String> = (0..4)
        .flat_map(|count| {
            let celsius = (20.0 + f64::from(count) * 0.5) * 1.5;
            [
                format!("kind {}, {celsius:.2}, 3 2 1", count.min(1)),
                format!("3 counts, the first is {}; cba; {}", 10 * count + 2, count * 100_000_000),
            ]
        })
        .collect();
    assert_eq!(said("sink"), expected, "{finished}");
}

/// Each federate has the C code of its own file, whose functions have the same names as the other's, and which calls
/// back.
#[test]
fn federates_have_c_beside_their_bodies() {
    let finished = Lfz::run("c_beside", &programs().join("c_beside/CBeside.lf"), &[]).succeed();
    let said: Vec<&str> = finished.of("sum").filter(|line| line.contains(" and ")).collect();
    assert_eq!(said, ["3 and 1", "6 and 2", "9 and 4"], "{finished}");
}

/// Their arguments are all kinds of ports, in the order of the signature.
#[test]
fn functions_are_bodies_of_reactions() {
    let file = programs().join("functions_in_c/FunctionsInC.lf");
    let finished = Lfz::run("functions_in_c", &file, &[]).succeed();
    finished.line(&["inside has 36, 100, 101 and 102"]);
    finished.line(&["changed to 37 and 51"]);
    assert!(!finished.of("changer").any(|line| line.contains("again")), "{finished}");
}

/// State and ports have values of classes.
#[test]
fn bodies_can_be_cpp() {
    let finished = Lfz::run("bodies_in_cpp", &programs().join("BodiesInCpp.lf"), &[]).succeed();
    let said: Vec<&str> = finished.of("both").filter(|line| !line.contains("info:")).collect();
    assert_eq!(said[..6], ["first 1", "first 2", "second 1", "second 2", "both: 1.5, 5", "both: 1.5, 5"], "{finished}");
    let said: Vec<&str> = finished.of("sink").filter(|line| !line.contains("info:")).collect();
    assert_eq!(said, ["sum 9.5", "sum 2.5", "sum 3.5"], "{finished}");
}

/// Parameters of the main reactor can be set, and those that it passes on to contained reactors; values derived from
/// others are fixed.
#[test]
fn command_lines_set_parameters_of_bodies_in_c() {
    let run = |arguments: &[&str]| {
        let file = programs().join("ParametersInC.lf");
        Lfz::run("parameters_in_c", &file, &[&["--"], arguments].concat()).finish()
    };
    let finished = run(&[]);
    assert_eq!(finished.code(), 0, "{finished}");
    finished.line(&["3, 1, 0.50, 0, 10000000, nobody, 4, 6, 2"]);
    let texts = ["--small", "255", "--really", "true", "--name", "some body", "--twice", "9"];
    let finished = run(&[&["--n", "-5", "--real=-1.25", "--wait", "20", "msec"], &texts[..]].concat());
    assert_eq!(finished.code(), 0, "{finished}");
    finished.line(&["-5, 255, -1.25, 1, 20000000, some body, 9, -10, 2"]);
    finished.line(&["child: -5, 20000000"]);
    for (argument, value, told) in [
        ("--small", "256", "256 is no value of the type `uint8_t`"),
        ("--width", "3", "how many reactors or ports there are follows from it when the program is compiled"),
        ("--due", "3 msec", "times of timers, actions, connections or deadlines follow from it"),
        ("--pair", "1", "a value of the type `pair_t` cannot be given here: change its default"),
    ] {
        let finished = run(&[argument, value]);
        assert_eq!(finished.code(), 2, "{finished}");
        finished.line(&["error", argument, told]);
    }
}

#[test]
fn applications_in_c_do_as_those_in_rust() {
    let file = |name: &str| format!("applications/{name}.lf");
    let finished = Lfz::run("smart_grid_in_c", Path::new(&file("smart_grid/src/SmartGridInC")), &[]).succeed();
    for (federate, status) in [("a", "A: closed,"), ("b", "B: open,"), ("c", "C: open,"), ("d", "D: closed,")] {
        assert!(finished.of(federate).any(|line| line.starts_with(status)), "{finished}");
    }
    let finished = Lfz::run("message_test_in_c", Path::new(&file("message_test/src/MessageTestInC")), &[]).succeed();
    let in_order = |line: &str| line.starts_with("received 3000 of 3000 messages in order, ");
    assert!(finished.of("receiver").any(in_order), "{finished}");
}
