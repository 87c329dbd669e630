// SPDX-License-Identifier: Apache-2.0
//! The program that `cargo xtask simulate` runs.

use std::process::ExitCode;

fn main() -> ExitCode {
    lf_simulator::main()
}
