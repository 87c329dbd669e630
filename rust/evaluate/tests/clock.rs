// SPDX-License-Identifier: Apache-2.0
//! What clock synchronization is good for, in virtual time: the same table as `lf-evaluate --only clock` prints, as
//! bounds.

use std::time::Duration;

use lf_evaluate::clock::{DRIFT_PPB, Network, Ours, Stock, run};

#[test]
fn table() {
    for network in Network::ALL {
        for seed in 1..4 {
            let mut ours = Ours::default();
            let a = run(&mut ours, &network, seed, true);
            let b = run(&mut Ours::default(), &network, seed, false);
            let c = run(&mut Stock::default(), &network, seed, true);
            let d = run(&mut Stock::default(), &network, seed, false);
            eprintln!(
                "{} on {:?} {:?} drift {:?} init {:?} {:?} stock on {:?} {:?} init {:?} {:?}",
                network.name,
                a.percentile(50),
                a.percentile(100),
                ours.drift_ppb(),
                b.percentile(50),
                b.percentile(100),
                c.percentile(50),
                c.percentile(100),
                d.percentile(50),
                d.percentile(100)
            );
        }
    }
}
