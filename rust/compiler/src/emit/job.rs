// SPDX-License-Identifier: Apache-2.0
//! What is to be emitted.

use crate::deployment::Deployment;
use crate::plan::{Federate, Plan};

use super::view::View;

/// What the caller decides about the generated crates.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The folder of the crate `lf-linux`, absolute or relative to a generated crate.
    pub lf_linux: &'a str,
    /// The folder of the crate `lf-zephyr`, absolute or relative to a generated crate.
    pub lf_zephyr: &'a str,
    /// The folder of the crate `lf-c-build`, absolute or relative to a generated crate.
    pub lf_c_build: &'a str,
    /// The version of all packages. Cargo tells packages of one name apart by it, so two programs whose crates share
    /// cargo's intermediate results must not have the same.
    pub version: &'a str,
    /// Where paths of the program begin, when they are relative: the folder in which the compiler runs.
    pub current: &'a str,
    /// Where the federates run.
    pub deployment: &'a Deployment,
}

impl Settings<'_> {
    /// A path of the program, from wherever a generated crate lies.
    pub(crate) fn absolute(&self, path: &str) -> String {
        if path.starts_with('/') { path.to_owned() } else { format!("{}/{path}", self.current) }
    }
}

/// The program of one participant, to be emitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job<'a> {
    /// The plan as its language sees it.
    pub(crate) view: &'a View<'a>,
    pub(crate) settings: &'a Settings<'a>,
    /// The participant.
    pub(crate) name: &'a str,
    /// The federate, unless it is an RTI and nothing else.
    pub(crate) federate: Option<&'a Federate>,
    /// Whether the RTI is in it.
    pub(crate) rti: bool,
    /// How long the values are that this RTI passes on between federates in other languages.
    pub(crate) passed_on: &'a [u64],
    /// Whether it is a static library for a Zephyr image, and not a program for this computer.
    pub(crate) is_image: bool,
    /// The folder below the output folder.
    pub(crate) folder: &'a str,
    /// The package; also the name of a program for this computer.
    pub(crate) package: &'a str,
}

impl<'a> Job<'a> {
    /// The plan as a whole.
    pub(crate) fn plan(&self) -> &'a Plan {
        self.view.plan
    }

    /// Returns how many threads run reactions. Images have one.
    pub(crate) fn workers(&self) -> u16 {
        let is_one = self.is_image || !self.view.language.facts().workers;
        if is_one { 1 } else { self.plan().target.workers }
    }
}
