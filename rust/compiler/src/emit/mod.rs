// SPDX-License-Identifier: Apache-2.0
//! Emits text from a plan: a crate per federate and, for Zephyr, a Kconfig fragment and a devicetree overlay.
//!
//! `host` writes the crates and does not depend on a language; `rust` and `c` write the bodies, and do not depend on
//! each other.
//!
//! This module neither reads nor writes files; the caller does that with the [`Emitted`] that it gets.

mod c;
mod file;
mod host;
mod job;
pub(crate) mod names;
mod rust;
mod source_map;
#[cfg(test)]
mod tests;
mod view;

use crate::boards::ethernet_label;
use crate::deployment::{Deployment, Place, Platform, RtiHome};
use crate::lexical::Language;
use crate::plan::{Federate, Plan};
use crate::stack::with_stack;
use crate::zephyr::{federate_kconfig, overlay, rti_kconfig};
use names::{Names, package_name, shortened};
use view::View;

pub use file::{EmitError, File};
pub(crate) use job::Job;
pub use job::Settings;
pub(crate) use source_map::{Anchor, FileMap, Lines, Origin, Piece};
pub use source_map::{SourceMap, VerbatimPart};

/// All generated files of a program.
#[derive(Clone, Debug)]
pub struct Emitted {
    /// The files.
    pub files: Vec<File>,
    /// The RTI, if it is an image of its own; then the federates in order of id, or the main reactor.
    pub participants: Vec<Participant>,
    /// The map from generated files to the program.
    pub source_map: SourceMap,
}

/// The generated crate of one federate, or of the RTI.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Participant {
    /// Its role in the federation.
    pub role: Role,
    /// The federate's name, or one that no federate has.
    pub name: String,
    /// The crate's folder below the output folder.
    pub folder: String,
    /// The crate's package.
    pub package: String,
    /// The artifact of its build.
    pub artifact: Artifact,
}

/// The role of a participant in the federation.
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

/// The artifact of a participant's build.
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
        /// Its place, with runner and probe.
        place: Box<Place>,
        /// The files of the image for its spare board, if it has one: the same program with other addresses.
        spare: Option<SpareFiles>,
    },
}

/// The settings of the image of a spare board, whose place is in that of the first board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpareFiles {
    /// The Kconfig fragment, below the output folder.
    pub kconfig: String,
    /// The devicetree overlay, below the output folder.
    pub overlay: String,
}

/// Generates the crates of a program.
///
/// # Errors
/// For each federate the first element that cannot be emitted; each element once.
pub fn emit(plan: &Plan, settings: &Settings<'_>) -> Result<Emitted, Vec<EmitError>> {
    with_stack(|| emitted(plan, settings))
}

fn emitted(plan: &Plan, settings: &Settings<'_>) -> Result<Emitted, Vec<EmitError>> {
    let paths = plan.files.iter().map(|file| file.path.clone()).collect();
    let emitted = Emitted { files: Vec::new(), participants: Vec::new(), source_map: SourceMap::new(paths) };
    let mut work = Emitter { plan, settings, emitted, errors: Vec::new() };
    let (mut folders, mut packages) = (Names::default(), Names::default());
    for federate in &plan.federates {
        let folder = folders.give(&shortened(&federate.name, '_'));
        let package = packages.give(&package_of(plan, federate)).replace('_', "-");
        let participant = work.federate(federate, folder, package);
        work.emitted.participants.push(participant);
    }
    if let (RtiHome::Image(place), Some(_)) = (&settings.deployment.rti.home, &plan.rti) {
        let name = rti_name(plan);
        let folder = folders.give(&name);
        if let Some(participant) = work.rti(name, place, folder) {
            // It is first because it starts first.
            work.emitted.participants.insert(0, participant);
        }
    }
    let Emitter { mut emitted, errors, .. } = work;
    let is_host = |participant: &&Participant| participant.artifact == Artifact::Host;
    let folders: Vec<String> =
        emitted.participants.iter().filter(is_host).map(|participant| participant.folder.clone()).collect();
    if !folders.is_empty() {
        emitted.files.insert(0, host::of_workspace(plan, &folders));
    }
    if errors.is_empty() { Ok(emitted) } else { Err(errors) }
}

/// Returns the name of the RTI if it is an image of its own: a name that no federate has.
pub fn rti_name(plan: &Plan) -> String {
    let mut name = "rti".to_owned();
    while plan.federates.iter().any(|federate| federate.name == name) {
        name.push('_');
    }
    name
}

fn package_of(plan: &Plan, federate: &Federate) -> String {
    let crates = plan.target.cargo.dependencies.iter().map(|one| one.name.as_str());
    package_name(&plan.name, plan.is_federated().then_some(&federate.name), crates)
}

/// The name by which Zephyr's build knows a crate.
const ZEPHYR_PACKAGE: &str = "rustapp";

struct Emitter<'a> {
    plan: &'a Plan,
    settings: &'a Settings<'a>,
    emitted: Emitted,
    errors: Vec<EmitError>,
}

impl Emitter<'_> {
    fn federate(&mut self, federate: &Federate, folder: String, package: String) -> Participant {
        let (plan, deployment) = (self.plan, self.settings.deployment);
        let place = deployment.place(&federate.name);
        let name = federate.name.clone();
        let joint_rti = plan.rti.is_some() && deployment.is_joint(&name);
        let (package, artifact) = match &place.platform {
            Platform::Host => (package, Artifact::Host),
            Platform::Zephyr(board) => {
                let is_cpp = View::new(plan, plan.language_of(federate)).native.is_cpp;
                let kconfig =
                    |places: &Deployment| federate_kconfig(plan, federate, places, self.settings.keys, is_cpp);
                let (first, second) = (kconfig(deployment), deployment.with_spare(&name).as_ref().map(kconfig));
                let spare = place.spare.as_deref().zip(second).map(|(spare, text)| {
                    let (kconfig, overlay) = self.image_files(&name, &format!("{folder}/spare"), board, spare, text);
                    SpareFiles { kconfig, overlay }
                });
                let (kconfig, overlay) = self.image_files(&name, &folder, board, &place, first);
                let board = board.clone();
                let artifact = Artifact::Zephyr { board, kconfig, overlay, place: Box::new(place), spare };
                (ZEPHYR_PACKAGE.to_owned(), artifact)
            }
        };
        let role = Role::Federate { id: federate.id, joint_rti };
        self.program(Participant { role, name, folder, package, artifact }, Some(federate))
    }

    /// Adds an image that is the RTI and nothing else.
    fn rti(&mut self, name: String, place: &Place, folder: String) -> Option<Participant> {
        let Platform::Zephyr(board) = &place.platform else { return None };
        let text = rti_kconfig(self.plan, &name, place, self.settings.deployment, self.settings.keys);
        let (kconfig, overlay) = self.image_files(&name, &folder, board, place, text);
        let (board, place) = (board.clone(), Box::new(place.clone()));
        let artifact = Artifact::Zephyr { board, kconfig, overlay, place, spare: None };
        let package = ZEPHYR_PACKAGE.to_owned();
        Some(self.program(Participant { role: Role::Rti, name, folder, package, artifact }, None))
    }

    /// Adds the files of an image beside its program; returns the paths of the Kconfig fragment and of the overlay.
    fn image_files(&mut self, name: &str, folder: &str, board: &str, place: &Place, text: String) -> (String, String) {
        let (kconfig, overlay_path) = (format!("{folder}/{name}.conf"), format!("{folder}/{name}.overlay"));
        self.emitted.files.push(File { path: kconfig.clone(), text });
        let label = place.ethernet.as_deref().or_else(|| ethernet_label(board));
        let text = overlay(self.plan, name, place.mac.zip(label));
        self.emitted.files.push(File { path: overlay_path.clone(), text });
        (kconfig, overlay_path)
    }

    /// Adds the program of a participant.
    fn program(&mut self, participant: Participant, federate: Option<&Federate>) -> Participant {
        let rti = matches!(participant.role, Role::Rti | Role::Federate { joint_rti: true, .. });
        let main = self.plan.language_of_class(self.plan.main);
        let language = federate.map_or(main, |federate| self.plan.language_of(federate));
        let view = View::new(self.plan, language);
        let passed_on = if rti { self.plan.lengths_beside(language) } else { Ok(Vec::new()) };
        let result = passed_on.and_then(|passed_on| {
            let job = Job {
                view: &view,
                settings: self.settings,
                name: &participant.name,
                federate,
                rti,
                passed_on: &passed_on,
                is_image: participant.artifact != Artifact::Host,
                folder: &participant.folder,
                package: &participant.package,
            };
            let bodies: Box<dyn host::Bodies + '_> = match language {
                Language::Rust => Box::new(rust::RustBodies::new(&job)),
                Language::C => Box::new(c::CBodies::new(&job)),
            };
            host::emit(&job, &*bodies, &mut self.emitted.files, &mut self.emitted.source_map)
        });
        if let Err(error) = result
            && !self.errors.contains(&error)
        {
            self.errors.push(error);
        }
        participant
    }
}
