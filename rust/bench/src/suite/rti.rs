// SPDX-License-Identifier: Apache-2.0
//! RTIs side by side.

use std::time::Duration;

use lf_bench::results::{Axis, Cell, Comparison, Curve, Figure, Finding, Line, Plot, Row, Table};
use lf_bench::{Graph, Load, Program, Result, Shape, Swarm, Traffic, Usage, micros};

use crate::arguments::Arguments;

/// In nanoseconds of logical time.
const PERIOD_NS: i64 = 1_000_000;
/// How long a federation runs before what it does counts.
const WARM_UP: Duration = Duration::from_millis(300);
/// How long an RTI may take to end when all federates have left.
const END_TIME_OUT: Duration = Duration::from_secs(15);
/// Without a limit of rounds.
const ENDLESS: u64 = u64::MAX;

/// One federation under an RTI, from its start to its end.
struct Run {
    start: Duration,
    traffic: Traffic,
    cpu: Duration,
    usage: Usage,
    stop: Duration,
    succeeded: bool,
}

pub(super) fn throughput(arguments: &Arguments, programs: &[Program]) -> Finding {
    let mut finding = Finding {
        title: "Throughput of the RTI".to_owned(),
        question: "How many messages does the RTI forward, and what does each cost?".to_owned(),
        method: vec![
            format!("Pairs of federates, {} s each, best of {} rounds.", arguments.seconds, arguments.rounds),
            "A sender has up to 8 tags under way; each tag costs NET, TAG, LTC and NET beside its messages.".to_owned(),
            "Own memory is that part of the resident memory that is not of files, such as the program's.".to_owned(),
        ],
        ..Finding::default()
    };
    let mut table = side_by_side(
        "federates, messages per tag",
        programs,
        &["messages/s", "CPU µs/message", "resident MB", "own MB"],
        "throughput, ours / stock",
    );
    let mut rows = Vec::new();
    for (federates, messages) in [(2, 1), (16, 1), (64, 1), (2, 16), (16, 16), (64, 16)] {
        let graph = Graph::new(Shape::Pairs, federates, PERIOD_NS);
        let load = Load { period_ns: PERIOD_NS, messages, rounds_ahead: 8 };
        let all = runs(arguments, programs, &graph, load);
        let rate = |run: &Run| run.traffic.messages_per_second();
        let mut cells = vec![Cell::from(format!("{federates}, {messages}"))];
        for runs in &all {
            cells.extend(match runs {
                Ok(runs) => [
                    Cell::greatest(&each(runs, rate), 0),
                    Cell::least(&each(runs, |run| per(run.cpu, run.traffic.messages)), 2),
                    Cell::least(&each(runs, |run| megabytes(run.usage.resident)), 1),
                    Cell::least(&each(runs, |run| megabytes(run.usage.own)), 1),
                ],
                Err(error) => [error.to_string().into(), Cell::NONE, Cell::NONE, Cell::NONE],
            });
        }
        let what = format!("messages through the RTI, {federates} federates, {messages} per tag");
        finish(&mut finding, &mut cells, &all, (&what, "messages/s"), rate);
        table.row(cells);
        for (program, runs) in programs.iter().zip(&all) {
            let label = format!("{federates} federates, {messages} per tag, {}", program.name());
            rows.extend(runs.as_ref().ok().map(|runs| Row::new(label, program.who(), each(runs, rate))));
        }
    }
    finding.tables.push(table);
    finding.figures.push(Figure {
        title: "Messages per second through the RTI".to_owned(),
        thesis: String::new(),
        caption: "A dot for each round, and the median.".to_owned(),
        plot: Plot::Rows { axis: Axis::logarithmic("messages/s"), rows, marks: Vec::new() },
    });
    finding
}

pub(super) fn growth(arguments: &Arguments, programs: &[Program]) -> Finding {
    let mut finding = Finding {
        title: "Growth of the federation".to_owned(),
        question: "What does a grant take as the federation grows?".to_owned(),
        method: vec![
            format!("{} s each, best of {} rounds.", arguments.seconds, arguments.rounds),
            "CPU: time of the RTI's process for all that leads to a grant, forwarded messages included.".to_owned(),
        ],
        ..Finding::default()
    };
    let mut table = side_by_side("graph, federates", programs, &["grants/s", "CPU µs/grant"], "grants/s, ours / stock");
    for shape in [Shape::Chain, Shape::Star, Shape::Random] {
        let mut curves: Vec<Curve> = programs
            .iter()
            .map(|program| Curve {
                label: program.name().to_owned(),
                who: program.who(),
                line: Line::Solid,
                points: Vec::new(),
            })
            .collect();
        for federates in [2, 8, 32, 128, 500] {
            let graph = Graph::new(shape, federates, PERIOD_NS);
            let load = Load { period_ns: PERIOD_NS, messages: 1, rounds_ahead: 8 };
            let all = runs(arguments, programs, &graph, load);
            let cost = |run: &Run| per(run.cpu, run.traffic.grants);
            let mut cells = vec![Cell::from(format!("{shape}, {federates}"))];
            for (runs, curve) in all.iter().zip(&mut curves) {
                let cpu = runs.as_ref().ok().map(|runs| Cell::least(&each(runs, cost), 2));
                let best = cpu.as_ref().and_then(Cell::value);
                curve.points.extend(best.map(|best| [f64::from(federates), best]));
                cells.extend(match runs {
                    Ok(runs) => [
                        Cell::greatest(&each(runs, |run| run.traffic.grants_per_second()), 0),
                        cpu.unwrap_or(Cell::NONE),
                    ],
                    Err(error) => [error.to_string().into(), Cell::NONE],
                });
            }
            let what = format!("grants, {shape} of {federates} federates");
            finish(&mut finding, &mut cells, &all, (&what, "grants/s"), |run| run.traffic.grants_per_second());
            table.row(cells);
        }
        let around = match shape {
            Shape::Star => "around a star",
            Shape::Random => "in a random graph",
            Shape::Chain | Shape::Pairs => "in a chain",
        };
        finding.figures.push(Figure {
            title: format!("What a grant costs {around}"),
            thesis: String::new(),
            caption: "Processor time of the RTI for all that leads to a grant.".to_owned(),
            plot: Plot::Curves {
                x: Axis::logarithmic("federates"),
                y: Axis::logarithmic("processor time in µs/grant"),
                curves,
                marks: Vec::new(),
            },
        });
    }
    finding.tables.push(table);
    finding
}

pub(super) fn large(arguments: &Arguments, programs: &[Program]) -> Finding {
    let graph = Graph::new(Shape::Random, arguments.large, PERIOD_NS);
    let load = Load { period_ns: PERIOD_NS, messages: 1, rounds_ahead: 8 };
    let headings =
        ["", "start s", "messages", "grants", "messages/s", "CPU s", "resident MB", "own MB", "stop ms", "ended"];
    let mut table = Table::new("", headings);
    for program in programs {
        let mut cells = vec![Cell::from(program.name())];
        match measure(program, &graph, load, Duration::from_secs(arguments.large_seconds)) {
            Ok(run) => cells.extend([
                Cell::number(run.start.as_secs_f64(), 2),
                Cell::count(run.traffic.messages),
                Cell::count(run.traffic.grants),
                Cell::number(run.traffic.messages_per_second(), 0),
                Cell::number(run.cpu.as_secs_f64(), 2),
                Cell::number(megabytes(run.usage.resident), 1),
                Cell::number(megabytes(run.usage.own), 1),
                Cell::number(run.stop.as_secs_f64() * 1e3, 0),
                if run.succeeded { "in order" } else { "with an error" }.into(),
            ]),
            Err(error) => cells.push(error.to_string().into()),
        }
        table.row(cells);
    }
    Finding {
        title: "A large federation".to_owned(),
        question: "Does a federation of hundreds start, run and stop?".to_owned(),
        method: vec![format!(
            "A random federation of {} federates for {} s, once.",
            arguments.large, arguments.large_seconds
        )],
        tables: vec![table],
        ..Finding::default()
    }
}

/// A table with these columns for each program, and one that compares them.
fn side_by_side(first: &str, programs: &[Program], columns: &[&str], compared: &str) -> Table {
    let mut headings = vec![first.to_owned()];
    for program in programs {
        headings.extend(columns.iter().map(|column| format!("{}: {column}", program.name())));
    }
    headings.extend((programs.len() > 1).then(|| compared.to_owned()));
    Table::new("", headings)
}

/// Adds what our best run is beside the other program's, where there is one, to a row and to the finding.
fn finish(
    finding: &mut Finding,
    cells: &mut Vec<Cell>,
    all: &[Result<Vec<Run>>],
    (what, unit): (&str, &str),
    good: impl Fn(&Run) -> f64 + Copy,
) {
    let [Ok(ours), Ok(stock)] = all else { return };
    let comparison = Comparison {
        what: what.to_owned(),
        unit: unit.to_owned(),
        less_is_better: false,
        ours: Cell::greatest(&each(ours, good), 0),
        with: "stock RTI".to_owned(),
        theirs: Cell::greatest(&each(stock, good), 0),
    };
    cells.extend(comparison.ratio().map(|ratio| Cell::number(ratio, 2)));
    finding.compared.push(comparison);
}

/// All runs of each program; they take turns. A program that fails once has failed.
fn runs(arguments: &Arguments, programs: &[Program], graph: &Graph, load: Load) -> Vec<Result<Vec<Run>>> {
    let mut all: Vec<Result<Vec<Run>>> = programs.iter().map(|_| Ok(Vec::new())).collect();
    for _ in 0..arguments.rounds {
        for (program, runs) in programs.iter().zip(&mut all) {
            let Ok(done) = runs else { continue };
            match measure(program, graph, load, Duration::from_secs(arguments.seconds)) {
                Ok(run) => done.push(run),
                Err(error) => *runs = Err(error),
            }
        }
    }
    all
}

fn measure(program: &Program, graph: &Graph, load: Load, time: Duration) -> Result<Run> {
    let mut rti = program.start(graph.federates)?;
    let mut swarm = Swarm::join(rti.port, graph, load)?;
    swarm.run(WARM_UP.min(time), ENDLESS)?;
    let before = rti.usage();
    let traffic = swarm.run(time, ENDLESS)?;
    let usage = rti.usage();
    let stop = swarm.stop()?;
    let succeeded = rti.wait(END_TIME_OUT)?.success();
    Ok(Run { start: swarm.start, traffic, cpu: usage.cpu.saturating_sub(before.cpu), usage, stop, succeeded })
}

fn each(runs: &[Run], value: impl Fn(&Run) -> f64) -> Vec<f64> {
    runs.iter().map(value).collect()
}

/// In µs.
#[expect(clippy::cast_precision_loss, reason = "counts of what happens in minutes are far below 2^53")]
fn per(time: Duration, count: u64) -> f64 {
    micros(time) / (count.max(1) as f64)
}

#[expect(clippy::cast_precision_loss, reason = "memory is far below 2^53 bytes")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
