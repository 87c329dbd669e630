// SPDX-License-Identifier: Apache-2.0
//! From a plan to text: a Rust crate per federate and, for Zephyr, a Kconfig fragment and a devicetree overlay.
//!
//! Nothing here reads or writes files; the caller does that with the [`Emitted`] it gets.

mod crate_layout;
mod crates;
pub mod deployment;
mod federate;
mod names;
mod reactor;
mod source_map;
mod splice;
#[cfg(test)]
mod tests;
mod zephyr_config;

use core::fmt;

use crate::plan::{Federate, Location, Plan};
use crates::{Crate, CrateKind};
use deployment::{Deployment, Place, Platform};
use names::{Names, kebab_case};

pub use source_map::SourceMap;

/// What the caller decides about the generated crates.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The folder of the crate `lf-host`, absolute or relative to a generated crate.
    pub lf_host: &'a str,
    /// The folder of the crate `lf-zephyr`, absolute or relative to a generated crate.
    pub lf_zephyr: &'a str,
    /// Where the federates run.
    pub deployment: &'a Deployment,
}

/// All that was generated for a program.
#[derive(Clone, Debug)]
pub struct Emitted {
    /// The files.
    pub files: Vec<File>,
    /// The federates, or the main reactor, in order of id.
    pub participants: Vec<Participant>,
    /// From generated files back to the program.
    pub source_map: SourceMap,
}

/// What was generated for one federate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Participant {
    /// The federate's id.
    pub id: u16,
    /// The federate's name.
    pub name: String,
    /// The crate's folder below the output folder.
    pub folder: String,
    /// The crate's package.
    pub package: String,
    /// How it is built and run.
    pub artifact: Artifact,
}

/// How a participant is built and run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Artifact {
    /// A program of the cargo workspace in the output folder, named like the package.
    Host,
    /// A static library for a Zephyr image.
    Zephyr {
        /// The board, qualifiers included.
        board: String,
        /// The Kconfig fragment, below the output folder.
        kconfig: String,
        /// The devicetree overlay, below the output folder.
        overlay: String,
        /// Where it runs, with runner and probe.
        place: Box<Place>,
    },
}

/// Generates the crates of a program.
///
/// # Errors
/// For each federate the first thing of which no Rust can be made; each thing once.
pub fn emit(plan: &Plan, settings: &Settings<'_>) -> Result<Emitted, Vec<EmitError>> {
    let paths = plan.files.iter().map(|file| file.path.clone()).collect();
    let mut emitted = Emitted { files: Vec::new(), participants: Vec::new(), source_map: SourceMap::new(paths) };
    let mut errors: Vec<EmitError> = Vec::new();
    let (mut folders, mut packages) = (Names::default(), Names::default());
    for federate in &plan.federates {
        let folder = folders.give(&federate.name);
        let package = packages.give(&package_name(plan, federate)).replace('_', "-");
        if let Err(error) = emit_federate(plan, federate, settings, (folder, package), &mut emitted)
            && !errors.contains(&error)
        {
            errors.push(error);
        }
    }
    let is_host = |participant: &&Participant| participant.artifact == Artifact::Host;
    let members: Vec<String> =
        emitted.participants.iter().filter(is_host).map(|participant| participant.folder.clone()).collect();
    if !members.is_empty() {
        let text = crates::workspace_manifest(plan, &members);
        emitted.files.insert(0, File { path: "Cargo.toml".to_owned(), text });
    }
    if errors.is_empty() { Ok(emitted) } else { Err(errors) }
}

fn package_name(plan: &Plan, federate: &Federate) -> String {
    if plan.is_federated() {
        format!("{}-{}", kebab_case(&plan.name), kebab_case(&federate.name))
    } else {
        kebab_case(&plan.name)
    }
}

fn emit_federate(
    plan: &Plan,
    federate: &Federate,
    settings: &Settings<'_>,
    (folder, package): (String, String),
    emitted: &mut Emitted,
) -> Result<(), EmitError> {
    let place = settings.deployment.place(&federate.name);
    let (kind, package, artifact) = match &place.platform {
        Platform::Host => (CrateKind::Host, package, Artifact::Host),
        Platform::Zephyr(board) => {
            let (board, name) = (board.clone(), &federate.name);
            let (kconfig, overlay) = (format!("{folder}/{name}.conf"), format!("{folder}/{name}.overlay"));
            let text = zephyr_config::kconfig(plan, federate, settings.deployment);
            emitted.files.push(File { path: kconfig.clone(), text });
            let label = place.ethernet.as_deref().or_else(|| zephyr_config::ethernet_label(&board));
            let text = zephyr_config::overlay(plan, federate, place.mac.zip(label));
            emitted.files.push(File { path: overlay.clone(), text });
            let artifact = Artifact::Zephyr { board, kconfig, overlay, place: Box::new(place) };
            // The name that Zephyr's build knows the crate by.
            (CrateKind::Zephyr, "rustapp".to_owned(), artifact)
        }
    };
    let generated = Crate { plan, federate, kind, folder: &folder, package: &package };
    generated.emit(settings, &mut emitted.files, &mut emitted.source_map)?;
    emitted.participants.push(Participant { id: federate.id, name: federate.name.clone(), folder, package, artifact });
    Ok(())
}

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// The path below the output folder, with `/` between its parts.
    pub path: String,
    /// The text.
    pub text: String,
}

/// Something in the program of which no crate can be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmitError {
    /// The LF file.
    pub path: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
}

impl EmitError {
    fn new(plan: &Plan, at: Location, message: String) -> Self {
        Self { path: plan.path(at).to_owned(), line: at.line, column: at.column, message }
    }

    fn internal(generated: &str, error: &syn::Error) -> Self {
        let message = format!("this is a mistake of the compiler: what it generated is not Rust: {error}");
        Self { path: generated.to_owned(), line: 1, column: 1, message }
    }
}

impl fmt::Display for EmitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: error: {}", self.path, self.line, self.column, self.message)
    }
}

impl core::error::Error for EmitError {}
