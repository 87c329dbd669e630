// SPDX-License-Identifier: Apache-2.0
//! What is measured, and how it is told.

use std::time::Duration;

use clap::ValueEnum;
use lf_bench::applications::{self, Applications, Board};
use lf_bench::{
    Graph, InitialExchanges, Latency, Load, Program, Result, SPREAD_MAX, Shape, Swarm, Table, Traffic, Usage, Waiting,
    clock, forwarder_latency, program_latency,
};

use crate::arguments::{Arguments, Part};

/// In nanoseconds of logical time.
const PERIOD_NS: i64 = 1_000_000;
/// How long a federation runs before what it does counts.
const WARM_UP: Duration = Duration::from_millis(300);
/// How long an RTI may take to end when all federates have left.
const END_TIME_OUT: Duration = Duration::from_secs(15);
/// Federations of the exchanges before the start, for each round.
const INITIAL_RUNS: u32 = 10;
/// Without a limit of rounds.
const ENDLESS: u64 = u64::MAX;

/// What is told of a measurement of latency.
type Pick = fn(&Latency) -> Duration;

/// One federation under an RTI, from its start to its end.
struct Run {
    start: Duration,
    traffic: Traffic,
    cpu: Duration,
    usage: Usage,
    stop: Duration,
    succeeded: bool,
}

/// Measures all that was asked for.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut programs: Vec<Program> = arguments.lfz.iter().cloned().map(Program::Ours).collect();
    programs.extend(arguments.stock_rti.iter().cloned().map(Program::Stock));
    let applications = applications(arguments);
    let wanted = |part: &&Part| arguments.only.is_empty() || arguments.only.contains(part);
    for part in Part::value_variants().iter().filter(wanted) {
        match part {
            Part::Latency => latency(arguments, &programs)?,
            Part::Throughput => throughput(arguments, &programs),
            Part::Growth => growth(arguments, &programs),
            Part::Large => large(arguments, &programs),
            Part::Clock => clocks(arguments),
            Part::Initial => initial(arguments, &programs)?,
            Part::Delay => applications::delay(&applications, arguments.rounds)?,
            Part::Rate => applications::rate(&applications, arguments.rounds)?,
            Part::Grid => applications::grid(&applications, arguments.iterations)?,
            Part::After => applications::smallest_after(&applications, arguments.after_runs)?,
            Part::Boards if applications.boards.contains(&Board::NativeSim) => {
                applications::boards(&applications, arguments.rounds)?;
            }
            Part::Sizes if applications.boards.contains(&Board::NativeSim) => applications::sizes(&applications)?,
            Part::Boards | Part::Sizes => println!("\nBoards are left out: there is no Zephyr workspace."),
            Part::Drift if applications.boards.contains(&Board::NativeSim) => {
                applications::drift(&applications, arguments.drift_seconds)?;
            }
            Part::Drift => println!("\nThe drifting clock is left out: there is no Zephyr workspace."),
        }
    }
    Ok(())
}

/// Images are built only where `ZEPHYR_BASE` names a Zephyr workspace; `cargo xtask evaluate` sets it.
fn applications(arguments: &Arguments) -> Applications {
    let mut boards = vec![Board::Host];
    boards.extend(std::env::var_os("ZEPHYR_BASE").map(|_| Board::NativeSim));
    Applications {
        repository: arguments.repository.clone().unwrap_or_default(),
        lfz: arguments.lfz.clone().unwrap_or_default(),
        boards,
    }
}

fn clocks(arguments: &Arguments) {
    println!(
        "\nError of a federate's clock in µs over 60 s, in virtual time; the first 5 s after the start do not count"
    );
    println!(
        "The clock is 1 s off and gains {} µs/s; period {} ms, {} trials, attenuation {}; worst of {} seeds",
        clock::DRIFT_PPB / 1000,
        clock::PERIOD_NS / 1_000_000,
        clock::TRIALS,
        clock::ATTENUATION,
        arguments.rounds
    );
    let mut table = Table::new(&[
        "network, mode",
        "ours: median",
        "ours: worst",
        "stock algorithm: median",
        "stock algorithm: worst",
    ]);
    for network in clock::Network::ALL {
        for (mode, on) in [("init", false), ("on", true)] {
            let mut worst = [Duration::ZERO; 4];
            for seed in 1..=u64::from(arguments.rounds) {
                let ours = clock::run(&mut clock::Ours::default(), &network, seed, on);
                let stock = clock::run(&mut clock::Stock::default(), &network, seed, on);
                for (index, samples) in [ours, stock].iter().enumerate() {
                    worst[2 * index] = worst[2 * index].max(samples.percentile(50));
                    worst[2 * index + 1] = worst[2 * index + 1].max(samples.percentile(100));
                }
            }
            let mut cells = vec![format!("{}, {mode}", network.name)];
            cells.extend(worst.iter().map(|time| format!("{:.1}", micros(*time))));
            table.row(cells);
        }
    }
    println!("{table}");
    println!(
        "The stock federate discards the exchanges before the start when their round trips differ by 100 µs or more, \
         and then begins with the whole offset."
    );
}

fn initial(arguments: &Arguments, programs: &[Program]) -> Result<()> {
    println!(
        "\nTen exchanges before the start in µs, of federates that come at once; {} federations each",
        INITIAL_RUNS * arguments.rounds
    );
    println!(
        "The spread is the standard deviation of a federate's round trips; from {:.0} µs on, a stock federate throws \
         them away.",
        micros(SPREAD_MAX)
    );
    let headings = ["federates, RTI", "thrown away", "spread: median", "90 %", "most", "answer: median", "99 %"];
    let mut table = Table::new(&headings);
    for federates in [1, 3, 8, 32] {
        let mut seen: Vec<_> = programs.iter().map(|_| InitialExchanges::default()).collect();
        for _ in 0..INITIAL_RUNS * arguments.rounds {
            for (program, seen) in programs.iter().zip(&mut seen) {
                seen.run(program, federates)?;
            }
        }
        for (program, seen) in programs.iter().zip(&seen) {
            let mut cells = vec![
                format!("{federates}, {}", program.name()),
                format!("{} of {}", seen.thrown_away, seen.spreads.count()),
            ];
            let times = [50, 90, 100].map(|percent| seen.spreads.percentile(percent));
            let times = times.into_iter().chain([50, 99].map(|percent| seen.answers.percentile(percent)));
            cells.extend(times.map(|time| format!("{:.1}", micros(time))));
            table.row(cells);
        }
    }
    println!("{table}");
    Ok(())
}

fn latency(arguments: &Arguments, programs: &[Program]) -> Result<()> {
    println!("\nLatency in µs over {} exchanges, best of {} rounds", arguments.exchanges, arguments.rounds);
    println!("Forwarders: one sleeps until something comes, the other one looks all the time; the quicker one counts.");
    let forwarders = [Waiting::Asleep, Waiting::Awake];
    let mut all: Vec<Vec<Latency>> = vec![Vec::new(); forwarders.len() + programs.len()];
    for _ in 0..arguments.rounds {
        let (raw, measured) = all.split_at_mut(forwarders.len());
        for (waiting, results) in forwarders.iter().zip(raw) {
            results.push(forwarder_latency(*waiting, arguments.exchanges)?);
        }
        for (program, results) in programs.iter().zip(measured) {
            results.push(program_latency(program, arguments.exchanges)?);
        }
    }
    let mut headings = vec!["", "forwarder, asleep", "forwarder, awake"];
    headings.extend(programs.iter().map(Program::name));
    headings.push("ours / quicker forwarder");
    headings.extend((programs.len() > 1).then_some("stock / ours"));
    let mut table = Table::new(&headings);
    let rows: [(&str, Pick); 4] = [
        ("NET to TAG, median", |latency| latency.grant.percentile(50)),
        ("NET to TAG, 99 %", |latency| latency.grant.percentile(99)),
        ("message of 8 bytes, median", |latency| latency.message.percentile(50)),
        ("message of 8 bytes, 99 %", |latency| latency.message.percentile(99)),
    ];
    for (name, pick) in rows {
        let best: Vec<f64> =
            all.iter().map(|results| micros(results.iter().map(pick).min().unwrap_or_default())).collect();
        let (raw, measured) = best.split_at(forwarders.len());
        let mut cells = vec![name.to_owned()];
        cells.extend(best.iter().map(|value| format!("{value:.1}")));
        cells.push(ratio(measured[0], raw[0].min(raw[1])));
        cells.extend(measured.get(1).map(|stock| ratio(*stock, measured[0])));
        table.row(cells);
    }
    println!("{table}");
    Ok(())
}

fn throughput(arguments: &Arguments, programs: &[Program]) {
    println!("\nThroughput of pairs of federates, {} s each, best of {} rounds", arguments.seconds, arguments.rounds);
    println!("A sender has up to 8 tags under way; each tag costs NET, TAG, LTC and NET beside its messages.");
    let mut headings = vec!["federates, messages per tag"];
    let names = ["messages/s", "CPU µs/message", "resident MB"];
    let names: Vec<Vec<String>> =
        programs.iter().map(|program| names.map(|name| format!("{}: {name}", program.name())).to_vec()).collect();
    headings.extend(names.iter().flatten().map(String::as_str));
    headings.extend((programs.len() > 1).then_some("throughput, ours / stock"));
    let mut table = Table::new(&headings);
    for (federates, messages) in [(2, 1), (16, 1), (64, 1), (2, 16), (16, 16), (64, 16)] {
        let graph = Graph::new(Shape::Pairs, federates, PERIOD_NS);
        let load = Load { period_ns: PERIOD_NS, messages, rounds_ahead: 8 };
        let best = best_of(arguments, programs, &graph, load, |run| run.traffic.messages_per_second());
        let mut cells = vec![format!("{federates}, {messages}")];
        for run in &best {
            cells.extend(match run {
                Ok(run) => [
                    format!("{:.0}", run.traffic.messages_per_second()),
                    per(run.cpu, run.traffic.messages),
                    megabytes(run.usage.resident),
                ],
                Err(error) => [error.to_string(), String::new(), String::new()],
            });
        }
        cells.extend(compare(&best, |run| run.traffic.messages_per_second()));
        table.row(cells);
    }
    println!("{table}");
}

fn growth(arguments: &Arguments, programs: &[Program]) {
    println!("\nGrowth of the federation, {} s each, best of {} rounds", arguments.seconds, arguments.rounds);
    println!("CPU: time of the RTI's process for all that leads to a grant, forwarded messages included.");
    let mut headings = vec!["graph, federates"];
    let names = ["grants/s", "CPU µs/grant"];
    let names: Vec<Vec<String>> =
        programs.iter().map(|program| names.map(|name| format!("{}: {name}", program.name())).to_vec()).collect();
    headings.extend(names.iter().flatten().map(String::as_str));
    headings.extend((programs.len() > 1).then_some("grants/s, ours / stock"));
    let mut table = Table::new(&headings);
    for shape in [Shape::Chain, Shape::Star, Shape::Random] {
        for federates in [2, 8, 32, 128, 500] {
            let graph = Graph::new(shape, federates, PERIOD_NS);
            let load = Load { period_ns: PERIOD_NS, messages: 1, rounds_ahead: 8 };
            let best = best_of(arguments, programs, &graph, load, |run| run.traffic.grants_per_second());
            let mut cells = vec![format!("{shape}, {federates}")];
            for run in &best {
                cells.extend(match run {
                    Ok(run) => [format!("{:.0}", run.traffic.grants_per_second()), per(run.cpu, run.traffic.grants)],
                    Err(error) => [error.to_string(), String::new()],
                });
            }
            cells.extend(compare(&best, |run| run.traffic.grants_per_second()));
            table.row(cells);
        }
    }
    println!("{table}");
}

fn large(arguments: &Arguments, programs: &[Program]) {
    println!("\nA random federation of {} federates for {} s", arguments.large, arguments.large_seconds);
    let graph = Graph::new(Shape::Random, arguments.large, PERIOD_NS);
    let load = Load { period_ns: PERIOD_NS, messages: 1, rounds_ahead: 8 };
    let headings = ["", "start s", "messages", "grants", "messages/s", "CPU s", "resident MB", "stop ms", "ended"];
    let mut table = Table::new(&headings);
    for program in programs {
        let mut cells = vec![program.name().to_owned()];
        match measure(program, &graph, load, Duration::from_secs(arguments.large_seconds)) {
            Ok(run) => cells.extend([
                format!("{:.2}", run.start.as_secs_f64()),
                run.traffic.messages.to_string(),
                run.traffic.grants.to_string(),
                format!("{:.0}", run.traffic.messages_per_second()),
                format!("{:.2}", run.cpu.as_secs_f64()),
                megabytes(run.usage.resident),
                format!("{:.0}", run.stop.as_secs_f64() * 1e3),
                if run.succeeded { "in order" } else { "with an error" }.to_owned(),
            ]),
            Err(error) => {
                cells.push(error.to_string());
                cells.resize(headings.len(), String::new());
            }
        }
        table.row(cells);
    }
    println!("{table}");
}

/// The best run of each program; they take turns. A program that fails once has failed.
fn best_of(
    arguments: &Arguments,
    programs: &[Program],
    graph: &Graph,
    load: Load,
    good: impl Fn(&Run) -> f64,
) -> Vec<Result<Run>> {
    let mut best: Vec<Option<Result<Run>>> = programs.iter().map(|_| None).collect();
    for _ in 0..arguments.rounds {
        for (program, best) in programs.iter().zip(&mut best) {
            if matches!(best, Some(Err(_))) {
                continue;
            }
            let run = measure(program, graph, load, Duration::from_secs(arguments.seconds));
            match (&run, &best) {
                (Ok(run), Some(Ok(before))) if good(run) <= good(before) => {}
                _ => *best = Some(run),
            }
        }
    }
    best.into_iter().map(|best| best.unwrap_or_else(|| Err("there was no round".into()))).collect()
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

fn compare(best: &[Result<Run>], good: impl Fn(&Run) -> f64) -> Option<String> {
    match best {
        [Ok(ours), Ok(stock)] => Some(ratio(good(ours), good(stock))),
        [_, _] => Some(String::new()),
        _ => None,
    }
}

fn micros(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

#[expect(clippy::cast_precision_loss, reason = "counts of what happens in minutes are far below 2^53")]
fn per(time: Duration, count: u64) -> String {
    format!("{:.2}", micros(time) / (count.max(1) as f64))
}

#[expect(clippy::cast_precision_loss, reason = "memory is far below 2^53 bytes")]
fn megabytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1e6)
}

fn ratio(one: f64, other: f64) -> String {
    format!("{:.2}", one / other.max(f64::MIN_POSITIVE))
}
