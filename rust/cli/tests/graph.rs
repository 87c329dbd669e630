// SPDX-License-Identifier: Apache-2.0
//! Pictures of programs by `lfz graph`.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{folder, said, text};

fn graph(folder: &Path, arguments: &[&str]) -> Output {
    said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder).arg("graph").args(arguments))
}

/// Returns the picture of a program, without its rules of style.
fn drawn(program: &str, files: &[(&str, &str)], arguments: &[&str]) -> String {
    let folder = folder(files);
    fs::write(folder.path().join("P.lf"), program).expect("it can be written");
    let output = graph(folder.path(), &[&["P.lf"], arguments].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let picture = text(&output.stdout);
    let (head, rest) = picture.split_once("<style>").expect("it has rules");
    let (_, parts) = rest.split_once("</style>\n").expect("they end");
    format!("{head}{parts}")
}

const FAN: &str = "target Rust
reactor Thermometer {
  output celsius: i32
  timer t(0, 250 ms)
  reaction(t) -> celsius {= =}
}
reactor Fan {
  input celsius: i32
  logical action later(1 s)
  reaction(celsius) -> later {= =} deadline(5 ms) {= =}
  reaction named(later) celsius {= =}
  reaction(startup, shutdown) {= =}
}
";

/// All kinds of elements, edges and labels.
const MODES: &str = "target Rust
reactor Machine {
  input x: {= Vec<u8> =}
  output y: {= Vec<u8> =}
  physical action button(0, 3 ms)
  initial mode Idle {
    reaction(x) -> reset(Busy) {= =}
    reaction(reset) -> y {= =}
  }
  mode Busy {
    timer t(5 ms, 100 ms)
    logical action done
    reaction(t) -> done {= =}
    reaction(done) x -> history(Idle), y {= =}
  }
  reaction(button) {= =}
  watchdog w(1 s) {= =}
  reaction(startup) -> w, button {= =}
}
main reactor {
  m = new Machine()
  n = new Machine()
  m.y ~> n.x
  n.y -> m.x after 0
}
";

const BANK: &str = "target Rust
reactor Sensor {
  output value: i32
}
reactor Voter(n: usize = 3) {
  input[n] values: i32
}
main reactor {
  sensors = new[3] Sensor()
  voter = new Voter()
  sensors.value -> voter.values after 1 ms
}
";

#[test]
fn a_federation_shows_delays_and_where_its_federates_run() {
    let program = format!(
        "{FAN}federated reactor at 10.0.0.9 {{
  thermometer = new Thermometer()
  fan = new Fan()
  thermometer.celsius -> fan.celsius after 10 ms
}}
"
    );
    insta::assert_snapshot!(drawn(&program, &[], &[]));
    let board = "rti: { ip: 10.0.0.9 }\nfederates:\n  fan: { platform: qemu_cortex_m3, ip: 10.0.0.2 }\n";
    let files = [("boards.yaml", board)];
    let picture = drawn(&program, &files, &["--deployment", "boards.yaml", "--depth", "1"]);
    insta::assert_snapshot!("boards", picture);
}

#[test]
fn modes_contain_their_elements() {
    insta::assert_snapshot!(drawn(MODES, &[], &[]));
}

#[test]
fn a_bank_is_one_reactor_or_all_its_members() {
    insta::assert_snapshot!(drawn(BANK, &[], &[]));
    let expanded = drawn(BANK, &[], &["--expand-banks"]);
    for member in ["sensors[0]", "sensors[1]", "sensors[2]"] {
        assert!(expanded.contains(member), "{expanded}");
    }
    assert!(!expanded.contains("sensors[3]"), "{expanded}");
}

/// The rules of each background are those that are asked for, and no picture has a script.
#[test]
fn pictures_have_the_colours_of_their_background() {
    let folder = folder(&[("P.lf", BANK)]);
    let picture = |theme| text(&graph(folder.path(), &["P.lf", "--theme", theme]).stdout);
    let [auto, light, dark] = ["auto", "light", "dark"].map(picture);
    assert!(auto.contains("prefers-color-scheme:dark") && !auto.contains("<script"));
    assert!(light.contains("canvas{fill:#ffffff}") && !light.contains("canvas{fill:#0d1117}"));
    assert!(dark.contains("canvas{fill:#0d1117}") && !dark.contains("prefers-color-scheme"));
    insta::assert_snapshot!(auto.split_once("</style>").expect("it has rules").0);
}

#[test]
fn equal_programs_have_equal_pictures_in_files_too() {
    let folder = folder(&[("P.lf", MODES)]);
    let printed = graph(folder.path(), &["P.lf"]).stdout;
    let output = graph(folder.path(), &["P.lf", "-o", "P.svg"]);
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    assert_eq!(fs::read(folder.path().join("P.svg")).expect("it was written"), printed);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.args(["graph", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("lfz can be started");
    child.stdin.take().expect("it is a pipe").write_all(MODES.as_bytes()).expect("it is read");
    let input = text(&child.wait_with_output().expect("it ends").stdout);
    assert_eq!(input, text(&printed).replace(">P<", ">standard_input<").replace(">P:", ">standard_input:"));
}

/// The README has a picture that shows what the program is.
#[test]
fn the_picture_in_the_readme_is_the_programs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let program = "applications/smart_grid/src/SmartGrid.lf";
    let deployment = "applications/smart_grid/deployment/topology2.yaml";
    for (file, depth) in [("docs/guide/src/pictures/smart-grid.svg", "1"), ("docs/guide/src/pictures/units.svg", "9")] {
        let output = graph(&root, &[program, "--deployment", deployment, "--depth", depth]);
        let picture = text(&output.stdout);
        if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
            fs::write(root.join(file), &picture).expect("it can be written");
        }
        let kept = fs::read_to_string(root.join(file)).unwrap_or_default();
        assert!(
            kept == picture,
            "{file} is older than the program: lfz graph {program} --deployment {deployment} \
            --depth {depth} -o {file}"
        );
    }
}

#[test]
fn errors_are_told_as_by_check() {
    let folder = folder(&[("P.lf", "target Rust\nmain reactor {\n  a = new A()\n}\n")]);
    let output = graph(folder.path(), &["P.lf"]);
    let check = said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder.path()).args(["check", "P.lf"]));
    assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(1), true));
    assert_eq!(text(&output.stderr), text(&check.stderr));
    assert!(text(&output.stderr).contains("P.lf:3:"));
    let output = graph(folder.path(), &["missing.lf"]);
    assert!(text(&output.stderr).contains("missing.lf"), "{}", text(&output.stderr));
    fs::write(folder.path().join("P.lf"), BANK).expect("it can be written");
    let output = graph(folder.path(), &["P.lf", "-o", "no/folder.svg"]);
    assert!(text(&output.stderr).contains("error: no/folder.svg cannot be written: "), "{}", text(&output.stderr));
}
