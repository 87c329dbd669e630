// SPDX-License-Identifier: Apache-2.0
//! A board and a computer with clock synchronization `on`, decentralized, while the board's clock drifts.

use std::process::Command;
use std::sync::mpsc;

use super::Applications;
use super::run::run;
use crate::Result;
use crate::process::{free_port, start};
use crate::results::{Cell, Finding, Table};

/// What the board's clock gains, as a fraction: 26 µs in a second (thesis, section 6.1).
const DRIFT: &str = "26e-6";

/// Runs the application `clock_sync` for so many seconds, and counts how many messages came, and how many late.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn drift(applications: &Applications, seconds: u64) -> Result<Finding> {
    let source = applications.read("clock_sync/src/ClockSync.lf")?;
    let text = source.replace("timeout: 10 sec", &format!("timeout: {seconds} sec"));
    let file = applications.variant("ClockSync", &text)?;
    let deployment = applications.file("clock_sync/deployment/native_sim.yaml");
    let mut command = applications.west("lf-fed-build", &file);
    run(command.arg("--deployment").arg(deployment))?;
    let port = free_port()?;
    let mut command = applications.west("lf-fed-run", &file);
    command.args(["--no-build", "-f", "computer", "--rti-port", &port.to_string()]);
    let (mut rti, computer) = start(&mut command)?;
    // The image tries to connect until the RTI is there.
    let image = applications.build_folder(&file).join("zephyr/ClockSync/board/zephyr/zephyr.exe");
    let mut command = Command::new(image);
    command.args([format!("-lf-rti-port={port}"), format!("-rt-drift={DRIFT}")]);
    let (mut board, board_lines) = start(&mut command)?;
    let (sender, receiver) = mpsc::channel();
    for (name, lines) in [("computer", computer), ("board", board_lines)] {
        let sender = sender.clone();
        // It ends with the output of its process.
        std::thread::spawn(move || {
            for line in lines.map_while(std::result::Result::ok) {
                // The receiver is there for as long as this function.
                let _ = sender.send((name, line));
            }
        });
    }
    drop(sender);
    let mut table = Table::new("", ["", "sent", "heard", "late", "slowest µs"]);
    let mut method = vec![
        "A program and a native_sim image, decentralized, clock synchronization on; the image's clock gains 26 µs/s."
            .to_owned(),
        format!("Both send 100 messages a second for {seconds} s, and wait 10 ms for each."),
    ];
    for (name, line) in receiver {
        if let Some(numbers) = parse(&line) {
            table.row([name.into()].into_iter().chain(numbers.map(Cell::count)).collect());
        } else if ["late", "clock", "rounds"].iter().any(|word| line.contains(word)) {
            method.push(format!("{name}: {line}"));
        }
    }
    if !(rti.0.wait()?.success() && board.0.wait()?.success()) {
        return Err("a participant has failed".into());
    }
    Ok(Finding {
        title: "A drifting clock".to_owned(),
        question: "Do clocks stay together while one of them drifts as the thesis's board did?".to_owned(),
        method,
        tables: vec![table],
        limits: vec![
            "In the thesis synchronization while the program runs (`on`) did not work, so there is nothing to compare \
             with. The computer has to be idle otherwise: it holds the participants up for longer than they wait."
                .to_owned(),
        ],
        ..Finding::default()
    })
}

/// The numbers in `sent 900, heard 900, 0 late, the slowest after 812 us`.
fn parse(line: &str) -> Option<[u64; 4]> {
    let (_, text) = line.split_once("sent ")?;
    let (sent, text) = text.split_once(", heard ")?;
    let (heard, text) = text.split_once(", ")?;
    let (late, text) = text.split_once(" late, the slowest after ")?;
    let (slowest, _) = text.split_once(" us")?;
    Some([sent.parse().ok()?, heard.parse().ok()?, late.parse().ok()?, slowest.parse().ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_read_from_what_the_federates_print() {
        let line = "computer | sent 900, heard 899, 1 late, the slowest after 812 us";
        assert_eq!(parse(line), Some([900, 899, 1, 812]));
    }
}
