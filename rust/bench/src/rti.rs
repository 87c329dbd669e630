// SPDX-License-Identifier: Apache-2.0
//! RTIs side by side.

use std::time::Duration;

use lf_bench::{
    Graph, Latency, Load, Measured, Program, Result, Shape, Swarm, Traffic, Usage, Waiting, forwarder_latency, micros,
    program_latency,
};

use crate::arguments::Arguments;

/// The period in nanoseconds of logical time.
const PERIOD_NS: i64 = 1_000_000;
/// The run time of a federation before its traffic counts.
const WARM_UP: Duration = Duration::from_millis(300);
/// The longest time in which an RTI may end after all federates have left.
const END_TIME_OUT: Duration = Duration::from_secs(15);
/// The number of rounds of a run without a limit.
const ENDLESS: u64 = u64::MAX;

pub(crate) fn latency(arguments: &Arguments) -> Result<()> {
    let print = |who: &str, latency: &Latency| {
        Measured::samples("latency", "NET to TAG", who, "µs", &latency.grant).print()?;
        Measured::samples("latency", "message of 8 bytes", who, "µs", &latency.message).print()
    };
    for _ in 0..arguments.rounds {
        print("forwarder, asleep", &forwarder_latency(Waiting::Asleep, arguments.exchanges)?)?;
        print("forwarder, awake", &forwarder_latency(Waiting::Awake, arguments.exchanges)?)?;
        for program in arguments.programs() {
            print(program.name(), &program_latency(&program, arguments.exchanges)?)?;
        }
    }
    Ok(())
}

/// One federation under an RTI, from its start to its end.
struct Run {
    start: Duration,
    traffic: Traffic,
    cpu: Duration,
    usage: Usage,
    stop: Duration,
    succeeded: bool,
}

pub(crate) fn throughput(arguments: &Arguments) -> Result<()> {
    for (federates, messages) in [(2, 1), (16, 1), (64, 1), (2, 16), (16, 16), (64, 16)] {
        let row = format!("{federates}, {messages}");
        let graph = Graph::new(Shape::Pairs, federates, PERIOD_NS);
        each_run("throughput", &row, arguments, arguments.rounds, &graph, messages, |run| {
            vec![
                ("messages/s", run.traffic.messages_per_second()),
                ("CPU µs/message", per(run.cpu, run.traffic.messages)),
                ("resident MB", megabytes(run.usage.resident)),
                ("own MB", megabytes(run.usage.own)),
            ]
        })?;
    }
    Ok(())
}

/// Measures our RTI with and without encryption, in turns: latency, and then throughput.
pub(crate) fn encryption(arguments: &Arguments) -> Result<()> {
    let programs = [Program::Ours(arguments.lfz.clone()), Program::Encrypted(arguments.lfz.clone())];
    for _ in 0..arguments.rounds {
        for program in &programs {
            let latency = program_latency(program, arguments.exchanges)?;
            for (row, samples) in [("NET to TAG", &latency.grant), ("message of 8 bytes", &latency.message)] {
                Measured::samples("encryption", row, program.name(), "µs", samples).print()?;
            }
        }
        for (federates, messages) in [(2, 1), (16, 1), (16, 16)] {
            let row = format!("{federates}, {messages}");
            let graph = Graph::new(Shape::Pairs, federates, PERIOD_NS);
            let load = Load { period_ns: PERIOD_NS, messages, rounds_ahead: 8 };
            for program in &programs {
                let run = run(program, &graph, load, arguments.time())?;
                let values = [
                    ("messages/s", run.traffic.messages_per_second()),
                    ("CPU µs/message", per(run.cpu, run.traffic.messages)),
                ];
                for (unit, value) in values {
                    Measured::value("encryption", &row, program.name(), unit, value).print()?;
                }
            }
        }
    }
    Ok(())
}

pub(crate) fn growth(arguments: &Arguments) -> Result<()> {
    for shape in [Shape::Chain, Shape::Star, Shape::Random] {
        for federates in [2, 8, 32, 128, 500] {
            let row = format!("{shape}, {federates}");
            let graph = Graph::new(shape, federates, PERIOD_NS);
            each_run("growth", &row, arguments, arguments.rounds, &graph, 1, |run| {
                let cost = per(run.cpu, run.traffic.grants);
                vec![("grants/s", run.traffic.grants_per_second()), ("CPU µs/grant", cost)]
            })?;
        }
    }
    Ok(())
}

pub(crate) fn large(arguments: &Arguments) -> Result<()> {
    let graph = Graph::new(Shape::Random, arguments.federates, PERIOD_NS);
    let row = format!("{} federates", arguments.federates);
    each_run("large", &row, arguments, 1, &graph, 1, |run| {
        vec![
            ("start s", run.start.as_secs_f64()),
            ("messages", count(run.traffic.messages)),
            ("grants", count(run.traffic.grants)),
            ("messages/s", run.traffic.messages_per_second()),
            ("CPU s", run.cpu.as_secs_f64()),
            ("resident MB", megabytes(run.usage.resident)),
            ("own MB", megabytes(run.usage.own)),
            ("stop ms", run.stop.as_secs_f64() * 1e3),
            ("ended with an error", if run.succeeded { 0.0 } else { 1.0 }),
        ]
    })
}

/// Runs a federation under each RTI in turn, and prints these values of each run. Skips an RTI in later rounds once it
/// has failed.
fn each_run(
    part: &str,
    row: &str,
    arguments: &Arguments,
    rounds: u32,
    graph: &Graph,
    messages: u32,
    values: impl Fn(&Run) -> Vec<(&'static str, f64)>,
) -> Result<()> {
    let load = Load { period_ns: PERIOD_NS, messages, rounds_ahead: 8 };
    let mut programs = arguments.programs();
    for _ in 0..rounds {
        let mut failed = Vec::new();
        for program in &programs {
            match run(program, graph, load, arguments.time()) {
                Ok(run) => values(&run)
                    .into_iter()
                    .try_for_each(|(unit, value)| Measured::value(part, row, program.name(), unit, value).print())?,
                Err(error) => {
                    Measured::error(part, row, program.name(), error.to_string()).print()?;
                    failed.push(program.name());
                }
            }
        }
        programs.retain(|program| !failed.contains(&program.name()));
    }
    Ok(())
}

fn run(program: &Program, graph: &Graph, load: Load, time: Duration) -> Result<Run> {
    let mut rti = program.start(graph.federates)?;
    let mut swarm = Swarm::join(rti.access(), graph, load)?;
    swarm.run(WARM_UP.min(time), ENDLESS)?;
    let before = rti.usage();
    let traffic = swarm.run(time, ENDLESS)?;
    let usage = rti.usage();
    let stop = swarm.stop()?;
    let succeeded = rti.wait(END_TIME_OUT)?.success();
    Ok(Run { start: swarm.start, traffic, cpu: usage.cpu.saturating_sub(before.cpu), usage, stop, succeeded })
}

/// Returns the time per item in µs.
fn per(time: Duration, number: u64) -> f64 {
    micros(time) / count(number.max(1))
}

#[expect(clippy::cast_precision_loss, reason = "counts of what happens in minutes are far below 2^53")]
fn count(number: u64) -> f64 {
    number as f64
}

fn megabytes(bytes: u64) -> f64 {
    count(bytes) / 1e6
}
