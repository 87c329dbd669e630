// SPDX-License-Identifier: Apache-2.0
//! The twister suites of this repository: as programs of this computer, and on a small board that QEMU plays.
//!
//! Twister has one tool chain per run, so there is a run per platform.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;
use crate::zephyr::{Workspace, compiler, has_zephyr_sdk, workspace_or_skip};

/// A Linux program with the host's network.
const NATIVE: &str = "native_sim/native/64";
/// A Cortex-M3 with 64 KiB of RAM.
const BOARD: &str = "qemu_cortex_m3";

/// Runs the suites on each platform.
pub(crate) fn run(repository: &Path, report: &mut Report) {
    let Some(workspace) = workspace_or_skip("twister", repository, report) else { return };
    let suites = suites(repository);
    if suites.is_empty() {
        report.skip("twister", "there is no testcase.yaml or sample.yaml in applications/ and tests/");
        return;
    }
    // Applications are generated while they are configured.
    let compiler = Vec::from_iter(compiler(repository).map(|(name, path)| (name, path.into_os_string())));
    let platforms = [("native_sim", NATIVE, Ok(variables_for_native())), (BOARD, BOARD, variables_for_arm())];
    for (name, platform, variables) in platforms {
        match variables {
            Ok(variables) => {
                let variables = [&compiler[..], &variables].concat();
                run_on(name, platform, &variables, &suites, &workspace, repository, report);
            }
            Err(missing) => report.skip(&format!("twister {name}"), &missing),
        }
    }
    lint(repository, report);
}

fn run_on(
    name: &str,
    platform: &str,
    variables: &[(&str, OsString)],
    suites: &[PathBuf],
    workspace: &Workspace,
    repository: &Path,
    report: &mut Report,
) {
    let name = format!("twister {name}");
    if report.is_too_late(&name) {
        return;
    }
    let output = output_folder(repository, platform);
    let mut command = workspace.command("west");
    command.current_dir(workspace.top()).args(["twister", "--platform", platform, "--no-detailed-test-id"]);
    command.args(["--inline-logs", "--clobber-output", "--outdir"]).arg(&output);
    // All images, those of the west commands too, compile their common part once.
    command.env("CARGO_TARGET_DIR", repository.join("target/lf-zephyr"));
    // Images differ by their folder, which ccache has to ignore.
    for (variable, value) in [("CCACHE_BASEDIR", output.clone().into_os_string()), ("CCACHE_NOHASHDIR", "1".into())] {
        if env::var_os(variable).is_none() {
            command.env(variable, value);
        }
    }
    command.envs(variables.iter().map(|(name, value)| (name, value)));
    for suite in suites {
        command.arg("--testsuite-root").arg(suite);
    }
    let succeeded = process::succeeds(&mut command);
    let json = fs::read_to_string(output.join("twister.json")).unwrap_or_default();
    match Counts::from_twister(&json) {
        Some(counts) => report.runner(&name, succeeded, counts),
        None => report.fail(&name, "twister left no readable twister.json"),
    }
}

/// Lints the crates of the suites in `tests/`, which only a build for Zephyr can read, as they were built for this
/// computer.
fn lint(repository: &Path, report: &mut Report) {
    let mut found = Vec::new();
    collect(&output_folder(repository, NATIVE), &["cargo_settings.cmake"], &[], &mut found);
    let tests = format!("set(crate [==[{}/", repository.join("tests").display());
    let mut settings = found.into_iter().map(|folder| folder.join("cargo_settings.cmake")).collect::<Vec<_>>();
    settings.retain(|file| fs::read_to_string(file).is_ok_and(|text| text.contains(&tests)));
    if settings.is_empty() {
        report.skip("twister clippy", "no suite in tests/ was built for this computer");
        return;
    }
    let mut passed = true;
    for settings in settings {
        let mut command = Command::new("cmake");
        command.arg(format!("-DSETTINGS={}", settings.display())).args(["-DLINT=image", "-P"]);
        passed &= process::succeeds(command.arg(repository.join("zephyr/cmake/lf_cargo_build.cmake")));
    }
    report.check("twister clippy", passed);
}

type Variables = Vec<(&'static str, OsString)>;

/// The variable that names the kind of tool chain.
const VARIANT: &str = "ZEPHYR_TOOLCHAIN_VARIANT";

/// Returns the variables that choose this computer's compiler, which twister, unlike the build, does not find by
/// itself.
fn variables_for_native() -> Variables {
    let chosen = env::var_os(VARIANT).is_some() || has_zephyr_sdk();
    if chosen { Vec::new() } else { vec![(VARIANT, "host".into())] }
}

/// Returns the variables that choose a compiler for Arm which twister knows, or what is missing for images on the
/// board.
fn variables_for_arm() -> Result<Variables, String> {
    if process::find_program("qemu-system-arm").is_none() {
        return Err("there is no qemu-system-arm: apt install qemu-system-arm".to_owned());
    }
    // The user's choice counts, unless it is that for programs of this computer.
    if env::var_os(VARIANT).is_some_and(|variant| variant != "host") {
        return Ok(Vec::new());
    }
    if has_zephyr_sdk() {
        return Ok(vec![(VARIANT, "zephyr".into())]);
    }
    // Zephyr looks for it in the folder `bin` of a given folder.
    let folder = process::find_program("arm-none-eabi-gcc").and_then(|compiler| fs::canonicalize(compiler).ok());
    let folder = folder.as_deref().and_then(Path::parent).filter(|folder| folder.ends_with("bin"));
    match folder.and_then(Path::parent) {
        Some(folder) => Ok(vec![(VARIANT, "gnuarmemb".into()), ("GNUARMEMB_TOOLCHAIN_PATH", folder.into())]),
        None => Err("no compiler for Arm: install the Zephyr SDK, or apt install gcc-arm-none-eabi \
            libnewlib-arm-none-eabi"
            .to_owned()),
    }
}

/// Returns the folder in which twister builds for a platform.
fn output_folder(repository: &Path, platform: &str) -> PathBuf {
    repository.join("target/twister").join(platform.replace('/', "_"))
}

/// Returns the folders below `applications/` and `tests/` with a twister suite.
fn suites(repository: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["applications", "tests"] {
        let (files, builds) = (["testcase.yaml", "sample.yaml"], ["build", "target"]);
        collect(&repository.join(folder), &files, &builds, &mut found);
    }
    found.sort();
    found
}

/// Adds the folders with one of these files that are not below another such folder, nor in one with a name to skip.
fn collect(folder: &Path, files: &[&str], skipped: &[&str], found: &mut Vec<PathBuf>) {
    if files.iter().any(|name| folder.join(name).is_file()) {
        found.push(folder.to_path_buf());
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if entry.path().is_dir() && !skipped.iter().any(|skipped| name == *skipped) {
            collect(&entry.path(), files, skipped, found);
        }
    }
}
