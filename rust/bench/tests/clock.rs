// SPDX-License-Identifier: Apache-2.0
//! The rows of `lf-bench --only clock` stay within bounds, in virtual time.

use std::time::Duration;

use lf_bench::Samples;
use lf_bench::clock::{DRIFT_PPB, Network, Ours, Stock, run};

const SEEDS: std::ops::Range<u64> = 1..4;

fn micros(samples: &Samples, percent: usize) -> u128 {
    samples.percentile(percent).as_micros()
}

#[test]
fn rounds_keep_a_drifting_clock_within_the_goal_on_every_network() {
    for network in Network::ALL {
        // The goal is 50 µs in a quiet network, else 5 % of the jitter.
        let goal = Duration::from_nanos(network.jitter_ns.unsigned_abs() / 20).max(Duration::from_micros(50));
        for seed in SEEDS {
            let mut ours = Ours::default();
            let errors = run(&mut ours, &network, seed, true);
            assert!(errors.percentile(50) <= goal, "{}: median {} µs", network.name, micros(&errors, 50));
            assert!(errors.percentile(100) <= 2 * goal, "{}: worst {} µs", network.name, micros(&errors, 100));
            let drift = ours.drift_ppb().map(i64::from).unwrap_or_default();
            assert!((drift + DRIFT_PPB).abs() < 5_000, "{}: {drift} ppb", network.name);
        }
    }
}

#[test]
fn an_initial_offset_alone_is_lost_to_drift_but_never_silently_absent() {
    for network in Network::ALL {
        for seed in SEEDS {
            let errors = run(&mut Ours::default(), &network, seed, false);
            // The bound is 26 µs/s for a minute, and the part of the jitter that remains in the fastest of ten
            // exchanges.
            let worst = errors.percentile(100);
            assert!(worst <= Duration::from_micros(1_600) + Duration::from_millis(1), "{}: {worst:?}", network.name);
        }
    }
}

#[test]
fn the_stock_algorithm_is_modelled_with_what_it_is_known_for() {
    let quiet = run(&mut Stock::default(), &Network::QUIET, 1, true);
    assert!(micros(&quiet, 50) < 50, "it works where it is quiet: {} µs", micros(&quiet, 50));
    let jitter = run(&mut Stock::default(), &Network::JITTER, 1, true);
    assert!(jitter.percentile(50) > Duration::from_millis(900), "with jitter it discards all that it has measured");
}
