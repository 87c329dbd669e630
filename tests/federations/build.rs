// SPDX-License-Identifier: Apache-2.0
//! Tells the tests whether `LF_TEST_RTI` names another RTI: those that need one are counted as skipped otherwise.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(other_rti)");
    println!("cargo::rerun-if-env-changed=LF_TEST_RTI");
    if std::env::var_os("LF_TEST_RTI").is_some() {
        println!("cargo::rustc-cfg=other_rti");
    }
}
