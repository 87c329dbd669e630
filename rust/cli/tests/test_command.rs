// SPDX-License-Identifier: Apache-2.0
//! `lfz test`: programs that check themselves, and tests of a reactor that a file describes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{folder, said, text};

const FAN: &str = "target Rust
reactor Fan(limit: i32 = 20) {
  input celsius: i32
  output power: bool
  output note: String
  logical action later: i32
  reaction(celsius) -> power, later {=
    let celsius = ctx.get(celsius).unwrap();
    ctx.set(power, celsius > self.limit);
    if celsius == 30 { ctx.schedule_with_v(later, Some(celsius), Asap); }
  =}
  reaction(later) -> note {= ctx.set(note, format!(\"hot: {}\", ctx.get(later).unwrap())); =}
}
";

const DESCRIBED: &str = r#"
reactor: Fan
file: ../src/Fan.lf
cases:
  - name: it switches at the limit
    parameters: { limit: 21 }
    inputs:
      - { at: 0 ms, celsius: 21 }
      - { at: 10 ms, celsius: 22 }
    outputs:
      - { at: 0 ms, power: false }
      - { at: 10 ms, power: true }
  - name: a note follows a microstep later
    inputs: [{ at: 5 ms, celsius: 30 }]
    outputs: [{ at: [5 ms, 1], note: "\"hot: 30\".to_owned()" }]
  - name: a wrong value
    inputs: [{ at: 10 ms, celsius: 22 }]
    outputs: [{ at: 10 ms, power: false }]
  - name: a value that does not come
    outputs: [{ at: 10 ms, power: false }]
    until: 20 ms
  - name: a value too many
    inputs: [{ at: 0 ms, celsius: 1 }, { at: 10 ms, celsius: 22 }]
    outputs: [{ at: 0 ms, power: false }]
"#;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).arg("test").args(arguments).env("CARGO_NET_OFFLINE", "true");
    said(command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0"))
}

/// Returns the lines of an output without the times that tests took.
fn lines(output: &Output) -> Vec<String> {
    text(&output.stdout).lines().map(|line| line.split(" (").next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn values_are_set_and_compared_at_their_tags() {
    let folder = folder(&[("src/Fan.lf", FAN), ("test/fan.test.yaml", DESCRIBED)]);
    let output = run(folder.path(), &["--junit", "report.xml"]);
    let expected = [
        "test/fan: it switches at the limit ... ok",
        "test/fan: a note follows a microstep later ... ok",
        "test/fan: a wrong value ... FAILED",
        "test/fan: a value that does not come ... FAILED",
        "test/fan: a value too many ... FAILED",
        "2 passed, 3 failed",
    ];
    let said = text(&output.stderr);
    assert_eq!((lines(&output), output.status.code()), (expected.map(str::to_owned).to_vec(), Some(1)), "{said}");
    for reason in [
        "power is true at (10000000, 0), instead of false at (10000000, 0)",
        "the number of values of power",
        "power is true at (10000000, 0), where it should be absent",
    ] {
        assert!(said.contains(reason), "{reason}: {said}");
    }
    let report = fs::read_to_string(folder.path().join("report.xml")).expect("it is written");
    assert!(report.contains("tests=\"5\" failures=\"3\""), "{report}");
    assert!(report.contains("<testcase name=\"test/fan: a wrong value\""), "{report}");
}

#[test]
fn programs_that_check_themselves_are_tests_in_every_language() {
    let folder = folder(&[
        (
            "test/Good.lf",
            "target Rust { timeout: 1 ms }\nmain reactor { reaction(startup) {= assert!(1 + 1 == 2); =} }\n",
        ),
        ("test/deep/Bad.ulf", "main reactor { reaction(startup) {= validate(1 + 1 == 3); =} }\n"),
        (
            "test/deep/Part.lf",
            "target C\nreactor Gain { input x: int output y: int reaction(x) -> y {= lf_set(y, 2 * x->value); =} }\n",
        ),
        (
            "test/gain.test.yaml",
            "reactor: Gain\nfile: deep/Part.lf\ncases:\n  - name: it doubles\n    inputs: [{ at: 1 s, x: 4 }]\n    \
             outputs: [{ at: 1 s, y: 8 }]\n  - name: it does not triple\n    inputs: [{ at: 1 s, x: 4 }]\n    \
             outputs: [{ at: 1 s, y: 12 }]\n",
        ),
        ("other/Endless.lf", "target Rust\nmain reactor { timer t(0, 1 s) reaction(t) {= =} }\n"),
    ]);
    let listed = run(folder.path(), &["--list"]);
    let names = ["test/Good", "test/deep/Bad", "test/gain: it doubles", "test/gain: it does not triple"];
    assert_eq!(lines(&listed), names);
    let output = run(folder.path(), &[]);
    let expected = [
        "test/Good ... ok",
        "test/deep/Bad ... FAILED",
        "test/gain: it doubles ... ok",
        "test/gain: it does not triple ... FAILED",
        "2 passed, 2 failed",
    ];
    assert_eq!(lines(&output), expected, "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("y at (1000000000, 0) should be 12 at (1000000000, 0)"));
    assert_eq!(
        lines(&run(folder.path(), &["--filter", "doubles"])),
        ["test/gain: it doubles ... ok", "1 passed, 0 failed"]
    );
    assert_eq!(lines(&run(folder.path(), &["other", "--timeout", "100ms"]))[1], "0 passed, 1 failed");
}

#[test]
fn physical_actions_are_scheduled_at_their_times() {
    let body = |language: &str, get: &str| {
        format!(
            "target {language}\nreactor Button {{\n  physical action pressed(2 ms): int\n  physical action bell\n  \
             output power: int\n  output rung: bool\n  reaction(pressed) -> power {{= {get} =}} deadline(1 nsec) {{= \
             {} =}}\n  reaction(bell) -> rung {{= {} =}}\n}}\n",
            if language == "C" { "lf_print_error_and_exit(\"too late\");" } else { "panic!(\"too late\");" },
            if language == "C" { "lf_set(rung, true);" } else { "ctx.set(rung, true);" },
        )
    };
    let described = |file: &str| {
        format!(
            "reactor: Button\nfile: {file}\ncases:\n  - name: it is pressed twice\n    inputs:\n      - {{ at: 10 ms, \
             pressed: 3 }}\n      - {{ at: 1 hour, pressed: 4, bell: }}\n    outputs:\n      - {{ at: 12 ms, power: 3 \
             }}\n      - {{ at: [1 hour, 1], rung: true }}\n      - {{ at: 3600002 ms, power: 4 }}\n"
        )
    };
    let rust = body("Rust", "ctx.set(power, ctx.get(pressed).unwrap());").replace(": int", ": i32");
    let folder = folder(&[
        ("src/Button.lf", &rust),
        ("src/ButtonInC.lf", &body("C", "lf_set(power, pressed->value);")),
        ("test/button.test.yaml", &described("../src/Button.lf")),
        ("test/button_in_c.test.yaml", &described("../src/ButtonInC.lf")),
    ]);
    let output = run(folder.path(), &[]);
    let expected = [
        "test/button: it is pressed twice ... ok",
        "test/button_in_c: it is pressed twice ... ok",
        "2 passed, 0 failed",
    ];
    assert_eq!(lines(&output), expected, "{}", text(&output.stderr));
}

#[test]
fn names_that_a_reactor_does_not_have_are_told_before_anything_is_built() {
    let button = "target Rust\nreactor Button {\n  input x: i32\n  physical action pressed\n  \
                  physical action level: u8\n  output y: i32\n}\n";
    for (case, expected) in [
        ("inputs: [{ at: 0 ms, z: 1 }]", "`Button` has no input `z`; it has `x`, `level`, `pressed`"),
        ("outputs: [{ at: 0 ms, x: 1 }]", "`Button` has no output `x`; it has `y`"),
        ("inputs: [{ at: 0 ms, x: }]", "`x` has no value"),
        ("inputs: [{ at: 0 ms, level: }]", "the physical action `level` needs a value"),
        ("inputs: [{ at: 0 ms, pressed: 1 }]", "the physical action `pressed` has no values: write `pressed:`"),
    ] {
        let described = format!("reactor: Button\nfile: Button.lf\ncases:\n  - name: a\n    {case}\n");
        let folder = folder(&[("test/Button.lf", button), ("test/a.test.yaml", &described)]);
        let said = text(&run(folder.path(), &[]).stderr);
        assert!(said.starts_with(&format!("error: test/a.test.yaml: a: {expected}")), "{said}");
    }
    let other =
        folder(&[("test/Button.lf", button), ("test/a.test.yaml", "reactor: Fan\nfile: Button.lf\ncases: []\n")]);
    let said = text(&run(other.path(), &[]).stderr);
    assert!(said.contains("test/Button.lf has no reactor `Fan`; it has `Button`"), "{said}");
}

#[test]
fn what_is_no_test_is_told() {
    let folder = folder(&[("src/Fan.lf", FAN), ("empty/README.md", ""), ("bad/a.test.yaml", "reactor: Fan\nfil: x\n")]);
    for (path, expected) in [
        ("nowhere", "error: nowhere does not exist: name the folder of the tests, or a single one"),
        ("empty", "error: there are no tests in empty: a test is a program with a main reactor"),
        ("bad", "error: bad/a.test.yaml:2:1: unknown field `fil`"),
    ] {
        let said = text(&run(folder.path(), &[path]).stderr);
        assert!(said.starts_with(expected), "{said}");
    }
    let case = "reactor: Fan\nfile: ../src/Fan.lf\ncases:\n  - { name: a, inputs: [{ celsius: 1 }] }\n";
    fs::write(folder.path().join("bad/a.test.yaml"), case).expect("it can be written");
    let said = text(&run(folder.path(), &["bad"]).stderr);
    assert!(said.starts_with("error: bad/a.test.yaml: a: each entry has an `at`"), "{said}");
}

/// Two sources and a sink that compares them; a value too many is to be found in every world.
fn federation(target: &str, last: u32) -> String {
    format!(
        "target Rust {{ timeout: 1 s, {target} }}
reactor Source {{
  output y: u32
  timer t(0, 100 ms)
  state count: u32 = 0
  reaction(t) -> y {{= self.count += 1; ctx.set(y, self.count); =}}
}}
reactor Sink {{
  input y: u32
  input z: u32
  state seen: u32 = 0
  reaction(y, z) {{=
    self.seen += 1;
    assert_eq!((ctx.get(y), ctx.get(z)), (Some(self.seen), Some(self.seen)));
    println!(\"{{}} came at {{:?}}\", self.seen, ctx.get_physical_time());
  =}}
  reaction(shutdown) {{= assert_eq!(self.seen, {last}, \"the last value\"); =}}
}}
federated reactor {{
  one = new Source()
  two = new Source()
  sink = new Sink()
  one.y -> sink.y after 50 ms
  two.y -> sink.z after 50 ms
}}
"
    )
}

/// Values and tags are the same in every world, and a world is the same in each run: physical times, too. With either
/// coordination, and encrypted.
#[test]
fn federations_run_in_virtual_time_with_the_network_of_a_seed() {
    let waits = |program: &str| program.replace("  sink = new", "  @maxwait(50 ms)\n  sink = new");
    let folder = folder(&[
        ("test/Good.lf", &federation("clock-sync: on", 10)),
        ("test/Decentralized.lf", &waits(&federation("coordination: decentralized", 10))),
        ("test/Encrypted.lf", &federation("security: noise", 10)),
        ("test/Wrong.lf", &federation("clock-sync: off", 11)),
        ("test/Alone.lf", "target Rust { timeout: 24 h }\nmain reactor { timer t(0, 1 h) reaction(t) {= =} }\n"),
    ]);
    let output = run(folder.path(), &["--seed", "4..6"]);
    let expected = [
        "test/Alone ... ok",
        "test/Decentralized, seed 4 ... ok",
        "test/Decentralized, seed 5 ... ok",
        "test/Encrypted, seed 4 ... ok",
        "test/Encrypted, seed 5 ... ok",
        "test/Good, seed 4 ... ok",
        "test/Good, seed 5 ... ok",
        "test/Wrong, seed 4 ... FAILED",
        "test/Wrong, seed 5 ... FAILED",
        "7 passed, 2 failed",
    ];
    assert_eq!(lines(&output), expected, "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("the last value"));

    let times = |seed: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.current_dir(folder.path()).args(["run", "test/Good.lf", "--seed", seed]);
        command.env("CARGO_NET_OFFLINE", "true").env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0");
        let output = said(&mut command);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let came: Vec<_> =
            text(&output.stdout).lines().filter(|line| line.contains(" came at ")).map(str::to_owned).collect();
        assert_eq!(came.len(), 10);
        came
    };
    assert_eq!(times("4"), times("4"));
    assert_ne!(times("4"), times("5"));
}

/// Nobody waits in silence: what virtual time does not have is refused, and a run in which nothing can happen any more
/// ends.
#[test]
fn what_has_no_virtual_time_is_refused_by_name() {
    let transient = federation("", 10).replace("  one = new", "  @transient\n  one = new");
    let endless = "target C { keepalive: true }\nreactor Node { reaction(startup) {= =} }\nfederated reactor {\n  \
                   one = new Node()\n  two = new Node()\n}\n";
    let folder = folder(&[
        ("test/Tls.lf", &federation("comm-type: TLS", 10)),
        ("test/Transient.lf", &transient),
        ("endless/Endless.lf", endless),
    ]);
    let output = run(folder.path(), &["--seed", "1"]);
    assert_eq!(lines(&output).last().map(String::as_str), Some("0 passed, 2 failed"));
    let reasons = text(&output.stderr);
    assert!(reasons.contains("--seed: a virtual network has no TLS"), "{reasons}");
    assert!(reasons.contains("--seed: transient federates come when the user starts them"), "{reasons}");
    let output = run(folder.path(), &["endless", "--seed", "1"]);
    let reasons = text(&output.stderr);
    assert!(reasons.contains("of virtual time, all participants wait for what never comes"), "{reasons}");
    for (seeds, reason) in [("x", "\"x\" is no number"), ("5..5", "no seeds between these two")] {
        let refused = run(folder.path(), &["--seed", seeds]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(text(&refused.stderr).contains(reason), "{}", text(&refused.stderr));
    }
}
