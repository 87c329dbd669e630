// SPDX-License-Identifier: Apache-2.0
//! The table of exit statuses in the guide is true: the test causes each way in which a participant can end, with both
//! coordinations, by `lfz run` and with participants that are started by hand.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use lf_federations::{Lfz, Participant, Run, programs};
use rustix::process::Signal;

/// The statuses of the federate that ends, of the other one, of the RTI and of `lfz run`; `None` for a participant that
/// does not exist or continues.
type Statuses = [Option<i32>; 4];

/// The number of rows that run in parallel; participants mostly wait.
const AT_A_TIME: usize = 6;

/// The receiver of a signal once both federates run.
#[derive(Clone, Copy)]
enum Target {
    Source,
    Rti,
    Lfz,
}

/// The actions that make participants end in some way.
#[derive(Clone, Default)]
struct Way {
    /// The behavior of the first federate, which the program reads in the environment.
    does: String,
    /// Options of the first federate, and of all in `lfz run`.
    options: &'static [&'static str],
    /// Options of `lfz run` itself.
    run_options: &'static [&'static str],
    rti_options: &'static [&'static str],
    signal: Option<(Target, Signal)>,
    /// Whether another first federate joins when both run.
    joins_late: bool,
}

impl Way {
    /// Returns the way that a row of the table names.
    fn of(row: &str) -> Self {
        let signal = |target, signal| Self { signal: Some((target, signal)), ..Self::default() };
        match row {
            "its `timeout` is over" => Self { options: &["-o", "100 msec"], ..Self::default() },
            "SIGKILL" => signal(Target::Source, Signal::KILL),
            "SIGKILL, and the RTI has `--go-on-after-loss`" => {
                Self { rti_options: &["--go-on-after-loss"], ..signal(Target::Source, Signal::KILL) }
            }
            "SIGTERM" => signal(Target::Source, Signal::TERM),
            "SIGINT" => signal(Target::Source, Signal::INT),
            "SIGKILL to the RTI" => signal(Target::Rti, Signal::KILL),
            "SIGTERM to the RTI" => signal(Target::Rti, Signal::TERM),
            "an unknown option" => Self { options: &["--no-such-option"], ..Self::default() },
            "another federation id than the RTI's" => Self { options: &["--id", "another"], ..Self::default() },
            "it joins when all are there" => Self { joins_late: true, ..Self::default() },
            "^C for `lfz run`" => signal(Target::Lfz, Signal::INT),
            "SIGTERM to `lfz run`" => signal(Target::Lfz, Signal::TERM),
            "`--timeout` of `lfz run` is over" => Self { run_options: &["--timeout", "100 ms"], ..Self::default() },
            does => {
                let does = does.replace('`', "");
                let program = std::fs::read_to_string(programs().join("Ends.lf")).expect("the program is there");
                assert!(program.contains(&format!("\"{does}\" =>")), "no row is without a test: {does}");
                Self { does, ..Self::default() }
            }
        }
    }
}

/// Returns the rows of the guide's table.
fn table() -> Vec<(String, Statuses)> {
    let row = |row: Vec<String>| {
        let statuses: Vec<_> = row[1..].iter().map(|cell| cell.parse().ok()).collect();
        (row[0].clone(), statuses.try_into().expect("a row has four statuses"))
    };
    lf_federations::table("errors.md", "how a federate ends").into_iter().map(row).collect()
}

/// Writes the program of these tests, with this coordination.
fn program(folder: &Path, coordination: &str) -> PathBuf {
    let text = std::fs::read_to_string(programs().join("Ends.lf")).expect("the program is there");
    let target = format!("target Rust {{ coordination: {coordination} }}");
    let file = folder.join("Ends.lf");
    std::fs::write(&file, text.replacen("target Rust", &target, 1)).expect("it can be written");
    file
}

fn find<'a>(participants: &'a [Participant], text: &str) -> &'a Participant {
    participants.iter().find(|participant| participant.command.contains(text)).expect("it takes part")
}

/// Returns the exit status of `lfz run`.
fn by_lfz(test: &str, file: &Path, way: &Way) -> i32 {
    let options = way.run_options.iter().chain(&["--"]).chain(way.options).copied();
    let mut command = Lfz::run_command(test, file, &options.collect::<Vec<_>>());
    command.env("ENDS", &way.does);
    let mut run = Run::start(command);
    if let Some((target, signal)) = way.signal {
        run.wait_for("the source runs");
        run.wait_for("the sink runs");
        match target {
            Target::Source => find(&run.participants(), "ends-source").signal(signal),
            Target::Rti => find(&run.participants(), " rti ").signal(signal),
            Target::Lfz => run.signal(signal),
        }
    }
    let finished = run.finish();
    println!("{finished}");
    finished.code()
}

/// Returns the exit statuses of the two federates and the RTI, as far as they end.
fn by_hand(federates: &BTreeMap<String, PathBuf>, way: &Way, expected: &Statuses) -> [Option<i32>; 3] {
    let (mut rti, port) = Lfz::rti(&[&["-n", "2", "-i", "ends"], way.rti_options].concat());
    let start = |name: &str, options: &[&str]| {
        let mut command = Command::new(&federates[name]);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "ends"]).args(options).env("ENDS", &way.does);
        Run::start(command)
    };
    let mut sink = start("sink", &[]);
    let mut source = start("source", way.options);
    if way.signal.is_some() || way.joins_late {
        source.wait_for("the source runs");
        sink.wait_for("the sink runs");
    }
    match way.signal {
        Some((Target::Source, signal)) => source.signal(signal),
        Some((Target::Rti, signal)) => rti.signal(signal),
        Some((Target::Lfz, _)) | None => {}
    }
    if way.joins_late {
        let late = start("source", &[]).finish();
        rti.wait_for("refused");
        println!("{late}");
        // It has not disturbed the others: they continue.
        return [Some(late.code()), None, None];
    }
    let ends = [source, sink, rti].into_iter().zip(expected).map(|(run, expected)| {
        expected.map(|_| {
            let finished = run.finish();
            println!("{finished}");
            // A participant that ends early reports the reason.
            let says = finished.lines.iter().any(|line| line.contains("error:") || line.contains("panicked"));
            assert!(says || ![1, 2, 101].contains(&finished.code()), "{finished}");
            finished.code()
        })
    });
    ends.collect::<Vec<_>>().try_into().expect("there are three")
}

fn check(coordination: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = program(folder.path(), coordination);
    let test = format!("statuses_{coordination}");
    let federates = Lfz::build(&test, &file);
    let rows = table();
    assert!(rows.len() > 10, "the table is found");
    let found = |(row, expected): &(String, Statuses)| {
        let way = Way::of(row);
        println!("-- {row}");
        let [federate, other, rti] = by_hand(&federates, &way, expected);
        (row.clone(), [federate, other, rti, expected[3].map(|_| by_lfz(&test, &file, &way))])
    };
    let mut all = Vec::new();
    for rows in rows.chunks(AT_A_TIME) {
        thread::scope(|scope| {
            let runs: Vec<_> = rows.iter().map(|row| scope.spawn(|| found(row))).collect();
            all.extend(runs.into_iter().map(|run| run.join().expect("it has run")));
        });
    }
    assert_eq!(all, rows);
}

#[test]
fn participants_end_with_the_statuses_of_the_guide_with_centralized_coordination() {
    check("centralized");
}

#[test]
fn participants_end_with_the_statuses_of_the_guide_with_decentralized_coordination() {
    check("decentralized");
}
