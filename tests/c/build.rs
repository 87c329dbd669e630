// SPDX-License-Identifier: Apache-2.0
//! As in generated crates.

fn main() {
    lf_c_build::program().flag("-Wall").flag("-Wextra").define("GREETING", "\"hi\"").build();
}
