// SPDX-License-Identifier: Apache-2.0
//! The first seeds violate nothing, and one seed is one run. `cargo xtask simulate` runs many more.

/// Whatever the program, the network, the clocks and the faults.
#[test]
fn the_first_seeds_violate_nothing() {
    lf_simulator::try_seeds(0..150).unwrap_or_else(|violation| panic!("{violation}"));
}

/// A federate that had resigned closed its connection while the RTI had not read all, because the receiver was slow.
#[test]
fn who_has_resigned_waits_for_a_slow_reader() {
    for seed in [2697, 4508] {
        lf_simulator::try_seeds(seed..seed + 1).unwrap_or_else(|violation| panic!("{violation}"));
    }
}

/// The hash of all that was written, when and where, and of all that reactions saw, is the same in a second run.
#[test]
fn a_seed_is_a_run_bit_for_bit() {
    let first = lf_simulator::try_seeds(0..40).unwrap_or_else(|violation| panic!("{violation}"));
    let second = lf_simulator::try_seeds(0..40).unwrap_or_else(|violation| panic!("{violation}"));
    assert_eq!(first, second);
}
