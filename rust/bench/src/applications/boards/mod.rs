// SPDX-License-Identifier: Apache-2.0
//! Virtual boards with Zephyr's own network stack: how long messages take, how many get through, and how large images
//! are.

mod map;
mod size;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::Applications;
use super::message::{Delay, parse_delay, rate_figure, rate_in, worst};
use super::run::{TIME_LIMIT, run};
use super::thesis::{THESIS, Thesis};
use crate::Result;
use crate::results::{Axis, Cell, Comparison, Figure, Finding, Plot, Row, Table, Who};

pub use size::sizes;

/// The boards, by their names for people and for Zephyr.
const BOARDS: [(&str, &str); 2] = [("qemu_cortex_m3", "qemu_cortex_m3"), ("native_sim", "native_sim/native/64")];
/// Twice ten times as many messages per second as between the boards of the thesis, and how many there are.
const RATE_PER_S: u32 = 12_000;
const MESSAGES: u32 = 12_000;

/// Measures the delay of messages beside that of as many bytes over a raw connection between the same two images, and
/// how many messages get through in a second where more are sent than the boards can take.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn boards(applications: &Applications, rounds: u32) -> Result<Finding> {
    let headings = [
        "",
        "median",
        "99 %",
        "raw: median",
        "raw: 99 %",
        "median, of raw",
        "messages received",
        "messages/s",
        "thesis (boards)",
    ];
    let mut finding = Finding {
        title: "Virtual boards".to_owned(),
        question: "How long do messages take between boards with Zephyr's own network stack, and how many get through?"
            .to_owned(),
        method: vec![
            format!("The RTI is on this computer; best of {rounds} rounds."),
            "Delay: half of the time until the answer, in µs; raw: between the same images in the same run.".to_owned(),
            format!("Messages: {MESSAGES}, of which {RATE_PER_S} would have to be sent in a second."),
        ],
        tables: vec![Table::new("", headings)],
        limits: vec![
            "QEMU and native_sim are not the thesis's boards: processor and time are this computer's, and the network \
             is a bridge in its kernel. The raw connection of the same run is the fair comparison."
                .to_owned(),
        ],
        ..Finding::default()
    };
    let (mut delays, mut rates) = (Vec::new(), THESIS.iter().map(Thesis::row).collect());
    let boards = if applications.quick { &BOARDS[..1] } else { &BOARDS };
    for (name, board) in boards {
        for thesis in &THESIS {
            let pairs = delay(applications, rounds, board, thesis.coordination)?;
            let (received, seen) = rate(applications, rounds, board, thesis.coordination)?;
            let what = format!("{name}, {}", thesis.coordination);
            add(&mut finding, thesis, &what, &pairs, (received, &seen));
            add_rows(&mut delays, &mut rates, thesis, &what, &pairs, seen);
        }
    }
    let delays = Figure {
        title: "Delay of messages between virtual boards".to_owned(),
        thesis: "figure 6.6".to_owned(),
        caption: "A dot for the median of each round, and the median of these. Raw: between the same images, in the \
                  same run."
            .to_owned(),
        plot: Plot::Rows {
            axis: Axis::logarithmic("delay in µs"),
            rows: delays,
            marks: THESIS.iter().map(Thesis::mark).collect(),
        },
    };
    finding.figures = vec![delays, rate_figure("Messages per second between virtual boards", rates)];
    Ok(finding)
}

/// Adds what was measured between two boards to the numbers.
fn add(finding: &mut Finding, thesis: &Thesis, what: &str, pairs: &[(Delay, Delay)], rate: (Cell, &[f64])) {
    let (received, rates) = rate;
    let best = Cell::greatest(rates, 0);
    let of = |which: fn(&(Delay, Delay)) -> i64| Cell::least(&each(pairs, which), 0);
    let comparison = |with: &str, theirs: Cell| Comparison {
        what: format!("median delay of a message, {what}"),
        unit: "µs".to_owned(),
        less_is_better: true,
        ours: of(|pair| pair.0.median),
        with: with.to_owned(),
        theirs,
    };
    let of_raw = comparison("raw connection", of(|pair| pair.1.median));
    let mut cells = vec![what.into(), of_raw.ours.clone(), of(|pair| pair.0.p99)];
    cells.extend([of_raw.theirs.clone(), of(|pair| pair.1.p99)]);
    cells.push(of_raw.ratio().map_or(Cell::NONE, |ratio| Cell::number(ratio, 2)));
    cells.extend([received, best.clone(), Cell::number(thesis.rate(), 2)]);
    finding.tables.iter_mut().for_each(|table| table.row(cells.clone()));
    let of_thesis = comparison("thesis, figure 6.6", Cell::number(thesis.delay_ms * 1e3, 0));
    finding.compared.extend([of_raw, of_thesis, thesis.compare_rate(what, best)]);
}

/// Adds what was measured between two boards to the figures.
fn add_rows(
    delays: &mut Vec<Row>,
    rates: &mut Vec<Row>,
    thesis: &Thesis,
    what: &str,
    pairs: &[(Delay, Delay)],
    seen: Vec<f64>,
) {
    let who = if thesis.coordination == "centralized" { Who::OursToo } else { Who::Ours };
    delays.push(Row::new(what, who, each(pairs, |pair| pair.0.median)));
    delays.push(Row::new(format!("{what}, raw"), Who::Raw, each(pairs, |pair| pair.1.median)));
    rates.push(Row::new(what, who, seen));
}

#[expect(clippy::cast_precision_loss, reason = "delays are far below 2^53 µs")]
fn each(pairs: &[(Delay, Delay)], of: fn(&(Delay, Delay)) -> i64) -> Vec<f64> {
    pairs.iter().map(|pair| of(pair) as f64).collect()
}

/// The delays of each round, and those of the raw connection in it.
fn delay(applications: &Applications, rounds: u32, board: &str, coordination: &str) -> Result<Vec<(Delay, Delay)>> {
    // Only where no RTI says who may go on does anybody wait by himself.
    let waits = if coordination == "centralized" { "" } else { "@maxwait(0)" };
    let text = applications.program("BoardDelay.lf")?;
    let text = text.replace("coordination: decentralized", &format!("coordination: {coordination}"));
    let text = text.replace("@maxwait(0)", waits);
    let file = applications.variant("BoardDelay", &text)?;
    let room = applications.repository.join("rust/bench/programs/raw_connection.conf");
    let images = Images::build(applications, &file, (board, coordination), ["asker", "answerer"], &[&room])?;
    let one = |_| {
        let output = images.run()?;
        let said = |who: &str| output.lines().find(|line| line.contains(who)).and_then(parse_delay);
        let pair = said("| federates: ").zip(said("| raw: "));
        pair.ok_or_else(|| format!("there is no result in what was printed:\n{output}").into())
    };
    (0..rounds).map(one).collect()
}

/// How many messages were received in the worst round, and how many in a second in each.
fn rate(applications: &Applications, rounds: u32, board: &str, coordination: &str) -> Result<(Cell, Vec<f64>)> {
    let file = applications.message_rate(coordination, 1_000_000_000 / RATE_PER_S, MESSAGES)?;
    let images = Images::build(applications, &file, (board, coordination), ["sender", "receiver"], &[])?;
    let results: Vec<_> = (0..rounds).map(|_| rate_in(&images.run()?)).collect::<Result<_>>()?;
    Ok((worst(&results), results.iter().map(|rate| rate.per_second).collect()))
}

/// The images of a program of two federates, each on a board of its own.
struct Images<'a> {
    applications: &'a Applications,
    file: &'a Path,
    build: PathBuf,
}

impl<'a> Images<'a> {
    /// Builds them in a folder for this board and coordination.
    fn build(
        applications: &'a Applications,
        file: &'a Path,
        (board, coordination): (&str, &str),
        federates: [&str; 2],
        confs: &[&Path],
    ) -> Result<Self> {
        let folder = applications.build_folder(file).join(board.replace('/', "_")).join(coordination);
        fs::create_dir_all(&folder)?;
        let deployment = folder.join("deployment.yaml");
        let [one, other] = federates;
        let text = format!(
            "rti: {{ platform: host, ip: 10.0.0.1 }}\nfederates:\n\
             \x20 {one}: {{ platform: {board}, ip: 10.0.0.2 }}\n\x20 {other}: {{ platform: {board}, ip: 10.0.0.3 }}\n"
        );
        fs::write(&deployment, text)?;
        let images = Self { applications, file, build: folder };
        let mut command = images.west("lf-fed-build");
        command.arg("--deployment").arg(deployment);
        for conf in confs {
            command.arg("-c").arg(conf);
        }
        run(&mut command)?;
        Ok(images)
    }

    /// Runs them, and gives what they print.
    fn run(&self) -> Result<String> {
        run(self.west("lf-fed-run").args(["--no-build", "--timeout", TIME_LIMIT]))
    }

    fn west(&self, name: &str) -> Command {
        self.applications.west_in(name, self.file, &self.build)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_round_counts_and_all_are_kept() {
        let delay = |median| Delay { count: 500, median, p99: 3 * median, max: 9 * median };
        let pairs = [(delay(1500), delay(1000)), (delay(1200), delay(1100))];
        let headings = ["", "", "", "", "", "", "", "", ""];
        let mut finding = Finding { tables: vec![Table::new("", headings)], ..Finding::default() };
        add(&mut finding, &THESIS[0], "board, centralized", &pairs, ("9 of 9".into(), &[4000.0, 5000.0]));
        let cells: Vec<_> = finding.tables[0].rows[0].iter().map(Cell::to_string).collect();
        assert_eq!(
            cells,
            [
                "board, centralized",
                "1200 (1200–1500)",
                "3600 (3600–4500)",
                "1000 (1000–1100)",
                "3000 (3000–3300)",
                "1.20",
                "9 of 9",
                "5000 (4000–5000)",
                "611.65"
            ]
        );
        let with: Vec<_> = finding.compared.iter().map(|comparison| comparison.with.as_str()).collect();
        assert_eq!(with, ["raw connection", "thesis, figure 6.6", "thesis, table 6.1"]);
        assert_eq!(finding.compared[1].ratio(), Some(0.2));
    }
}
