// SPDX-License-Identifier: Apache-2.0
//! Checks all graphs with up to this many federates, one per processor at a time; reports its progress from time to
//! time, and the number of graphs and states at the end. `cargo xtask model-check` runs it.
#![forbid(unsafe_code)]

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Parser;
use lf_model_check::{Bounds, Graph, Report, all_graphs, check, some_graphs};

/// The period of progress reports.
const PROGRESS_EVERY: Duration = Duration::from_secs(10);

/// Checks the RTI's grants in all reachable states of small federations.
#[derive(Parser)]
struct Arguments {
    /// Number of federates of each graph, at most 4, and with --sample at most 5.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=5))]
    federates: u8,
    /// Check this number of random graphs instead of all.
    #[arg(long, value_name = "COUNT")]
    sample: Option<usize>,
    /// The seed of the random choice.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Check only every N-th graph.
    #[arg(long, value_name = "STEP", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// End after this many seconds, even if graphs are left.
    #[arg(long, value_name = "SECONDS")]
    time_limit: Option<u64>,
    /// The number of graphs to check in parallel.
    #[arg(long)]
    jobs: Option<usize>,
    /// The number of orders in which to check the reactions of a cycle without delay.
    #[arg(long, default_value_t = 1)]
    orders: usize,
    /// Last time, in ticks after the start, at most 2.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(..=2))]
    time_max: u8,
    /// Last microstep of each time, at most 3.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(..=3))]
    microstep_max: u8,
    /// Messages that all federates together send.
    #[arg(long, default_value_t = 1)]
    messages: u8,
    /// Local events that all federates together have besides the first ones.
    #[arg(long, default_value_t = 0)]
    own_events: u8,
    /// Federates that may be lost.
    #[arg(long, default_value_t = 0)]
    losses: u8,
    /// Make one federate after the other transient: it may be absent at the start, and come this number of times.
    #[arg(long)]
    comings: Option<u8>,
    /// It may come while another instance of it is there, to take that one's place.
    #[arg(long, requires = "comings")]
    swaps: bool,
    /// The number of tags with messages before a receiver up to which the RTI reads a sender.
    #[arg(long, default_value_t = Bounds::default().window)]
    window: u16,
    /// Only graphs without `after 0`, and nothing but the first microstep of each time.
    #[arg(long)]
    no_microsteps: bool,
    /// Without DNET.
    #[arg(long)]
    no_dnet: bool,
}

impl Arguments {
    /// Returns the bounds of each check of a graph.
    fn all_bounds(&self) -> Vec<Bounds> {
        match self.comings {
            None => vec![self.bounds()],
            Some(comings_max) => {
                let of = |federate| Bounds { transient: Some(federate), comings_max, ..self.bounds() };
                (0..self.federates).map(of).collect()
            }
        }
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            time_max: self.time_max,
            microstep_max: if self.no_microsteps { 0 } else { self.microstep_max },
            own_events_max: self.own_events,
            messages_max: self.messages,
            dnet: !self.no_dnet,
            losses_max: self.losses,
            swaps: self.swaps,
            window: self.window,
            ..Bounds::default()
        }
    }

    fn graphs(&self) -> Box<dyn Iterator<Item = Graph> + Send> {
        let no_microsteps = self.no_microsteps;
        let is_meant = move |graph: &Graph| !(no_microsteps && graph.has_microstep_delay());
        if let Some(count) = self.sample {
            return Box::new(some_graphs(self.federates.into(), self.seed).filter(is_meant).take(count));
        }
        let graphs = all_graphs(self.federates.into()).filter(is_meant);
        Box::new(graphs.step_by(usize::try_from(self.every).unwrap_or(usize::MAX)))
    }
}

/// The state that the threads share.
struct Run {
    graphs: Mutex<Box<dyn Iterator<Item = Graph> + Send>>,
    total: Mutex<Total>,
    enough: AtomicBool,
    begin: Instant,
}

#[derive(Default)]
struct Total {
    graphs: u64,
    report: Report,
    said: Duration,
}

impl Total {
    fn say(&self, what: &str, elapsed: Duration) {
        let Report { models, states, states_max, .. } = self.report;
        let (graphs, seconds) = (self.graphs, elapsed.as_secs());
        println!("{what}{graphs} graphs, {models} models, {states} states, at most {states_max} in one, {seconds} s");
    }
}

impl Run {
    fn work(&self, arguments: &Arguments) {
        loop {
            let late = arguments.time_limit.is_some_and(|limit| self.begin.elapsed().as_secs() >= limit);
            if late || self.enough.load(Ordering::Relaxed) {
                return;
            }
            let next = self.graphs.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(graph) = next else { return };
            let mut report = Report::default();
            for bounds in arguments.all_bounds() {
                report.add(check(graph, bounds, arguments.orders));
            }
            let mut total = self.total.lock().unwrap_or_else(PoisonError::into_inner);
            self.enough.fetch_or(!report.findings.is_empty(), Ordering::Relaxed);
            total.graphs += 1;
            total.report.add(report);
            let elapsed = self.begin.elapsed();
            if elapsed >= total.said + PROGRESS_EVERY {
                total.said = elapsed;
                total.say("so far ", elapsed);
            }
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.federates > 4 && arguments.sample.is_none() {
        eprintln!("error: there are too many graphs of {} federates; add --sample COUNT", arguments.federates);
        return ExitCode::FAILURE;
    }
    let jobs = arguments.jobs.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from)).max(1);
    let run = Run {
        graphs: Mutex::new(arguments.graphs()),
        total: Mutex::default(),
        enough: AtomicBool::new(false),
        begin: Instant::now(),
    };
    thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| run.work(&arguments));
        }
    });
    let total = run.total.into_inner().unwrap_or_else(PoisonError::into_inner);
    total.say("", run.begin.elapsed());
    for finding in &total.report.findings {
        eprintln!("error: {:?}, ranks {:?}\n{}", finding.graph, finding.ranks, finding.counterexample);
    }
    if total.report.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
