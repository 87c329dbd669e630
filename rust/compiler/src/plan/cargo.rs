// SPDX-License-Identifier: Apache-2.0
//! What a program says about the crates that it becomes: what they depend on, which files of the user's are part of
//! them, and how they are compiled.

use serde::{Deserialize, Serialize};

use super::source::Location;

/// The target properties that are about cargo.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cargo {
    /// `cargo-dependencies`, in order.
    pub dependencies: Vec<Dependency>,
    /// `cargo-features` that generated crates have: `name` of an optional dependency, or `name/feature` of any.
    pub features: Vec<String>,
    /// `rust-include`, in order.
    pub modules: Vec<Module>,
    /// `edition`, if given.
    pub edition: Option<String>,
    /// `build-type`.
    pub build_type: BuildType,
}

impl Cargo {
    /// Whether the program says nothing about it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A crate that bodies can use. At least one of version, path and git is given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dependency {
    /// What bodies call it, with `-` as `_`.
    pub name: String,
    /// The package, if that has another name.
    pub package: Option<String>,
    /// Which versions will do, as cargo reads it.
    pub version: Option<String>,
    /// The folder of the crate: absolute, or relative to where paths of LF files are.
    pub path: Option<String>,
    /// The URL of a git repository.
    pub git: Option<String>,
    /// A branch of the repository.
    pub branch: Option<String>,
    /// A tag of the repository.
    pub tag: Option<String>,
    /// A commit of the repository.
    pub rev: Option<String>,
    /// Its features that are wanted.
    pub features: Vec<String>,
    /// Whether its default features are wanted.
    pub default_features: bool,
    /// Whether it is used only where a feature asks for it.
    pub optional: bool,
    /// Where it is named.
    pub at: Location,
}

/// A file of Rust, or a folder with `mod.rs`, that generated crates have as a module at their root.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Module {
    /// The name of the module.
    pub name: String,
    /// The file: absolute, or relative to where paths of LF files are.
    pub path: String,
    /// Where it is named.
    pub at: Location,
}

/// How programs for this computer are compiled, as in LF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BuildType {
    /// Without optimizations, with assertions.
    #[default]
    Debug,
    /// The same with cargo's profile for tests.
    Test,
    /// With optimizations.
    Release,
    /// The same with what debuggers need.
    RelWithDebInfo,
    /// With optimizations for size.
    MinSizeRel,
}

impl BuildType {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Release, Self::Debug, Self::Test, Self::RelWithDebInfo, Self::MinSizeRel];

    /// As it is written in LF.
    pub fn name(self) -> &'static str {
        match self {
            Self::Debug => "Debug",
            Self::Test => "Test",
            Self::Release => "Release",
            Self::RelWithDebInfo => "RelWithDebInfo",
            Self::MinSizeRel => "MinSizeRel",
        }
    }

    /// The name of cargo's profile.
    pub fn profile(self) -> &'static str {
        match self {
            Self::Debug => "dev",
            Self::Test => "test",
            Self::Release => "release",
            Self::RelWithDebInfo => "release-with-debug-info",
            Self::MinSizeRel => "release-of-least-size",
        }
    }

    /// Whether the compiler optimizes.
    pub fn is_optimized(self) -> bool {
        !matches!(self, Self::Debug | Self::Test)
    }
}
