// SPDX-License-Identifier: Apache-2.0
//! The message test: how long a message takes, and how many get through (thesis, section 6.2).

use std::path::PathBuf;
use std::time::Duration;

use super::ping::ping;
use super::thesis::{THESIS, Thesis};
use super::{Applications, Board};
use crate::results::{Axis, Cell, Comparison, Curve, Figure, Finding, Plot, Row, Table, Who};
use crate::{Result, Samples, micros};

/// As in `MessageDelays.lf`.
const PERIOD: Duration = Duration::from_millis(10);
const MESSAGES: u32 = 1000;
/// Messages of one measurement of the rate at the second period.
const MANY_MESSAGES: u32 = 30_000;
/// How messages go; the ways of this project are in the order of [`THESIS`].
const WAYS: [(&str, Who); 3] = [("raw TCP", Who::Raw), ("centralized", Who::OursToo), ("decentralized", Who::Ours)];
/// The import in `MessageDelays.lf`.
const IMPORT: &str = "../../../applications/message_test/src/MessageDelay.lf";

/// How long a message takes from federate to federate, in microseconds as printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Delay {
    pub(super) count: u32,
    pub(super) median: i64,
    pub(super) p99: i64,
    pub(super) max: i64,
}

/// How many messages were received in order, of how many, and how many in a second.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rate {
    received: u64,
    wanted: u64,
    pub(super) per_second: f64,
}

/// Measures the delay of messages beside that of the same bytes over a raw TCP connection, in turns.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn delay(applications: &Applications, rounds: u32) -> Result<Finding> {
    // The clock of native_sim stands still while the program works, and lags behind by as much afterwards; the clocks
    // of two images differ by more than what is measured here.
    let board = Board::Host;
    let mut files = Vec::new();
    for thesis in &THESIS {
        let file = delay_program(applications, thesis.coordination)?;
        applications.build(board, &file)?;
        files.push(file);
    }
    let mut all: [Vec<Samples>; WAYS.len()] = Default::default();
    for _ in 0..rounds {
        all[0].push(ping(MESSAGES, PERIOD)?);
        for (file, results) in files.iter().zip(&mut all[1..]) {
            let output = applications.run(board, file)?;
            let delays: Samples = output.lines().filter_map(parse_one_delay).collect();
            if delays.count() == 0 {
                return Err(format!("there is no result in what was printed:\n{output}").into());
            }
            results.push(delays);
        }
    }
    let (table, compared) = delay_numbers(&all);
    let curves = WAYS
        .iter()
        .zip(all)
        .map(|((name, who), results)| Curve::distribution(*name, *who, &results.into_iter().flatten().collect()));
    Ok(Finding {
        title: "Delay of messages".to_owned(),
        question: "How long does a message take from federate to federate?".to_owned(),
        method: vec![
            format!(
                "One way, on Linux: {MESSAGES} messages of 8 bytes, {} ms apart, in µs; best of {rounds} rounds.",
                PERIOD.as_millis()
            ),
            "The raw connection carries the same 29 bytes from one process to another.".to_owned(),
        ],
        compared,
        tables: vec![table],
        figures: vec![Figure {
            title: "Delay of messages on Linux".to_owned(),
            thesis: "figure 6.6".to_owned(),
            caption: "How many of all messages took at most so long, without the slowest one of a hundred; all rounds \
                  together."
                .to_owned(),
            plot: Plot::Curves {
                x: Axis::logarithmic("delay in µs"),
                y: Axis::linear("messages in %"),
                curves: curves.collect(),
                marks: THESIS.iter().map(Thesis::mark).collect(),
            },
        }],
        limits: vec![
            "The thesis measured two boards of 1 GHz on a switch of 100 Mbit/s, every 100 ms, by an oscilloscope, and \
             tells of its histogram only where about it lies; here both federates are on one computer. The part on \
             virtual boards has Zephyr's network stack in between."
                .to_owned(),
        ],
    })
}

/// The table of delays, in the order of [`WAYS`], and what they are compared with.
fn delay_numbers(all: &[Vec<Samples>; WAYS.len()]) -> (Table, Vec<Comparison>) {
    let mut table = Table::new("", ["", "arrived", "median", "99 %", "maximum", "median, of raw TCP"]);
    let medians = all.each_ref().map(|results| of_rounds(results, 50));
    let mut compared = Vec::new();
    for (index, (name, _)) in WAYS.iter().enumerate() {
        let comparison = |with: &str, theirs: Cell| Comparison {
            what: format!("median delay of a message, {name}, Linux"),
            unit: "µs".to_owned(),
            less_is_better: true,
            ours: medians[index].clone(),
            with: with.to_owned(),
            theirs,
        };
        let of_raw = comparison(WAYS[0].0, medians[0].clone());
        let arrived = all[index].iter().map(Samples::count).min().unwrap_or(0);
        let mut cells = vec![(*name).into(), Cell::count(arrived.into()), medians[index].clone()];
        cells.extend([99, 100].map(|percent| of_rounds(&all[index], percent)));
        cells.extend(of_raw.ratio().map(|ratio| Cell::number(ratio, 2)));
        table.row(cells);
        if let Some(thesis) = THESIS.iter().find(|thesis| thesis.coordination == *name) {
            compared.extend([of_raw, comparison("thesis, figure 6.6", Cell::number(thesis.delay_ms * 1e3, 0))]);
        }
    }
    (table, compared)
}

/// The best round, of what so many percent of the messages took at most, in µs.
fn of_rounds(rounds: &[Samples], percent: usize) -> Cell {
    let times: Vec<f64> = rounds.iter().map(|samples| micros(samples.percentile(percent))).collect();
    Cell::least(&times, 0)
}

/// Measures how many messages get through in a second, and whether all of them do.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn rate(applications: &Applications, rounds: u32) -> Result<Finding> {
    let headings = ["", "period µs", "received", "messages/s", "thesis (boards), 100 µs"];
    let mut table = Table::new("", headings);
    let (mut rows, mut compared) = (Vec::new(), Vec::new());
    for thesis in &THESIS {
        rows.push(thesis.row());
        for (period_us, messages) in [(100, 3000), (10, MANY_MESSAGES)] {
            let file = applications.message_rate(thesis.coordination, period_us * 1000, messages)?;
            for &board in &applications.boards {
                applications.build(board, &file)?;
                let mut results = Vec::new();
                for _ in 0..rounds {
                    results.push(rate_in(&applications.run(board, &file)?)?);
                }
                let name = format!("{}, {board}", thesis.coordination);
                let rates: Vec<f64> = results.iter().map(|rate| rate.per_second).collect();
                let best = Cell::greatest(&rates, 0);
                compared.push(thesis.compare_rate(&format!("{name}, one per {period_us} µs"), best.clone()));
                let who = if board == Board::Host { Who::Ours } else { Who::OursToo };
                rows.push(Row::new(format!("{board}, {}, per {period_us} µs", thesis.coordination), who, rates));
                table.row(vec![
                    name.into(),
                    Cell::count(period_us.into()),
                    worst(&results),
                    best,
                    Cell::number(thesis.rate(), 2),
                ]);
            }
        }
    }
    Ok(Finding {
        title: "Messages per second".to_owned(),
        question: "How many messages get through from a federate to another one, and do all of them?".to_owned(),
        method: vec![
            format!("Best of {rounds} rounds; the timer of the program sets how many there can be."),
            "Messages of 4 bytes in order: 3000 as in the thesis, and ten times as many.".to_owned(),
        ],
        compared,
        tables: vec![table],
        figures: vec![rate_figure("Messages per second, Linux and native_sim", rows)],
        limits: vec![
            "The thesis sent between two boards; here both federates are on one computer. At a period of 100 µs there \
             cannot be more than 10,000 messages/s."
                .to_owned(),
        ],
    })
}

/// A figure for the thesis's table.
pub(super) fn rate_figure(title: &str, rows: Vec<Row>) -> Figure {
    Figure {
        title: title.to_owned(),
        thesis: "table 6.1".to_owned(),
        caption: "A dot for each run, and the median.".to_owned(),
        plot: Plot::Rows { axis: Axis::logarithmic("messages/s"), rows, marks: Vec::new() },
    }
}

impl Applications {
    /// `MessageTest.lf` with this coordination and so many messages, one in each period.
    pub(super) fn message_rate(&self, coordination: &str, period_ns: u32, messages: u32) -> Result<PathBuf> {
        let import = self.file("message_test/src/MessageTest.lf");
        let text = format!(
            "target Rust {{ coordination: {coordination} }}\n\
             import Sender, Receiver from \"{}\"\n\
             federated reactor {{\n\
             \x20   sender = new Sender(period = {period_ns} nsec, iterations = {messages})\n\
             \x20   receiver = new Receiver(iterations = {messages})\n\
             \x20   sender.y -> receiver.x\n\
             }}\n",
            import.display()
        );
        self.variant("MessageRate", &text)
    }
}

/// `MessageDelays.lf` with this coordination.
fn delay_program(applications: &Applications, coordination: &str) -> Result<PathBuf> {
    let text = applications.program("MessageDelays.lf")?;
    let text = text.replace("coordination: decentralized", &format!("coordination: {coordination}"));
    let import = applications.file("message_test/src/MessageDelay.lf");
    let name = if coordination == "centralized" { "MessageDelaysCentralized" } else { "MessageDelays" };
    applications.variant(name, &text.replace(IMPORT, &import.to_string_lossy()))
}

/// `delay 120345 ns`
fn parse_one_delay(line: &str) -> Option<Duration> {
    let (_, text) = line.split_once("delay ")?;
    text.trim().strip_suffix(" ns")?.parse().ok().map(Duration::from_nanos)
}

/// What the receiver says: how many of how many messages it has received, and how many in a second.
///
/// # Errors
/// When it says nothing of it.
pub(super) fn rate_in(output: &str) -> Result<Rate> {
    let result = output.lines().find_map(parse_rate);
    result.ok_or_else(|| format!("there is no result in what was printed:\n{output}").into())
}

/// `1000 messages, delay in us: median 120, p99 164, max 200`
pub(super) fn parse_delay(output: &str) -> Option<Delay> {
    let said = |line: &str| {
        let (words, text) = line.split_once(" messages, delay in us: median ")?;
        let (_, count) = words.rsplit_once(' ')?;
        let (median, text) = text.split_once(", p99 ")?;
        let (p99, max) = text.split_once(", max ")?;
        Some(Delay {
            count: count.parse().ok()?,
            median: median.parse().ok()?,
            p99: p99.parse().ok()?,
            max: max.trim().parse().ok()?,
        })
    };
    output.lines().find_map(said)
}

/// `received 3000 of 3000 messages in order, 9938 messages per second`
fn parse_rate(line: &str) -> Option<Rate> {
    let (_, text) = line.split_once("received ")?;
    let (received, text) = text.split_once(" of ")?;
    let (wanted, text) = text.split_once(" messages in order, ")?;
    let (rate, _) = text.split_once(" messages per second")?;
    Some(Rate { received: received.parse().ok()?, wanted: wanted.parse().ok()?, per_second: rate.parse().ok()? })
}

/// How many messages came in the round in which the fewest did.
pub(super) fn worst(rounds: &[Rate]) -> Cell {
    let worst = rounds.iter().min_by_key(|rate| rate.received);
    worst.map_or(Cell::NONE, |rate| format!("{} of {}", rate.received, rate.wanted).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_read_from_what_the_federates_print() {
        let delay = parse_delay("delays | 1000 messages, delay in us: median 120, p99 164, max 200\n");
        assert!(matches!(delay, Some(Delay { count: 1000, median: 120, p99: 164, max: 200 })));
        let rate = parse_rate("receiver | received 3000 of 3000 messages in order, 9938 messages per second");
        assert_eq!(rate, Some(Rate { received: 3000, wanted: 3000, per_second: 9938.0 }));
        assert_eq!(parse_one_delay("delays | delay 1500 ns"), Some(Duration::from_nanos(1500)));
        assert_eq!(parse_one_delay("delays | delayed"), None);
    }
}
