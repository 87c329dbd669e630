// SPDX-License-Identifier: Apache-2.0
//! What a program says about its code in C: which files take part, and how they are compiled.

use serde::{Deserialize, Serialize};

use super::source::Location;

/// The target properties that are about the compiler of C. Where an imported file says it, it is for the federates
/// that have reactors of that file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NativeCode {
    /// Whether bodies are compiled as C++: the target is `CCpp`.
    pub is_cpp: bool,
    /// `files`, in order.
    pub files: Vec<IncludedFile>,
    /// `c-sources`, in order: files of C beside bodies in another language.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<IncludedFile>,
    /// `c-headers`, in order: what these declare is bound for such bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub headers: Vec<IncludedFile>,
    /// `c-include-directories`, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub folders: Vec<IncludedFile>,
    /// `cmake-include`, in order.
    pub cmake: Vec<CmakeFile>,
    /// `compile-definitions`.
    pub definitions: Vec<Definition>,
    /// `compiler`, if given.
    pub compiler: Option<String>,
    /// `compiler-flags`, in order.
    pub flags: Vec<CompilerFlag>,
    /// `keepalive`, if given; without it, a program with physical actions stays.
    pub keepalive: Option<bool>,
    /// `no-source-mapping`: what the compiler says is about generated files.
    pub no_lines: bool,
}

impl NativeCode {
    /// Whether the program says nothing about it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns what is said at these places, and what is said about all code.
    pub(crate) fn of(mut self, is_kept: impl Fn(Location) -> bool) -> Self {
        for files in [&mut self.files, &mut self.sources, &mut self.headers, &mut self.folders] {
            files.retain(|file| is_kept(file.at));
        }
        self.cmake.retain(|file| is_kept(file.at));
        self.definitions.retain(|definition| is_kept(definition.at));
        self.flags.retain(|flag| is_kept(flag.at));
        self
    }
}

/// A file or a folder that takes part. Those of `files` code can include by their own names: they are in the folder of
/// generated files, as far as code sees it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IncludedFile {
    /// Absolute, or relative to where paths of LF files are.
    pub path: String,
    /// Where it is named.
    pub at: Location,
}

/// A macro.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// What it stands for.
    pub value: String,
    /// Where it is defined.
    pub at: Location,
}

/// A word for the compiler of C, which hands some of them on to the linker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompilerFlag {
    /// The word; a path in it that is relative begins in the folder of the file that has it.
    pub text: String,
    /// Where it is written.
    pub at: Location,
}

/// A file for CMake, with what it says of which CMake is not needed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CmakeFile {
    /// Absolute, or relative to where paths of LF files are.
    pub path: String,
    /// Further files of C, found where code sees them.
    pub sources: Vec<String>,
    /// Folders in which headers are looked for.
    pub folders: Vec<String>,
    /// Macros: `NAME` or `NAME=value`.
    pub definitions: Vec<String>,
    /// Further arguments of the compiler.
    pub options: Vec<String>,
    /// Libraries by their names: `m`.
    pub libraries: Vec<String>,
    /// The first thing in it that only CMake understands. An image has CMake, and a program for this computer has not.
    pub unread: Option<String>,
    /// Where it is named.
    pub at: Location,
}
