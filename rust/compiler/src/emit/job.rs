// SPDX-License-Identifier: Apache-2.0
//! The input of emission.

use crate::deployment::Deployment;
use crate::plan::{Federate, Plan, library_file};

use super::view::View;

/// The caller's settings for the generated crates.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The folder of the runtime's crates, absolute or relative to a generated crate.
    pub crates: &'a str,
    /// The version of all packages. Cargo distinguishes packages of one name by it, so two programs whose crates share
    /// cargo's intermediate results must have different versions.
    pub version: &'a str,
    /// The base of the program's relative paths: the folder in which the compiler runs.
    pub current: &'a str,
    /// The places of the federates.
    pub deployment: &'a Deployment,
    /// The folder with a folder of keys for each participant, absolute.
    pub keys: &'a str,
}

impl Settings<'_> {
    /// Returns the folder of a crate of the runtime, such as `linux`.
    pub(crate) fn crate_folder(&self, name: &str) -> String {
        format!("{}/{name}", self.crates)
    }

    /// Returns a path of the program that is valid from any generated crate.
    pub(crate) fn absolute(&self, path: &str) -> String {
        if let Some(name) = library_file(path) {
            return format!("{}/lib/{name}", self.crate_folder("c"));
        }
        if path.starts_with('/') { path.to_owned() } else { format!("{}/{path}", self.current) }
    }
}

/// The program of one participant to emit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job<'a> {
    /// The plan as its language sees it.
    pub(crate) view: &'a View<'a>,
    pub(crate) settings: &'a Settings<'a>,
    /// The participant.
    pub(crate) name: &'a str,
    /// The federate, unless it is an RTI and nothing else.
    pub(crate) federate: Option<&'a Federate>,
    /// Whether it contains the RTI.
    pub(crate) rti: bool,
    /// The lengths of the values that this RTI forwards between federates in other languages.
    pub(crate) passed_on: &'a [u64],
    /// Whether it is a static library for a Zephyr image, and not a program for this computer.
    pub(crate) is_image: bool,
    /// The folder below the output folder.
    pub(crate) folder: &'a str,
    /// The package; also the name of a program for this computer.
    pub(crate) package: &'a str,
}

impl<'a> Job<'a> {
    /// Returns the whole plan.
    pub(crate) fn plan(&self) -> &'a Plan {
        self.view.plan
    }

    /// Returns the number of threads that run reactions. Images have one.
    pub(crate) fn workers(&self) -> u16 {
        if self.is_image { 1 } else { self.plan().target.workers }
    }
}
