// SPDX-License-Identifier: Apache-2.0
//! As in generated crates.

fn main() {
    lf_c_build::program().build();
}
