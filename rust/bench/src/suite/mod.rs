// SPDX-License-Identifier: Apache-2.0
//! What is measured, part by part, and where the results go.

mod clocks;
mod folder;
mod latency;
mod progress;
mod rti;

use std::path::Path;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use lf_bench::applications::{self, Applications, Board};
use lf_bench::results::{FORMAT, Machine, Outcome, Part, Results};
use lf_bench::{Program, Result};

use crate::arguments::{Arguments, PartName};
use folder::Folder;
use progress::Progress;

/// Measures all that was asked for, or makes the page of what was measured before.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let folder = arguments.report.as_deref().map(Folder::new).transpose()?;
    if let (Some(from), Some(folder)) = (&arguments.from, &folder) {
        return folder.write(&folder::read(from)?);
    }
    let parts: Vec<PartName> =
        PartName::value_variants().iter().copied().filter(|part| is_wanted(arguments, *part)).collect();
    if parts.is_empty() {
        return Err("nothing is left to measure: --only pins needs a --recording".into());
    }
    let repository = arguments.repository.as_deref().unwrap_or(Path::new("."));
    let mut results = Results {
        format: FORMAT,
        begun: folder::now(),
        quick: arguments.quick,
        arguments: std::env::args().skip(1).collect(),
        machine: Machine::this(repository, arguments.stock_rti.as_deref()),
        parts: Vec::new(),
    };
    let setting = Setting::new(arguments);
    let mut progress = Progress::new(parts.iter().map(|part| setting.nominal(*part)).collect());
    let mut failed = Vec::new();
    for part in parts {
        let name = part.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        eprintln!("{}", progress.begin(&name));
        let begin = Instant::now();
        let outcome = setting.outcome(part);
        let took = begin.elapsed();
        progress.end(took);
        match &outcome {
            Outcome::Measured(finding) => println!("{finding}"),
            Outcome::Skipped(reason) => println!("\n{name} is left out: {reason}"),
            Outcome::Failed(error) => {
                eprintln!("error: {name}: {error}");
                failed.push(name.clone());
            }
        }
        results.parts.push(Part { name, seconds: took.as_secs_f64(), outcome });
        // After each part, so that nothing that was measured is lost.
        folder.as_ref().map_or(Ok(()), |folder| folder.write(&results))?;
    }
    if let Some(folder) = &folder {
        println!("\nThe report is {}.", folder.page().display());
    }
    if failed.is_empty() { Ok(()) } else { Err(format!("failed: {}", failed.join(", ")).into()) }
}

/// A recording is there only where one is given.
fn is_wanted(arguments: &Arguments, part: PartName) -> bool {
    let is_asked_for = arguments.only.is_empty() || arguments.only.contains(&part);
    is_asked_for && (part != PartName::Pins || arguments.recording.is_some())
}

/// What all parts are measured with.
struct Setting<'a> {
    arguments: &'a Arguments,
    programs: Vec<Program>,
    applications: Applications,
    has_zephyr: bool,
}

impl<'a> Setting<'a> {
    /// Images are built only where `ZEPHYR_BASE` names a Zephyr workspace; `cargo xtask evaluate` sets it.
    fn new(arguments: &'a Arguments) -> Self {
        let mut programs: Vec<Program> = arguments.lfz.iter().cloned().map(Program::Ours).collect();
        programs.extend(arguments.stock_rti.iter().cloned().map(Program::Stock));
        let has_zephyr = std::env::var_os("ZEPHYR_BASE").is_some();
        // A quick run has no time for as many images as there are settings.
        let boards =
            if has_zephyr && !arguments.quick { vec![Board::Host, Board::NativeSim] } else { vec![Board::Host] };
        let applications = Applications {
            repository: arguments.repository.clone().unwrap_or_default(),
            lfz: arguments.lfz.clone().unwrap_or_default(),
            boards,
            quick: arguments.quick,
        };
        Self { arguments, programs, applications, has_zephyr }
    }

    fn outcome(&self, part: PartName) -> Outcome {
        if part.needs_zephyr() && !self.has_zephyr {
            let reason = "there is no Zephyr workspace; set ZEPHYR_BASE, or run `west zephyr-export` in one";
            return Outcome::Skipped(reason.to_owned());
        }
        let Self { arguments, programs, applications, .. } = self;
        let finding = match part {
            PartName::Latency => latency::latency(arguments, programs),
            PartName::Throughput => Ok(rti::throughput(arguments, programs)),
            PartName::Growth => Ok(rti::growth(arguments, programs)),
            PartName::Large => Ok(rti::large(arguments, programs)),
            PartName::Clock => Ok(clocks::clocks(arguments)),
            PartName::Initial => clocks::initial(arguments, programs),
            PartName::Pins => match &arguments.recording {
                Some(recording) => clocks::pins(&applications.lfz, recording),
                None => Err("no recording".into()),
            },
            PartName::Delay => applications::delay(applications, arguments.rounds),
            PartName::Rate => applications::rate(applications, arguments.rounds),
            PartName::Grid => applications::grid(applications, arguments.iterations),
            PartName::After => applications::smallest_after(applications, arguments.after_runs),
            PartName::Drift => applications::drift(applications, arguments.drift_seconds),
            PartName::Boards => applications::boards(applications, arguments.rounds),
            PartName::Sizes => applications::sizes(applications),
        };
        finding.map_or_else(|error| Outcome::Failed(error.to_string()), Outcome::Measured)
    }

    /// About how long a part takes on a computer of two cores that has built everything before.
    fn nominal(&self, part: PartName) -> Duration {
        if part.needs_zephyr() && !self.has_zephyr {
            return Duration::ZERO;
        }
        let Arguments { rounds, seconds, iterations, after_runs, quick, .. } = *self.arguments;
        let (rounds, programs) = (u64::from(rounds), self.programs.len() as u64);
        // A program of this computer is built in 15 s, and the images of one in a minute.
        let (builds, boards) = if self.applications.boards.len() > 1 { (75, 2) } else { (15, 1) };
        let nominal = match part {
            PartName::Latency => 1 + rounds * (2 + programs) * u64::from(self.arguments.exchanges) / 5000,
            PartName::Throughput => 6 * rounds * programs * (seconds + 1),
            PartName::Growth => 15 * rounds * programs * (seconds + 1),
            PartName::Large => programs * (self.arguments.large_seconds + 2),
            PartName::Clock => 1 + rounds / 4,
            PartName::Initial => 8 * rounds * programs,
            PartName::Pins => 1,
            PartName::Delay => 30 + rounds * 36,
            PartName::Rate => 4 * (builds + boards * rounds * 5),
            PartName::Grid => 4 * (builds + boards * u64::from(iterations) * 5),
            PartName::After => 6 * builds + boards * 4 * u64::from(after_runs) * 2,
            PartName::Drift => 90 + self.arguments.drift_seconds,
            PartName::Boards => (if quick { 4 } else { 8 }) * (60 + rounds * 15),
            PartName::Sizes => (if quick { 2 } else { 12 }) * 50,
        };
        Duration::from_secs(nominal)
    }
}
