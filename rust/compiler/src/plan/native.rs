// SPDX-License-Identifier: Apache-2.0
//! The settings of a program for its C code: its files, and their compilation.

use serde::{Deserialize, Serialize};

use super::source::Location;

/// The target properties for the C compiler. Those of an imported file apply to the federates that have reactors of
/// that file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NativeCode {
    /// Whether bodies are compiled as C++: the target is `CCpp`.
    pub is_cpp: bool,
    /// Whether bodies use the API of micro LF: the target is `uC`.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub is_micro: bool,
    /// `files`, in order.
    pub files: Vec<IncludedFile>,
    /// `c-sources`, in order: files of C beside bodies in another language.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<IncludedFile>,
    /// `c-headers`, in order: their declarations are bound for such bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub headers: Vec<IncludedFile>,
    /// `c-include-directories`, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub folders: Vec<IncludedFile>,
    /// `cmake-include`, in order.
    pub cmake: Vec<IncludedFile>,
    /// `protobufs`, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub protobufs: Vec<IncludedFile>,
    /// `compile-definitions`.
    pub definitions: Vec<Definition>,
    /// `compiler`, if given.
    pub compiler: Option<String>,
    /// `compiler-flags`, in order.
    pub flags: Vec<CompilerFlag>,
    /// `keepalive`, if given; without it, a program with physical actions stays alive.
    pub keepalive: Option<bool>,
    /// `no-source-mapping`: messages of the compiler name generated files.
    pub no_lines: bool,
}

impl NativeCode {
    /// Returns whether the program has no such settings.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the settings at these places, and those that apply to all code.
    pub(crate) fn of(mut self, is_kept: impl Fn(Location) -> bool) -> Self {
        let Self { files, sources, headers, folders, cmake, protobufs, .. } = &mut self;
        for files in [files, sources, headers, folders, cmake, protobufs] {
            files.retain(|file| is_kept(file.at));
        }
        self.definitions.retain(|definition| is_kept(definition.at));
        self.flags.retain(|flag| is_kept(flag.at));
        self
    }
}

/// A file or a folder of the program. Code can include those of `files` by their own names, because it sees them in the
/// folder of generated files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IncludedFile {
    /// The path: absolute, or relative to the base of LF files' paths.
    pub path: String,
    /// The place that names it.
    pub at: Location,
}

/// The files of LF's library for C that the runtime has, too.
const LIBRARY: [&str; 17] = [
    "audio_loop.cmake",
    "audio_loop.h",
    "deque.c",
    "deque.cmake",
    "deque.h",
    "initialize_from_file.c",
    "initialize_from_file.cmake",
    "initialize_from_file.h",
    "sensor_simulator.c",
    "sensor_simulator.cmake",
    "sensor_simulator.h",
    "vector.c",
    "vector.cmake",
    "vector.h",
    "wave_file_reader.c",
    "wave_file_reader.cmake",
    "wave_file_reader.h",
];

/// Returns the path by which LF's compiler names a file of its library, behind that of the library.
pub(crate) fn in_library(path: &str) -> Option<&str> {
    path.strip_prefix("/lib/c/reactor-c/")
}

/// Returns the name of a file of LF's library that the runtime has, too.
pub(crate) fn library_file(path: &str) -> Option<&'static str> {
    let name = in_library(path)?.rsplit('/').next()?;
    LIBRARY.into_iter().find(|file| *file == name)
}

/// A macro.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// Its replacement.
    pub value: String,
    /// The place of its definition.
    pub at: Location,
}

/// A word for the C compiler, which passes some on to the linker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompilerFlag {
    /// The word; a relative path in it begins in the folder of the file that contains it.
    pub text: String,
    /// The place of the word.
    pub at: Location,
}
