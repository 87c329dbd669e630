// SPDX-License-Identifier: Apache-2.0
//! The message test: how long a message takes, and how many get through (thesis, section 6.2).

use std::path::PathBuf;
use std::time::Duration;

use super::ping::ping;
use super::{Applications, Board};
use crate::{Result, Table};

/// As in `MessageDelay.lf`.
const PERIOD: Duration = Duration::from_millis(10);
const MESSAGES: u32 = 1000;
/// Messages of one measurement of the rate at the second period.
const MANY_MESSAGES: u32 = 30_000;
/// Messages per second, averages of table 6.1.
const THESIS_CENTRALIZED: &str = "611.65";
const THESIS_DECENTRALIZED: &str = "588.88";

/// How long a message takes from federate to federate, in microseconds as printed.
pub(super) struct Delay {
    pub(super) count: u32,
    pub(super) median: i64,
    pub(super) p99: i64,
    pub(super) max: i64,
}

/// Measures the delay of messages beside that of the same bytes over a raw TCP connection, in turns, and prints the
/// best round of each.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn delay(applications: &Applications, rounds: u32) -> Result<()> {
    println!(
        "\nOne-way delay of messages of 8 bytes in µs, {MESSAGES} messages, {} ms apart, best of {rounds} rounds",
        PERIOD.as_millis()
    );
    let programs = [
        ("decentralized", applications.file("message_test/src/MessageDelay.lf")),
        ("centralized", centralized(applications)?),
    ];
    let mut ways: Vec<(String, Option<(Board, PathBuf)>)> = vec![("raw TCP, Linux".to_owned(), None)];
    // The clock of native_sim stands still while the program works, and lags behind by as much afterwards; the clocks
    // of two images differ by more than what is measured here.
    let board = Board::Host;
    for (name, file) in programs {
        applications.build(board, &file)?;
        ways.push((format!("{name}, {board}"), Some((board, file))));
    }
    let mut best: Vec<Option<Delay>> = ways.iter().map(|_| None).collect();
    for _ in 0..rounds {
        for ((_, program), best) in ways.iter().zip(&mut best) {
            let delay = match program {
                None => raw()?,
                Some((board, file)) => {
                    let output = applications.run(*board, file)?;
                    parse_delay(&output).ok_or_else(|| format!("there is no result in what was printed:\n{output}"))?
                }
            };
            if best.as_ref().is_none_or(|best| delay.median < best.median) {
                *best = Some(delay);
            }
        }
    }
    let mut table = Table::new(&["", "arrived", "median", "99 %", "maximum", "median, of raw TCP"]);
    let raw = best.first().and_then(Option::as_ref).map_or(1, |delay| delay.median.max(1));
    for ((name, _), delay) in ways.iter().zip(best.iter().flatten()) {
        let mut cells = vec![name.clone(), delay.count.to_string()];
        cells.extend([delay.median, delay.p99, delay.max].map(|time| time.to_string()));
        #[expect(clippy::cast_precision_loss, reason = "delays are far below 2^53 µs")]
        cells.push(format!("{:.2}", delay.median as f64 / raw as f64));
        table.row(cells);
    }
    println!("\n{table}");
    Ok(())
}

/// Measures how many messages get through in a second, and whether all of them do, and prints a table.
///
/// # Errors
/// When a program cannot be built or fails.
pub fn rate(applications: &Applications, rounds: u32) -> Result<()> {
    println!("\nMessages per second from a federate to another one, best of {rounds} rounds");
    let mut table = Table::new(&["", "period µs", "received", "messages/s", "thesis (boards), 100 µs"]);
    for coordination in ["decentralized", "centralized"] {
        for (period_us, messages) in [(100, 3000), (10, MANY_MESSAGES)] {
            let (file, thesis) = applications.message_rate(coordination, period_us * 1000, messages)?;
            for &board in &applications.boards {
                applications.build(board, &file)?;
                let mut best = ("none".to_owned(), 0);
                for _ in 0..rounds {
                    let output = applications.run(board, &file)?;
                    let result = output.lines().find_map(parse_rate);
                    let (received, rate) =
                        result.ok_or_else(|| format!("there is no result in what was printed:\n{output}"))?;
                    if rate > best.1 {
                        best = (received, rate);
                    }
                }
                let (received, rate) = best;
                let name = format!("{coordination}, {board}");
                table.row(vec![name, period_us.to_string(), received, rate.to_string(), thesis.to_owned()]);
            }
        }
    }
    println!("\n{table}");
    Ok(())
}

impl Applications {
    /// `MessageTest.lf` with this coordination and so many messages, one in each period, and how many messages per
    /// second the thesis reached.
    pub(super) fn message_rate(
        &self,
        coordination: &str,
        period_ns: u32,
        messages: u32,
    ) -> Result<(PathBuf, &'static str)> {
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
        let thesis = if coordination == "centralized" { THESIS_CENTRALIZED } else { THESIS_DECENTRALIZED };
        Ok((self.variant("MessageRate", &text)?, thesis))
    }
}

/// `MessageDelay.lf` with messages through the RTI.
fn centralized(applications: &Applications) -> Result<PathBuf> {
    let import = applications.file("message_test/src/MessageDelay.lf");
    let text = format!(
        "target Rust\n\
         import Clock, Delays from \"{}\"\n\
         federated reactor {{\n\
         \x20   clock = new Clock(period = {} msec, iterations = {MESSAGES})\n\
         \x20   delays = new Delays()\n\
         \x20   clock.sent_at -> delays.sent_at\n\
         }}\n",
        import.display(),
        PERIOD.as_millis(),
    );
    applications.variant("MessageDelayCentralized", &text)
}

fn raw() -> Result<Delay> {
    let samples = ping(MESSAGES, PERIOD)?;
    let micros = |percent| i64::try_from(samples.percentile(percent).as_micros()).unwrap_or(i64::MAX);
    Ok(Delay { count: samples.count(), median: micros(50), p99: micros(99), max: micros(100) })
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
pub(super) fn parse_rate(line: &str) -> Option<(String, u64)> {
    let (_, text) = line.split_once("received ")?;
    let (received, text) = text.split_once(" messages in order, ")?;
    let (rate, _) = text.split_once(" messages per second")?;
    Some((received.to_owned(), rate.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_read_from_what_the_federates_print() {
        let delay = parse_delay("delays | 1000 messages, delay in us: median 120, p99 164, max 200\n");
        assert!(matches!(delay, Some(Delay { count: 1000, median: 120, p99: 164, max: 200 })));
        let rate = parse_rate("receiver | received 3000 of 3000 messages in order, 9938 messages per second");
        assert_eq!(rate, Some(("3000 of 3000".to_owned(), 9938)));
    }
}
