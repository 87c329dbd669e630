// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization: the algorithms in virtual time, the exchanges before the start, and what an oscilloscope saw.

use std::path::Path;

use lf_bench::results::{Axis, Cell, Comparison, Curve, Figure, Finding, Line, Mark, Plot, Row, Table, Who};
use lf_bench::{InitialExchanges, Pins, Program, Result, SPREAD_MAX, clock, micros, read_pins};

use crate::arguments::Arguments;

/// Federations of the exchanges before the start, for each round.
const INITIAL_RUNS: u32 = 10;
/// The thesis's drift after the exchanges before the start, in µs/s.
const THESIS_DRIFT: f64 = 26.0;

pub(super) fn clocks(arguments: &Arguments) -> Finding {
    let headings =
        ["network, mode", "ours: median", "ours: worst", "stock algorithm: median", "stock algorithm: worst"];
    let mut table = Table::new("", headings);
    let mut compared = Vec::new();
    for network in clock::Network::ALL {
        for (mode, on) in [("init", false), ("on", true)] {
            let mut seeds = [const { Vec::new() }; 4];
            for seed in 1..=u64::from(arguments.rounds) {
                let ours = clock::run(&mut clock::Ours::default(), &network, seed, on);
                let stock = clock::run(&mut clock::Stock::default(), &network, seed, on);
                for (index, samples) in [ours, stock].iter().enumerate() {
                    seeds[2 * index].push(micros(samples.percentile(50)));
                    seeds[2 * index + 1].push(micros(samples.percentile(100)));
                }
            }
            let cells = seeds.map(|seeds| Cell::greatest(&seeds, 1));
            compared.push(Comparison {
                what: format!("median error of the clock, {}, {mode}", network.name),
                unit: "µs".to_owned(),
                less_is_better: true,
                ours: cells[0].clone(),
                with: "stock algorithm".to_owned(),
                theirs: cells[2].clone(),
            });
            table.row([Cell::from(format!("{}, {mode}", network.name))].into_iter().chain(cells).collect());
        }
    }
    Finding {
        title: "Error of a federate's clock".to_owned(),
        question: "How far are clocks apart, once and while the program runs?".to_owned(),
        method: vec![
            "In µs over 60 s, in virtual time; the first 5 s after the start do not count.".to_owned(),
            format!(
                "The clock is 1 s off and gains {} µs/s; period {} ms, {} trials, attenuation {}; worst of {} seeds.",
                clock::DRIFT_PPB / 1000,
                clock::PERIOD_NS / 1_000_000,
                clock::TRIALS,
                clock::ATTENUATION,
                arguments.rounds
            ),
            "The stock federate discards the exchanges before the start when their round trips differ by 100 µs or \
             more, and then begins with the whole offset."
                .to_owned(),
        ],
        compared,
        tables: vec![table],
        figures: vec![in_virtual_time()],
        limits: vec![
            "The thesis measured two boards with an oscilloscope; these are the algorithms in virtual time, under \
             delays that a seed decides. Their drift was made the thesis's."
                .to_owned(),
        ],
    }
}

/// Ours in a quiet network, looked at as often as the thesis did.
fn in_virtual_time() -> Figure {
    let seen = |on: bool| -> Vec<[f64; 2]> {
        let offsets = clock::offsets(&mut clock::Ours::default(), &clock::Network::QUIET, 1, on);
        let seconds = offsets.into_iter().filter(|(at, _)| at % 1_000_000_000 == 0);
        #[expect(clippy::cast_precision_loss, reason = "a minute is far below 2^53 ns")]
        seconds.map(|(at, offset)| [at as f64 / 1e9, offset as f64 / 1e3]).collect()
    };
    let points = seen(false);
    // The clock gains evenly, so all of its looks are on the line from the first to the last one.
    let line = match points[..] {
        [[begin, first], .., [end, last]] => Some((first, (last - first) / (end - begin))),
        _ => None,
    };
    let mut curves = with_line("init", Who::Ours, points, line);
    curves.push(Curve { label: "on".to_owned(), who: Who::OursToo, line: Line::Points, points: seen(true) });
    offset_figure("Offset of a drifting clock, in virtual time", curves)
}

/// A curve of points, and the line through them by its value at 0 and its slope.
fn with_line(name: &str, who: Who, points: Vec<[f64; 2]>, line: Option<(f64, f64)>) -> Vec<Curve> {
    let end = points.last().map_or(0.0, |point| point[0]);
    let line = line.map(|(begin, slope)| Curve {
        label: format!("{name}: {slope:.1} µs/s"),
        who,
        line: Line::Solid,
        points: vec![[0.0, begin], [end, begin + slope * end]],
    });
    let points = Curve { label: name.to_owned(), who, line: Line::Points, points };
    [points].into_iter().chain(line).collect()
}

/// A figure as the thesis's, with its slope beside the first curve.
fn offset_figure(title: &str, mut curves: Vec<Curve>) -> Figure {
    let points = curves.first().map(|curve| curve.points.as_slice()).unwrap_or_default();
    let (begin, end) = (points.first().map_or(0.0, |point| point[1]), points.last().map_or(0.0, |point| point[0]));
    curves.push(Curve {
        label: format!("thesis: {THESIS_DRIFT} µs/s"),
        who: Who::Thesis,
        line: Line::Dashed,
        points: vec![[0.0, begin], [end, begin + THESIS_DRIFT * end]],
    });
    Figure {
        title: title.to_owned(),
        thesis: "figure 6.3".to_owned(),
        caption: "Each look at the clocks, and the line of regression. Of the thesis's line only the slope is known; \
                  it is drawn from our first point on."
            .to_owned(),
        plot: Plot::Curves {
            x: Axis::linear("time in s"), y: Axis::linear("offset in µs"), curves, marks: Vec::new()
        },
    }
}

/// What was recorded at two pins that two participants toggle at the same logical times.
pub(super) fn pins(lfz: &Path, file: &Path) -> Result<Finding> {
    let Pins { reference, compared, points, line, worst_us } = read_pins(lfz, file)?;
    let (begin, drift) = line;
    let mut table = Table::new("", ["edges", "at the start µs", "drift µs/s", "worst µs"]);
    table.row(vec![
        Cell::count(points.len() as u64),
        Cell::number(begin, 1),
        Cell::number(drift, 2),
        Cell::number(worst_us, 1),
    ]);
    Ok(Finding {
        title: "Clocks at two pins".to_owned(),
        question: "How far apart do two participants toggle their pins at the same logical times?".to_owned(),
        method: vec![format!(
            "The edges of the second pin, {compared}, after those of the first one, {reference}, as recorded in {}.",
            file.display()
        )],
        compared: vec![Comparison {
            what: "drift of the clocks".to_owned(),
            unit: "µs/s".to_owned(),
            less_is_better: true,
            ours: Cell::number(drift.abs(), 2),
            with: "thesis, init".to_owned(),
            theirs: Cell::number(THESIS_DRIFT, 0),
        }],
        tables: vec![table],
        figures: vec![offset_figure("Offset of two pins", with_line("recorded", Who::Ours, points, Some(line)))],
        limits: vec![
            "A recording by lfz run --vcd has the time that each participant takes for the federation's: it shows how \
             late its reactions were. How far clocks were off as well is only in one with a time that both share."
                .to_owned(),
        ],
    })
}

pub(super) fn initial(arguments: &Arguments, programs: &[Program]) -> Result<Finding> {
    let headings = ["federates, RTI", "thrown away", "spread: median", "90 %", "most", "answer: median", "99 %"];
    let mut table = Table::new("", headings);
    let mut rows = Vec::new();
    for federates in [1, 3, 8, 32] {
        let mut seen: Vec<_> = programs.iter().map(|_| InitialExchanges::default()).collect();
        for _ in 0..INITIAL_RUNS * arguments.rounds {
            for (program, seen) in programs.iter().zip(&mut seen) {
                seen.run(program, federates)?;
            }
        }
        for (program, seen) in programs.iter().zip(&seen) {
            let name = format!("{federates}, {}", program.name());
            let thrown_away = format!("{} of {}", seen.thrown_away, seen.spreads.count());
            let mut cells = vec![name.into(), thrown_away.into()];
            let times = [50, 90, 100].map(|percent| seen.spreads.percentile(percent));
            let times = times.into_iter().chain([50, 99].map(|percent| seen.answers.percentile(percent)));
            cells.extend(times.map(|time| Cell::number(micros(time), 1)));
            table.row(cells);
            let plural = if federates == 1 { "" } else { "s" };
            let label = format!("{federates} federate{plural}, {}", program.name());
            rows.push(Row::new(label, program.who(), seen.spreads.clone().into_iter().map(micros).collect()));
        }
    }
    Ok(Finding {
        title: "Exchanges before the start".to_owned(),
        question: "How evenly does the RTI answer federates that all come at once?".to_owned(),
        method: vec![
            format!("Ten exchanges in µs; {} federations each.", INITIAL_RUNS * arguments.rounds),
            format!(
                "The spread is the standard deviation of a federate's round trips; from {:.0} µs on, a stock federate \
                 throws them away.",
                micros(SPREAD_MAX)
            ),
        ],
        tables: vec![table],
        figures: vec![Figure {
            title: "Spread of the round trips before the start".to_owned(),
            thesis: String::new(),
            caption: "A dot for each federate, and the median.".to_owned(),
            plot: Plot::Rows {
                axis: Axis::logarithmic("standard deviation in µs"),
                rows,
                marks: vec![Mark {
                    label: "a stock federate throws away from here on".to_owned(),
                    who: Who::Stock,
                    at: micros(SPREAD_MAX),
                }],
            },
        }],
        ..Finding::default()
    })
}
