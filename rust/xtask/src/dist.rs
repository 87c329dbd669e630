// SPDX-License-Identifier: Apache-2.0
//! Packages for people who install: those of the crates for cargo, and a wheel for pip with the program. The program in
//! them has the runtime's sources in itself, so it needs no clone of this repository.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::read::GzDecoder;
use flate2::{Compression, GzBuilder};
use tar::{Archive, Builder, Header};

use crate::process;
use crate::report::Report;
use crate::tidy::tree::Tree;

/// The files and folders that programs and images are compiled with.
const RUNTIME: &[&str] = &[
    "CMakeLists.txt",
    "Cargo.lock",
    "Cargo.toml",
    "Kconfig",
    "LICENSE",
    "boards/",
    "debug.conf",
    "prj.conf",
    "rust/c-build/",
    "rust/c/",
    "rust/coordination/",
    "rust/derive/",
    "rust/devices/",
    "rust/devicetree/",
    "rust/embedded/",
    "rust/linux/",
    "rust/model/",
    "rust/runtime/",
    "rust/secure/",
    "rust/texts/",
    "rust/wire/",
    "rust/zephyr/",
    "scripts/lf",
    "scripts/lf_commands.py",
    "scripts/lf_west/",
    "scripts/west-commands.yml",
    "src/",
    "west.yml",
    "zephyr/",
];

/// The crates that cargo can install lfz from, each after those that it depends on.
const PACKAGES: &[&str] = &[
    "lf-derive",
    "lf-texts",
    "lf-model",
    "lf-wire",
    "lf-secure",
    "lf-coordination",
    "lf-runtime",
    "lf-devices",
    "lf-c",
    "lf-linux",
    "lf-compiler",
    "lf-testkit",
    "lfz",
];

/// The package with the program.
const PROGRAM_PACKAGE: &str = "lfz";

/// The beginning of the wheel's name, by which pip finds it.
const WHEEL: &str = "lf_zephyr-";

/// The way in which the program is compiled.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Profile {
    Release,
    Debug,
}

/// Makes the packages and the wheel; returns a text that says where they are.
pub(crate) fn make(repository: &Path, profile: Profile) -> Result<String, String> {
    let dist = process::target_folder(repository).join("dist");
    let stage = dist.join("stage");
    let said = |what: &str, error: io::Error| format!("{what}: {error}");
    stage_sources(repository, &stage).map_err(|error| said("the sources cannot be copied", error))?;
    packages(&stage, &dist)?;
    unpack(repository, &dist).map_err(|error| said("the packages cannot be unpacked", error))?;
    let wheel = wheel(&dist, profile)?;
    Ok(format!("{}\n{}", dist.join("target/package").display(), wheel.display()))
}

/// Copies the files of the repository, and adds to lfz what it has in itself.
fn stage_sources(repository: &Path, stage: &Path) -> io::Result<()> {
    let tree = Tree::read(repository)?;
    let files: Vec<&str> = tree.files.iter().map(|file| file.path.as_str()).collect();
    for path in &files {
        write_if_changed(&stage.join(path), &fs::read(repository.join(path))?)?;
        let mode = fs::metadata(repository.join(path))?.permissions();
        fs::set_permissions(stage.join(path), mode)?;
    }
    write_if_changed(&stage.join("rust/cli/runtime.tar.gz"), &runtime(repository, &files)?)?;
    // Sources that come without git have no commit.
    let mut git = Command::new("git");
    let commit = process::captured(git.arg("-C").arg(repository).args(["rev-parse", "--short=12", "HEAD"]));
    write_if_changed(&stage.join("rust/cli/commit"), commit.unwrap_or_default().as_bytes())
}

/// Returns the archive of the runtime's sources, which is the same whenever they are.
fn runtime(repository: &Path, files: &[&str]) -> io::Result<Vec<u8>> {
    let is_part = |path: &&&str| {
        let is_below = |part: &&str| if part.ends_with('/') { path.starts_with(*part) } else { **path == *part };
        RUNTIME.iter().any(is_below) && !path.contains("/tests/") && !path.contains("/proptest-regressions/")
    };
    let mut archive = Builder::new(GzBuilder::new().mtime(0).write(Vec::new(), Compression::best()));
    for path in files.iter().filter(is_part) {
        let mut text = fs::read(repository.join(path))?;
        if *path == "Cargo.toml" {
            text = of_runtime(&String::from_utf8_lossy(&text)).into_bytes();
        }
        let mut header = Header::new_gnu();
        header.set_size(text.len() as u64);
        header.set_mode(if *path == "scripts/lf" { 0o755 } else { 0o644 });
        header.set_mtime(1);
        archive.append_data(&mut header, path, &text[..])?;
    }
    archive.into_inner()?.finish()
}

/// Returns the manifest of the workspace with those members alone that are part of the runtime.
fn of_runtime(manifest: &str) -> String {
    let is_part = |member: &&str| RUNTIME.contains(&format!("{}/", member.trim().trim_matches('"')).as_str());
    let lines = manifest.lines().filter(|line| !line.starts_with("default-members")).map(|line| {
        match line.strip_prefix("members = [").and_then(|rest| rest.strip_suffix(']')) {
            Some(members) => {
                let members: Vec<_> = members.split(',').filter(is_part).map(str::trim).collect();
                format!("members = [{}]", members.join(", "))
            }
            None => line.to_owned(),
        }
    });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// Packages the crates as cargo publishes them. What is installed is compiled from them, which cargo need not do, too.
fn packages(stage: &Path, dist: &Path) -> Result<(), String> {
    let mut cargo = process::cargo(stage);
    cargo.args(["package", "--quiet", "--no-verify", "--allow-dirty", "--target-dir"]).arg(dist.join("target"));
    cargo.args(PACKAGES.iter().flat_map(|package| ["--package", package]));
    run(&mut cargo)
}

/// Returns the name of a package with its version, which is that of all packages.
fn versioned(package: &str) -> String {
    format!("{package}-{}", env!("CARGO_PKG_VERSION"))
}

/// Unpacks the packages into a workspace in which they find each other, as they do in cargo's registry once they are
/// published.
fn unpack(repository: &Path, dist: &Path) -> io::Result<()> {
    let unpacked = dist.join("unpacked");
    for package in PACKAGES {
        let name = versioned(package);
        let mut archive = Archive::new(GzDecoder::new(File::open(dist.join(format!("target/package/{name}.crate")))?));
        for entry in archive.entries()? {
            let mut entry = entry?;
            let (path, mut contents) = (unpacked.join(entry.path()?), Vec::new());
            entry.read_to_end(&mut contents)?;
            write_if_changed(&path, &contents)?;
        }
    }
    let members: Vec<_> = PACKAGES.iter().map(|package| versioned(package)).collect();
    let patches = PACKAGES.iter().map(|package| format!("{package}.path = {:?}\n", versioned(package)));
    let patches: String = patches.collect();
    let workspace = format!("[workspace]\nresolver = \"3\"\nmembers = {members:?}\n\n[patch.crates-io]\n{patches}");
    write_if_changed(&unpacked.join("Cargo.toml"), workspace.as_bytes())?;
    write_if_changed(&unpacked.join("Cargo.lock"), &fs::read(repository.join("Cargo.lock"))?)
}

fn wheel(dist: &Path, profile: Profile) -> Result<PathBuf, String> {
    let wheels = dist.join("wheels");
    // Only the present one is there afterwards.
    let _ = fs::remove_dir_all(&wheels);
    let mut maturin = Command::new("maturin");
    let manifest = dist.join("unpacked").join(versioned(PROGRAM_PACKAGE)).join("Cargo.toml");
    maturin.args(["build", "--quiet", "--manifest-path"]).arg(manifest);
    maturin.arg("--out").arg(&wheels).arg("--target-dir").arg(dist.join("target"));
    maturin.args(["--compatibility", "linux"]);
    if profile == Profile::Release {
        maturin.arg("--release");
    }
    run(&mut maturin)?;
    let entries = fs::read_dir(&wheels).map_err(|error| error.to_string())?;
    let mut found = entries.flatten().map(|entry| entry.path());
    let is_wheel = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(WHEEL));
    found.find(is_wheel).ok_or_else(|| format!("maturin has made no wheel whose name begins with {WHEEL}"))
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} has failed")) }
}

fn write_if_changed(file: &Path, contents: &[u8]) -> io::Result<()> {
    if fs::read(file).is_ok_and(|present| present == contents) {
        return Ok(());
    }
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    File::create(file)?.write_all(contents)
}

/// The program that is compiled and run with what was installed.
const PROGRAM: &str =
    "target Rust { timeout: 1 ms }\nmain reactor { reaction(startup) {= println!(\"installed\"); =} }\n";

/// Installs the wheel and the packages into an empty home, and runs a program with each.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    report.begin("dist");
    if Command::new("maturin").arg("--version").output().is_err() {
        report.skip("dist", "maturin is not installed (pip install maturin)");
        return;
    }
    let outcome = installed(repository);
    if let Err(error) = &outcome {
        eprintln!("{error}");
    }
    report.check("dist", outcome.is_ok());
}

fn installed(repository: &Path) -> Result<(), String> {
    make(repository, Profile::Debug)?;
    let dist = process::target_folder(repository).join("dist");
    let home = dist.join("home of nobody");
    let _ = fs::remove_dir_all(&home);
    let said = |error: io::Error| error.to_string();
    fs::create_dir_all(&home).map_err(said)?;
    fs::write(home.join("Hello.lf"), PROGRAM).map_err(said)?;
    run(Command::new("python3").args(["-m", "venv"]).arg(home.join("venv")))?;
    let wheels = fs::read_dir(dist.join("wheels")).map_err(said)?;
    let wheels: Vec<_> = wheels.flatten().map(|entry| entry.path()).collect();
    run(Command::new(home.join("venv/bin/pip")).args(["install", "--quiet", "--no-index"]).args(&wheels))?;
    try_out(&home, &home.join("venv/bin/lfz"))?;
    let mut cargo = process::cargo(&dist.join("unpacked"));
    cargo.args(["install", "--quiet", "--debug", "--path"]).arg(versioned(PROGRAM_PACKAGE));
    cargo.arg("--target-dir").arg(dist.join("target")).arg("--root").arg(home.join("cargo"));
    run(&mut cargo)?;
    try_out(&home, &home.join("cargo/bin/lfz"))
}

/// Runs a program with an installed lfz, which has to have the runtime in itself.
fn try_out(home: &Path, program: &Path) -> Result<(), String> {
    let lfz = |arguments: &[&str]| -> Result<String, String> {
        let mut command = Command::new(program);
        command.current_dir(home).args(arguments).env("HOME", home).env_remove("XDG_CACHE_HOME");
        command.env_remove("CARGO_TARGET_DIR").env_remove("LFZ_HOME");
        // The crates of others are where the user's cargo has them.
        let cargo = std::env::var_os("CARGO_HOME").map_or_else(|| old_home().join(".cargo"), PathBuf::from);
        let rustup = std::env::var_os("RUSTUP_HOME").map_or_else(|| old_home().join(".rustup"), PathBuf::from);
        let output = command.env("CARGO_HOME", cargo).env("RUSTUP_HOME", rustup).output();
        let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
        if !output.status.success() {
            return Err(format!("lfz {arguments:?}: {}", String::from_utf8_lossy(&output.stderr)));
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let place = lfz(&["home"])?;
    if !Path::new(place.trim()).starts_with(home) {
        return Err(format!("the runtime is in {place}, and not in the home of its user"));
    }
    let printed = lfz(&["run", "Hello.lf"])?;
    if printed != "installed\n" {
        return Err(format!("the program printed {printed:?}"));
    }
    lfz(&["west", "lf-fed-build", "--help"]).map(drop)
}

fn old_home() -> PathBuf {
    std::env::var_os("HOME").map(PathBuf::from).unwrap_or_default()
}
