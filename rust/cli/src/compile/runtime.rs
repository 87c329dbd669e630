// SPDX-License-Identifier: Apache-2.0
//! The crates of this repository on which programs depend, compiled once for all programs with the same needs.
//!
//! Cargo locks a folder as long as it compiles in it. So each program has a folder of its own, and takes the shared
//! results over into it. Cargo finds them up to date, as it would after the folder had been moved.

use std::collections::BTreeSet;
use std::fs::{self, FileTimes};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{MetadataExt, PermissionsExt as _};
use std::path::{Path, PathBuf};

use lf_compiler::emit::Participant;
use toml_edit::{DocumentMut, Item, Table, value};

use super::cargo::Job;
use super::files;
use super::progress::Progress;
use super::store::Locked;
use crate::failure::Failure;

/// The file that counts cargo's compilations, in the folder of a runtime and in those of programs that have taken it
/// over.
const GENERATION: &str = "generation";

/// The name of packages without code of their own.
const PACKAGE: &str = "program-without-code";

/// Packages with the dependencies of a program's packages in this repository, and no others.
pub(super) struct Runtime {
    workspace: String,
    manifests: Vec<String>,
}

impl Runtime {
    /// Returns the dependencies of the packages of these participants.
    ///
    /// # Errors
    /// When their manifests cannot be read.
    pub(super) fn of(out: &Path, home: &Path, participants: &[&Participant]) -> Result<Self, Failure> {
        let read = |path: PathBuf| -> Result<DocumentMut, Failure> {
            let text = fs::read_to_string(&path).map_err(|error| error.to_string());
            let parsed = text.and_then(|text| text.parse().map_err(|error: toml_edit::TomlError| error.to_string()));
            parsed.map_err(|error| Failure::message(format!("cannot read {}: {error}", path.display())))
        };
        let mut manifests = BTreeSet::new();
        for participant in participants {
            let own = read(out.join(&participant.folder).join("Cargo.toml"))?;
            let mut manifest = DocumentMut::new();
            for key in ["dependencies", "build-dependencies"] {
                manifest[key] = Item::Table(of_repository(own.get(key), home));
            }
            manifests.insert(manifest.to_string());
        }
        let (own, mut workspace) = (read(out.join("Cargo.toml"))?, DocumentMut::new());
        // The comment does not count, because it names the program.
        let mut table = Table::new();
        table["resolver"] = own["workspace"]["resolver"].clone();
        table["members"] = value((0..manifests.len()).map(package).collect::<toml_edit::Array>());
        workspace["workspace"] = Item::Table(table);
        workspace["profile"] = own.get("profile").cloned().unwrap_or_default();
        Ok(Self { workspace: workspace.to_string(), manifests: manifests.into_iter().collect() })
    }

    /// Returns the identity of the runtimes that a program needs.
    pub(super) fn needs(&self) -> String {
        self.manifests.concat() + &self.workspace
    }

    /// Brings the runtime up to date for a program that `job` compiles, and takes it over into that program's folder.
    /// Code that does not compile is reported better by the program's own build.
    ///
    /// # Errors
    /// When cargo cannot be run, or files cannot be written.
    pub(super) fn prepare(&self, home: &Path, locked: &Locked, job: &Job<'_>, progress: &Progress) -> io::Result<()> {
        let (workspace, build) = (locked.folder.join("workspace"), locked.folder.join("build"));
        self.write(&workspace)?;
        files::copy_newer(&home.join("Cargo.lock"), &workspace.join("Cargo.lock"))?;
        if !locked.folder.join(GENERATION).exists() {
            progress.wait("Compiling the runtime crates, once for all programs");
        }
        let packages: Vec<String> = (0..self.manifests.len()).map(package).collect();
        let target = &locked.folder.join("target");
        let own = Job { workspace: &workspace, packages: &packages, target, build: &build, ..*job };
        let outcome = own.run(progress)?;
        let generation = read_generation(&locked.folder);
        if outcome.has_changed || generation.is_empty() {
            let next = generation.parse().unwrap_or(0_u64) + 1;
            fs::write(locked.folder.join(GENERATION), next.to_string())?;
        }
        let current = format!("{}\n{}", locked.folder.display(), read_generation(&locked.folder));
        if read_generation(job.build) != current {
            take_over(&build, job.build)?;
            fs::write(job.build.join(GENERATION), current)?;
        }
        Ok(())
    }

    fn write(&self, folder: &Path) -> io::Result<()> {
        let mut all = vec![("Cargo.toml".to_owned(), self.workspace.clone())];
        for (index, manifest) in self.manifests.iter().enumerate() {
            let name = package(index);
            let head = format!("[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n");
            all.push((format!("{name}/Cargo.toml"), head + manifest));
            for (file, text) in [("src/main.rs", "//! Nothing.\nfn main() {}\n"), ("build.rs", "fn main() {}\n")] {
                all.push((format!("{name}/{file}"), text.to_owned()));
            }
        }
        files::write(folder, all.iter().map(|(path, text)| (path.as_str(), text.as_str())))
    }
}

fn package(index: usize) -> String {
    format!("{PACKAGE}-{index}")
}

/// Returns the dependencies in the repository.
fn of_repository(dependencies: Option<&Item>, home: &Path) -> Table {
    let mut table = Table::new();
    for (name, item) in dependencies.and_then(Item::as_table).into_iter().flatten() {
        let path = item.get("path").and_then(Item::as_str);
        if path.is_some_and(|path| Path::new(path).starts_with(home)) {
            table.insert(name, item.clone());
        }
    }
    table
}

fn read_generation(folder: &Path) -> String {
    fs::read_to_string(folder.join(GENERATION)).unwrap_or_default()
}

/// Makes cargo's results in one folder available in another.
fn take_over(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (name, path) = (entry.file_name(), entry.path());
        let text = name.to_string_lossy();
        // These are files of the folder itself, and of packages without code.
        if text == "incremental" || [PACKAGE, "program_without_code"].iter().any(|own| text.contains(own)) {
            continue;
        }
        let target = to.join(&name);
        if entry.file_type()?.is_dir() {
            take_over(&path, &target)?;
        } else if !text.ends_with("lock") {
            take_over_file(&path, &target)?;
        }
    }
    Ok(())
}

/// Takes over a file. Files of rustc and linkers become hard links, because new builds replace them; cargo's files
/// become copies of the same age, because cargo compares ages.
fn take_over_file(from: &Path, to: &Path) -> io::Result<()> {
    let (origin, present) = (fs::metadata(from)?, fs::metadata(to));
    let is_same = |present: &fs::Metadata| {
        (present.dev(), present.ino()) == (origin.dev(), origin.ino())
            || (present.len() == origin.len() && present.modified().ok() == origin.modified().ok())
    };
    if present.as_ref().is_ok_and(is_same) {
        return Ok(());
    }
    if present.is_ok() {
        fs::remove_file(to)?;
    }
    let is_library = from.extension().is_some_and(|kind| kind == "rlib" || kind == "rmeta" || kind == "so");
    let is_build_script = origin.permissions().mode() & 0o111 != 0;
    if (is_library || is_build_script) && fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    match fs::copy(from, to) {
        Ok(_) => {}
        // Cargo removes its temporary files.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    }
    let copy = fs::File::options().write(true).open(to)?;
    copy.set_times(FileTimes::new().set_modified(origin.modified()?))
}
