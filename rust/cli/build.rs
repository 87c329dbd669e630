// SPDX-License-Identifier: Apache-2.0
//! Embeds the runtime's sources, if `cargo xtask dist` has put them into this package. A program that is built in its
//! repository finds them there.

use std::path::Path;
use std::{env, fs};

fn main() {
    let folder = env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let (archive, commit) = (Path::new(&folder).join("runtime.tar.gz"), Path::new(&folder).join("commit"));
    println!("cargo::rustc-check-cfg=cfg(embedded_runtime)");
    println!("cargo::rerun-if-changed={}", archive.display());
    println!("cargo::rerun-if-changed={}", commit.display());
    let commit = fs::read_to_string(commit).unwrap_or_default();
    let commit = if commit.trim().is_empty() { "of its repository" } else { commit.trim() };
    println!("cargo::rustc-env=LFZ_COMMIT={commit}");
    if archive.is_file() {
        println!("cargo::rustc-cfg=embedded_runtime");
    }
}
