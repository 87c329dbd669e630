// SPDX-License-Identifier: Apache-2.0
//! From a plan to text: a Rust crate per federate and, for Zephyr, a Kconfig fragment and a devicetree overlay.
//!
//! Nothing here reads or writes files; the caller does that with the [`Emitted`] it gets.

mod crate_layout;
mod crates;
pub mod deployment;
mod federate;
mod names;
mod network_buffers;
mod reactor;
mod rti;
mod source_map;
mod splice;
#[cfg(test)]
mod tests;
mod zephyr_config;

use core::fmt;

use crate::plan::{Federate, Location, Plan};
use crates::{Crate, CrateKind};
use deployment::{Deployment, Place, Platform, RtiHome};
use names::{Names, kebab_case};

pub use source_map::SourceMap;

/// What the caller decides about the generated crates.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The folder of the crate `lf-linux`, absolute or relative to a generated crate.
    pub lf_linux: &'a str,
    /// The folder of the crate `lf-zephyr`, absolute or relative to a generated crate.
    pub lf_zephyr: &'a str,
    /// The version of all packages. Cargo tells packages of one name apart by it, so two programs whose crates share
    /// cargo's intermediate results must not have the same.
    pub version: &'a str,
    /// Where the federates run.
    pub deployment: &'a Deployment,
}

/// All that was generated for a program.
#[derive(Clone, Debug)]
pub struct Emitted {
    /// The files.
    pub files: Vec<File>,
    /// The RTI, where it is an image of its own; then the federates in order of id, or the main reactor.
    pub participants: Vec<Participant>,
    /// From generated files back to the program.
    pub source_map: SourceMap,
}

/// What was generated for one federate, or for the RTI.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Participant {
    /// What it does in the federation.
    pub role: Role,
    /// The federate's name, or one that no federate has.
    pub name: String,
    /// The crate's folder below the output folder.
    pub folder: String,
    /// The crate's package.
    pub package: String,
    /// How it is built and run.
    pub artifact: Artifact,
}

/// What a participant does in the federation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It is the RTI, and nothing else.
    Rti,
    /// It is a federate, or a program that is not federated.
    Federate {
        /// The federate's id.
        id: u16,
        /// Whether the RTI is part of its image.
        joint_rti: bool,
    },
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
    if let (RtiHome::Image(place), Some(_)) = (&settings.deployment.rti.home, &plan.rti) {
        let name = rti_name(plan);
        let folder = folders.give(&name);
        if let Err(error) = emit_rti(plan, name, place, settings, folder, &mut emitted)
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

/// What the RTI is called where it is an image of its own: a name that no federate has.
pub fn rti_name(plan: &Plan) -> String {
    let mut name = "rti".to_owned();
    while plan.federates.iter().any(|federate| federate.name == name) {
        name.push('_');
    }
    name
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
    let name = federate.name.as_str();
    let joint_rti = plan.rti.is_some() && settings.deployment.is_joint(name);
    let (kind, package, artifact) = match &place.platform {
        Platform::Host => (CrateKind::Host, package, Artifact::Host),
        Platform::Zephyr(board) => {
            let text = zephyr_config::kconfig(plan, federate, settings.deployment);
            let artifact = image(plan, name, &folder, board.clone(), &place, text, emitted);
            (CrateKind::Zephyr, ZEPHYR_PACKAGE.to_owned(), artifact)
        }
    };
    let generated =
        Crate { plan, name, federate: Some(federate), rti: joint_rti, kind, folder: &folder, package: &package };
    generated.emit(settings, &mut emitted.files, &mut emitted.source_map)?;
    let role = Role::Federate { id: federate.id, joint_rti };
    emitted.participants.push(Participant { role, name: name.to_owned(), folder, package, artifact });
    Ok(())
}

/// The name that Zephyr's build knows a crate by.
const ZEPHYR_PACKAGE: &str = "rustapp";

/// Adds what an image has beside its crate.
fn image(
    plan: &Plan,
    name: &str,
    folder: &str,
    board: String,
    place: &Place,
    kconfig_text: String,
    emitted: &mut Emitted,
) -> Artifact {
    let (kconfig, overlay) = (format!("{folder}/{name}.conf"), format!("{folder}/{name}.overlay"));
    emitted.files.push(File { path: kconfig.clone(), text: kconfig_text });
    let label = place.ethernet.as_deref().or_else(|| zephyr_config::ethernet_label(&board));
    let text = zephyr_config::overlay(plan, name, place.mac.zip(label));
    emitted.files.push(File { path: overlay.clone(), text });
    Artifact::Zephyr { board, kconfig, overlay, place: Box::new(place.clone()) }
}

/// An image that is the RTI and nothing else. It comes first, because it is started first.
fn emit_rti(
    plan: &Plan,
    name: String,
    place: &Place,
    settings: &Settings<'_>,
    folder: String,
    emitted: &mut Emitted,
) -> Result<(), EmitError> {
    let Platform::Zephyr(board) = &place.platform else { return Ok(()) };
    let text = zephyr_config::rti_kconfig(plan, &name, place, settings.deployment);
    let artifact = image(plan, &name, &folder, board.clone(), place, text, emitted);
    let (kind, package) = (CrateKind::Zephyr, ZEPHYR_PACKAGE);
    let generated = Crate { plan, name: &name, federate: None, rti: true, kind, folder: &folder, package };
    generated.emit(settings, &mut emitted.files, &mut emitted.source_map)?;
    let participant = Participant { role: Role::Rti, name, folder, package: package.to_owned(), artifact };
    emitted.participants.insert(0, participant);
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
