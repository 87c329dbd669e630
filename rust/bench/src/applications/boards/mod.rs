// SPDX-License-Identifier: Apache-2.0
//! Virtual boards with Zephyr's own network stack: how long messages take, how many get through, and how large images
//! are.

mod size;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::Applications;
use super::message::{Delay, parse_delay, parse_rate};
use super::run::{TIME_LIMIT, run};
use crate::{Result, Table};

pub use size::sizes;

/// The boards, by their names for people and for Zephyr.
const BOARDS: [(&str, &str); 2] = [("qemu_cortex_m3", "qemu_cortex_m3"), ("native_sim", "native_sim/native/64")];
const COORDINATIONS: [&str; 2] = ["centralized", "decentralized"];
/// Twice ten times as many messages per second as between the boards of the thesis, and how many there are.
const RATE_PER_S: u32 = 12_000;
const MESSAGES: u32 = 12_000;

/// Measures the delay of messages beside that of as many bytes over a raw connection between the same two images, and
/// how many messages get through in a second where more are sent than the boards can take.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn boards(applications: &Applications, rounds: u32) -> Result<()> {
    println!("\nVirtual boards with Zephyr's own network stack, the RTI on this computer; best of {rounds} rounds");
    println!("Delay: half of the time until the answer, in µs; raw: between the same images in the same run.");
    println!("Messages: {MESSAGES}, of which {RATE_PER_S} would have to be sent in a second.");
    let mut table = Table::new(&[
        "",
        "median",
        "99 %",
        "raw: median",
        "raw: 99 %",
        "median, of raw",
        "messages received",
        "messages/s",
        "thesis (boards)",
    ]);
    for (name, board) in BOARDS {
        for coordination in COORDINATIONS {
            let (federates, raw) = delay(applications, rounds, board, coordination)?;
            let (received, rate, thesis) = rate(applications, rounds, board, coordination)?;
            #[expect(clippy::cast_precision_loss, reason = "delays are far below 2^53 µs")]
            let ratio = federates.median as f64 / raw.median.max(1) as f64;
            let mut cells = vec![format!("{name}, {coordination}")];
            cells.extend([federates.median, federates.p99, raw.median, raw.p99].map(|time| time.to_string()));
            cells.extend([format!("{ratio:.2}"), received, rate.to_string(), thesis.to_owned()]);
            table.row(cells);
        }
    }
    println!("\n{table}");
    Ok(())
}

/// The round with the shortest delay, and that of the raw connection in it.
fn delay(applications: &Applications, rounds: u32, board: &str, coordination: &str) -> Result<(Delay, Delay)> {
    let text = fs::read_to_string(applications.repository.join("rust/bench/programs/BoardDelay.lf"))?;
    // Only where no RTI says who may go on does anybody wait by himself.
    let waits = if coordination == "centralized" { "" } else { "@maxwait(0)" };
    let text = text.replace("coordination: decentralized", &format!("coordination: {coordination}"));
    let text = text.replace("@maxwait(0)", waits);
    let file = applications.variant("BoardDelay", &text)?;
    let room = applications.repository.join("rust/bench/programs/raw_connection.conf");
    let images = Images::build(applications, &file, (board, coordination), ["asker", "answerer"], &[&room])?;
    let mut best: Option<(Delay, Delay)> = None;
    for _ in 0..rounds {
        let output = images.run()?;
        let said = |who: &str| output.lines().find(|line| line.contains(who)).and_then(parse_delay);
        let (Some(federates), Some(raw)) = (said("| federates: "), said("| raw: ")) else {
            return Err(format!("there is no result in what was printed:\n{output}").into());
        };
        if best.as_ref().is_none_or(|(best, _)| federates.median < best.median) {
            best = Some((federates, raw));
        }
    }
    best.ok_or_else(|| "there was no round".into())
}

/// How many messages were received, how many in a second, and what the thesis reached.
fn rate(
    applications: &Applications,
    rounds: u32,
    board: &str,
    coordination: &str,
) -> Result<(String, u64, &'static str)> {
    let (file, thesis) = applications.message_rate(coordination, 1_000_000_000 / RATE_PER_S, MESSAGES)?;
    let images = Images::build(applications, &file, (board, coordination), ["sender", "receiver"], &[])?;
    let mut best = ("none".to_owned(), 0);
    for _ in 0..rounds {
        let output = images.run()?;
        let result = output.lines().find_map(parse_rate);
        let result = result.ok_or_else(|| format!("there is no result in what was printed:\n{output}"))?;
        if result.1 > best.1 {
            best = result;
        }
    }
    Ok((best.0, best.1, thesis))
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
