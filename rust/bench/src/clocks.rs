// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization: the algorithms in virtual time, and the exchanges before the start.

use lf_bench::clock::{Network, Ours, Stock, offsets, run};
use lf_bench::{InitialExchanges, Measured, Result, micros};

use crate::arguments::Arguments;

/// The number of federations with exchanges before the start, for each round.
const INITIAL_RUNS: u32 = 10;
const SECOND_NS: i64 = 1_000_000_000;

pub(crate) fn clock(rounds: u32) -> Result<()> {
    for network in Network::ALL {
        for (mode, on) in [("init", false), ("on", true)] {
            let row = format!("{}, {mode}", network.name);
            for seed in 1..=u64::from(rounds) {
                let ours = run(&mut Ours::default(), &network, seed, on);
                let stock = run(&mut Stock::default(), &network, seed, on);
                for (who, errors) in [("ours", ours), ("stock algorithm", stock)] {
                    for (unit, percent) in [("median µs", 50), ("worst µs", 100)] {
                        let value = micros(errors.percentile(percent));
                        Measured::value("clock", &row, who, unit, value).print()?;
                    }
                }
            }
        }
    }
    // Prints our errors in a quiet network, sampled once a second.
    for (mode, on) in [("init", false), ("on", true)] {
        let seen = offsets(&mut Ours::default(), &Network::QUIET, 1, on);
        let seen = seen.into_iter().filter(|(at, _)| at % SECOND_NS == 0);
        #[expect(clippy::cast_precision_loss, reason = "offsets are far below 2^53 ns")]
        let samples: Vec<f64> = seen.map(|(_, offset)| offset as f64 / 1e3).collect();
        let last = samples.last().copied().unwrap_or_default();
        Measured { samples, ..Measured::value("clock", "offset", mode, "offset µs", last) }.print()?;
    }
    Ok(())
}

pub(crate) fn initial(arguments: &Arguments) -> Result<()> {
    let programs = arguments.programs();
    for federates in [1, 3, 8, 32] {
        let row = if federates == 1 { "1 federate".to_owned() } else { format!("{federates} federates") };
        for _ in 0..INITIAL_RUNS * arguments.rounds {
            for program in &programs {
                let seen = InitialExchanges::run(program, federates)?;
                Measured::samples("initial", &row, program.name(), "spread µs", &seen.spreads).print()?;
                Measured::samples("initial", &row, program.name(), "answer µs", &seen.answers).print()?;
            }
        }
    }
    Ok(())
}
