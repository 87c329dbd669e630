// SPDX-License-Identifier: Apache-2.0
//! The settings of a program for its crates: their dependencies, the user's files that are part of them, and the
//! profile.

use serde::{Deserialize, Serialize};

use super::source::Location;

/// The target properties for cargo.
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
    /// Returns whether the program has no such settings.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A crate that bodies can use. At least one of version, path and git is given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dependency {
    /// Its name in bodies, with `-` as `_`.
    pub name: String,
    /// The package, if that has another name.
    pub package: Option<String>,
    /// The accepted versions, in cargo's notation.
    pub version: Option<String>,
    /// The folder of the crate: absolute, or relative to the base of LF files' paths.
    pub path: Option<String>,
    /// The URL of a git repository.
    pub git: Option<String>,
    /// A branch of the repository.
    pub branch: Option<String>,
    /// A tag of the repository.
    pub tag: Option<String>,
    /// A commit of the repository.
    pub rev: Option<String>,
    /// The features to enable.
    pub features: Vec<String>,
    /// Whether to enable its default features.
    pub default_features: bool,
    /// Whether it is used only if a feature asks for it.
    pub optional: bool,
    /// The place that names it.
    pub at: Location,
}

/// A file of Rust, or a folder with `mod.rs`, that generated crates have as a module at their root.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Module {
    /// The name of the module.
    pub name: String,
    /// The file: absolute, or relative to the base of LF files' paths.
    pub path: String,
    /// The place that names it.
    pub at: Location,
}

/// The profile of programs for this computer, as in LF.
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
    /// Optimized, with debug information.
    RelWithDebInfo,
    /// With optimizations for size.
    MinSizeRel,
}

impl BuildType {
    /// All profiles.
    pub const ALL: [Self; 5] = [Self::Release, Self::Debug, Self::Test, Self::RelWithDebInfo, Self::MinSizeRel];

    /// Returns the name in LF.
    pub fn name(self) -> &'static str {
        match self {
            Self::Debug => "Debug",
            Self::Test => "Test",
            Self::Release => "Release",
            Self::RelWithDebInfo => "RelWithDebInfo",
            Self::MinSizeRel => "MinSizeRel",
        }
    }

    /// Returns the name of cargo's profile.
    pub fn profile(self) -> &'static str {
        match self {
            Self::Debug => "dev",
            Self::Test => "test",
            Self::Release => "release",
            Self::RelWithDebInfo => "release-with-debug-info",
            Self::MinSizeRel => "release-of-least-size",
        }
    }

    /// Returns whether the compiler optimizes.
    pub fn is_optimized(self) -> bool {
        !matches!(self, Self::Debug | Self::Test)
    }
}
