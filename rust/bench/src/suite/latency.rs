// SPDX-License-Identifier: Apache-2.0
//! How long grants and messages are on their way through RTIs, beside forwarders that do nothing else.

use lf_bench::results::{Axis, Cell, Comparison, Curve, Figure, Finding, Line, Plot, Table, Who};
use lf_bench::{Latency, Program, Result, Samples, Waiting, forwarder_latency, micros, program_latency};

use crate::arguments::Arguments;

/// The forwarders; they come before the RTIs.
const FORWARDERS: [(&str, Waiting); 2] = [("forwarder, asleep", Waiting::Asleep), ("forwarder, awake", Waiting::Awake)];

/// What is told of a measurement of latency.
type Pick = fn(&Latency) -> &Samples;

/// What is told, with what it is called where there is more room.
const KINDS: [(&str, &str, Pick); 2] = [
    ("NET to TAG", "a grant, NET to TAG", |latency| &latency.grant),
    ("message of 8 bytes", "a message of 8 bytes", |latency| &latency.message),
];

/// All rounds of a forwarder or an RTI.
struct Way {
    name: &'static str,
    who: Who,
    rounds: Vec<Latency>,
}

pub(super) fn latency(arguments: &Arguments, programs: &[Program]) -> Result<Finding> {
    let way = |name, who| Way { name, who, rounds: Vec::new() };
    let mut ways: Vec<Way> = FORWARDERS.map(|(name, _)| way(name, Who::Raw)).into();
    ways.extend(programs.iter().map(|program| way(program.name(), program.who())));
    for _ in 0..arguments.rounds {
        let (raw, measured) = ways.split_at_mut(FORWARDERS.len());
        for ((_, waiting), way) in FORWARDERS.iter().zip(raw) {
            way.rounds.push(forwarder_latency(*waiting, arguments.exchanges)?);
        }
        for (program, way) in programs.iter().zip(measured) {
            way.rounds.push(program_latency(program, arguments.exchanges)?);
        }
    }
    let headings = [""].into_iter().chain(ways.iter().map(|way| way.name)).chain(["ours / quicker forwarder"]);
    let mut table = Table::new("", headings.chain((programs.len() > 1).then_some("stock / ours")));
    let mut compared = Vec::new();
    for (what, _, pick) in KINDS {
        for (name, percent) in [("median", 50), ("99 %", 99)] {
            let (row, compared_here) = numbers(&format!("{what}, {name}"), &ways, pick, percent);
            table.row(row);
            compared.extend(compared_here);
        }
    }
    Ok(Finding {
        title: "Latency of the RTI".to_owned(),
        question: "How long are a grant and a message on their way through the RTI?".to_owned(),
        method: vec![
            format!(
                "In µs over {} exchanges, best of {} rounds, in turns; the range of the rounds stands behind.",
                arguments.exchanges, arguments.rounds
            ),
            "Forwarders: one sleeps until something comes, the other one looks all the time and takes a processor for \
             it; ours is compared with the quicker one."
                .to_owned(),
        ],
        compared,
        tables: vec![table],
        figures: KINDS.map(|(_, what, pick)| figure(what, &ways, pick)).to_vec(),
        limits: Vec::new(),
    })
}

/// A row of the table, and what ours is compared with in it.
fn numbers(what: &str, ways: &[Way], pick: Pick, percent: usize) -> (Vec<Cell>, Vec<Comparison>) {
    let best = |way: &Way| {
        let times: Vec<f64> = way.rounds.iter().map(|latency| micros(pick(latency).percentile(percent))).collect();
        Cell::least(&times, 1)
    };
    let best: Vec<Cell> = ways.iter().map(best).collect();
    let quicker = usize::from(best[1].value() < best[0].value());
    let (ours, stock) = (FORWARDERS.len(), FORWARDERS.len() + 1);
    let comparison = |other: usize| Comparison {
        what: what.to_owned(),
        unit: "µs".to_owned(),
        less_is_better: true,
        ours: best[ours].clone(),
        with: ways[other].name.to_owned(),
        theirs: best[other].clone(),
    };
    let (forwarder, stock) = (comparison(quicker), (stock < ways.len()).then(|| comparison(stock)));
    let mut cells = vec![what.into()];
    cells.extend(best.iter().cloned());
    cells.extend(forwarder.ratio().map(|ratio| Cell::number(ratio, 2)));
    cells.extend(stock.as_ref().and_then(Comparison::ratio).map(|ratio| Cell::number(1.0 / ratio, 2)));
    (cells, [Some(forwarder), stock].into_iter().flatten().collect())
}

fn figure(what: &str, ways: &[Way], pick: Pick) -> Figure {
    let curve = |way: &Way| {
        let samples = way.rounds.iter().flat_map(|latency| pick(latency).clone()).collect();
        // The forwarders have one colour.
        let line = if way.name == FORWARDERS[1].0 { Line::Dashed } else { Line::Solid };
        Curve { line, ..Curve::distribution(way.name, way.who, &samples) }
    };
    Figure {
        title: format!("Latency of {what}"),
        thesis: String::new(),
        caption: "How many of all exchanges took at most so long, without the slowest one of a hundred; all rounds \
                  together."
            .to_owned(),
        plot: Plot::Curves {
            x: Axis::logarithmic("time in µs"),
            y: Axis::linear("exchanges in %"),
            curves: ways.iter().map(curve).collect(),
            marks: Vec::new(),
        },
    }
}
