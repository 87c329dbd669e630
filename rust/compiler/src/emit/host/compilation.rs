// SPDX-License-Identifier: Apache-2.0
//! The compilation of a participant's C code: that of its bodies, or that beside bodies in another language.

use crate::emit::Job;
use crate::plan::{FileIndex, IncludedFile, Location, Logging, library_file};

/// The arguments of C compilers.
#[derive(Clone, Default)]
pub(in crate::emit) struct CompilerArguments<'p> {
    /// The include folders.
    pub(in crate::emit) folders: Vec<String>,
    /// Arguments of the compiler.
    pub(in crate::emit) flags: Vec<String>,
    /// Files to compile.
    pub(in crate::emit) sources: Vec<String>,
    /// Headers to bind.
    pub(in crate::emit) headers: Vec<String>,
    /// The place that names the first of these, for errors that are about none of them.
    pub(in crate::emit) place: Option<String>,
    /// Arguments of the linker, as the compiler accepts them.
    pub(in crate::emit) linked: Vec<String>,
    /// Libraries that have to precede all others.
    pub(in crate::emit) first_libraries: Vec<String>,
    /// Libraries to link: names, paths, or arguments of the linker.
    pub(in crate::emit) libraries: Vec<String>,
    /// Files with messages of Protocol Buffers.
    pub(in crate::emit) protobufs: Vec<String>,
    /// The program's own files for CMake.
    pub(in crate::emit) cmake: Vec<&'p IncludedFile>,
}

impl<'p> CompilerArguments<'p> {
    /// Returns the arguments for bodies in C.
    pub(in crate::emit) fn of_bodies(job: &Job<'p>) -> Self {
        let (plan, native, mut all) = (job.plan(), &job.view.native, Self::default());
        // Headers lie beside the program, or at the paths of `files`, which code includes by their own names.
        all.add_folder_around(job, plan.files.first().map_or("", |file| &file.path));
        for file in native.files.iter().filter(|file| concerns(job, file.at)) {
            all.add_folder_around(job, &file.path);
        }
        let source = all.folders[0].clone();
        let package = source.strip_suffix("/src").or_else(|| source.split_once("/src/").map(|(package, _)| package));
        for (name, folder) in [("SOURCE", source.as_str()), ("PACKAGE", package.unwrap_or(&source))] {
            all.flags.push(format!("-DLF_{name}_DIRECTORY={folder:?}"));
        }
        let mut own = native.files.iter().filter(|file| concerns(job, file.at) && library_file(&file.path).is_none());
        let first = own.next().map(|file| job.settings.absolute(file.path.trim_end_matches('/')));
        let around = first.as_ref().and_then(|first| first.rsplit_once('/')).map_or(&*source, |(folder, _)| folder);
        all.flags.push(format!("-DLF_TARGET_FILES_DIRECTORY={around:?}"));
        all.flags.push(format!("-DPLATFORM_{}", if job.is_image { "ZEPHYR" } else { "Linux" }));
        let federate = job.federate.filter(|_| plan.is_federated());
        all.flags.extend(federate.map(|federate| format!("-DLF_FEDERATE_ID_={}", federate.id)));
        all.flags.push(format!("-DNUMBER_OF_WORKERS={}", job.workers()));
        all.flags.extend(logging(job));
        all.flags.extend(native.is_micro.then(|| "-DLF_MICRO".to_owned()));
        all.add_definitions(job, |at| concerns(job, at));
        for flag in native.flags.iter().filter(|flag| concerns(job, flag.at)) {
            all.add_words(job, [flag.text.as_str()], job.plan().path(flag.at));
        }
        all.cmake.extend(native.cmake.iter().filter(|cmake| concerns(job, cmake.at)));
        all.protobufs.extend(native.protobufs.iter().map(|file| job.settings.absolute(&file.path)));
        all
    }

    /// Adds the folder of a file of the program.
    pub(in crate::emit) fn add_folder_around(&mut self, job: &Job<'_>, path: &str) {
        let path = job.settings.absolute(path.trim_end_matches('/'));
        let folder = path.rsplit_once('/').map_or(job.settings.current, |(folder, _)| folder);
        self.add_folder(folder.to_owned());
    }

    pub(in crate::emit) fn add_folder(&mut self, folder: String) {
        if !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
    }

    /// Adds the program's macros at certain places.
    pub(in crate::emit) fn add_definitions(&mut self, job: &Job<'_>, counts: impl Fn(Location) -> bool) {
        let definitions = job.view.native.definitions.iter().filter(|one| counts(one.at));
        self.flags.extend(definitions.map(|one| format!("-D{}={}", one.name, one.value)));
    }

    /// Returns the files for CMake, and the folders in which the files that they name lie: a program names them by
    /// paths from its own folders, which CMake would search in that of the project.
    fn cmake_files(&self, job: &Job<'_>) -> (Vec<String>, Vec<String>) {
        let files: Vec<String> = self.cmake.iter().map(|file| job.settings.absolute(&file.path)).collect();
        if files.is_empty() {
            return (files, Vec::new());
        }
        let around = files.iter().filter_map(|file| file.rsplit_once('/')).map(|(folder, _)| folder.to_owned());
        let mut places: Vec<String> = Vec::new();
        for place in self.folders.iter().cloned().chain(around) {
            if !places.contains(&place) {
                places.push(place);
            }
        }
        (files, places)
    }

    /// Returns the build script of a crate, which calls `lf-c-build` from this function on.
    pub(in crate::emit) fn build_script(self, job: &Job<'_>, begin: &str) -> String {
        let (cmake_files, cmake_places) = self.cmake_files(job);
        let lists = [
            ("include", self.folders),
            ("flag", self.flags),
            ("source", self.sources),
            ("protobuf", self.protobufs),
            ("header", self.headers),
            ("named_at", Vec::from_iter(self.place)),
            ("link_argument", self.linked),
            ("first_library", self.first_libraries),
            ("library", self.libraries),
            ("cmake_file", cmake_files),
            ("cmake_place", cmake_places),
        ];
        let mut calls = String::new();
        for (method, argument) in lists.iter().flat_map(|(method, list)| list.iter().map(move |one| (method, one))) {
            calls = format!("{calls}        .{method}({argument:?})\n");
        }
        format!(
            "// Generated by lfz; do not edit.\n//! Compiles the C code.\n\nfn main() {{\n    lf_c_build::{begin}()\n\
             {calls}        .build();\n}}\n"
        )
    }

    /// Returns the arguments by which tools such as clangd read the C of a crate: the lines of `compile_flags.txt`.
    /// Headers that a build script makes are missing.
    pub(in crate::emit) fn compile_flags(&self, job: &Job<'_>) -> String {
        let runtime = job.settings.crate_folder("c");
        let own = [format!("{runtime}/include"), runtime, "c".to_owned()];
        let includes = own.iter().chain(&self.folders).map(|folder| format!("-I{folder}\n"));
        let package = "-DLF_FED_PACKAGE_DIRECTORY=\"\"\n".to_owned();
        includes.chain(self.flags.iter().map(|flag| format!("{flag}\n"))).chain([package]).collect()
    }

    /// Returns the commands by which Zephyr's build includes the program, apart from compiling the files of a folder;
    /// `own` are folders of headers in CMake's notation.
    pub(in crate::emit) fn cmake(&self, job: &Job<'_>, own: impl Iterator<Item = String>) -> String {
        let mut text = String::from("# Generated by lfz; do not edit.\nset(LF_MAIN_TARGET app)\n");
        let mut add = |command: &str, list: &[String]| {
            for one in list {
                text = format!("{text}{command}(app PRIVATE [=[{one}]=])\n");
            }
        };
        add("target_include_directories", &self.folders);
        add("target_compile_options", &self.flags);
        add("target_sources", &self.sources);
        add("target_link_libraries", &self.linked);
        for folder in own {
            text = format!("{text}target_include_directories(app PRIVATE {folder})\n");
        }
        let (files, places) = self.cmake_files(job);
        for file in &files {
            text = format!("{text}include([=[{file}]=])\n");
        }
        if !files.is_empty() {
            text = format!("{text}lf_find_program_files(app [=[{}]=])\n", places.join("]=] [=["));
        }
        text
    }
}

/// Returns whether the content of a file concerns a participant: the main file does, and files of its reactors.
pub(in crate::emit) fn concerns(job: &Job<'_>, at: Location) -> bool {
    let classes = job.federate.iter().flat_map(|federate| &federate.instances);
    let mut classes = classes.map(|instance| job.view.class(instance.class));
    at.file == FileIndex(0) || classes.any(|class| class.at.file == at.file || class.files.contains(&at.file))
}

/// Returns the level of `lf_print` and its variants, if the program sets it: LF's numbers of levels, in LF's macro. In
/// images the name belongs to one of Zephyr's own macros.
fn logging(job: &Job<'_>) -> Option<String> {
    let name = if job.is_image { "LF_LOG_LEVEL" } else { "LOG_LEVEL" };
    let level = match job.plan().target.logging {
        Logging::Error => 0,
        Logging::Warn => 1,
        // This is the default of the header.
        Logging::Info => return None,
        Logging::Log => 3,
        Logging::Debug => 4,
    };
    let is_defined = job.view.native.definitions.iter().any(|one| one.name == name);
    (!is_defined).then(|| format!("-D{name}={level}"))
}
