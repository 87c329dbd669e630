// SPDX-License-Identifier: Apache-2.0
//! The checks of the Rust workspace, which run on every computer.

use std::path::Path;
use std::process::Command;

use crate::counts::Counts;
use crate::editor;
use crate::process;
use crate::report::Report;
use crate::tidy::tree::Tree;

/// Checks the formatting of all crates, those outside the workspace too.
pub(crate) fn fmt(repository: &Path, report: &mut Report) {
    let tree = match Tree::read(repository) {
        Ok(tree) => tree,
        Err(error) => {
            report.fail("fmt", &format!("cannot read the tree: {error}"));
            return;
        }
    };
    let files = tree.files.iter().filter(|file| file.kind() == "rs").map(|file| &file.path);
    let mut command = Command::new("rustfmt");
    command.current_dir(repository).args(["--check", "--edition", "2024"]).args(files);
    let passed = process::succeeds(&mut command);
    report.check("fmt", passed);
}

/// The features that an image may have, one by one.
const IMAGE_FEATURES: [&str; 8] = ["", "datagrams", "ipv6", "peers", "security", "texts", "traces", "transients"];

/// Lints, with warnings as errors: of the workspace, of the grammar for editors if its parser can be generated, of the
/// crates of images with each of their features alone, and of the targets of cargo-fuzz.
pub(crate) fn clippy(repository: &Path, report: &mut Report) {
    let is_clean = |arguments: &[&str]| {
        let mut command = process::cargo(repository);
        process::succeeds(command.args(["clippy", "--quiet"]).args(arguments).args(["--", "-D", "warnings"]))
    };
    let has_parser = process::find_program("node").is_some();
    let workspace = if has_parser { &editor::WITH_PARSER[..] } else { &["--workspace"] };
    let mut passed = is_clean(&[workspace, &["--all-targets"]].concat());
    for feature in IMAGE_FEATURES {
        passed &= is_clean(&["--package", "lf-embedded", "--no-default-features", "--features", feature]);
    }
    passed &= is_clean(&["--manifest-path", "fuzz/Cargo.toml"]);
    report.check("clippy", passed);
}

/// The features of an image without IPv6, UDP and transient federates.
const FEW_FEATURES: &str = "peers,security,texts,traces";

/// Runs all tests of the workspace, and those of the event loops once more, with few features.
pub(crate) fn test(repository: &Path, report: &mut Report) {
    for (name, arguments) in [
        ("host", &["--workspace", "--no-fail-fast"][..]),
        ("host, few features", &["--package", "lf-runtime", "--no-default-features", "--features", FEW_FEATURES]),
    ] {
        let (succeeded, output) = process::teed(cargo_test(repository).args(arguments));
        report.runner(name, succeeded, Counts::from_cargo_test(&output));
    }
}

/// Returns the command that runs tests, twice as many at once as there are processors, because those that take longest
/// run federations, which wait for their start and for physical time.
fn cargo_test(repository: &Path) -> Command {
    let mut command = process::cargo(repository);
    if std::env::var_os("RUST_TEST_THREADS").is_none() {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        command.env("RUST_TEST_THREADS", (2 * processors).to_string());
    }
    command.arg("test");
    command
}
