// SPDX-License-Identifier: Apache-2.0
//! A participant's crate: tables, queues and entry point in Rust, and a folder with all that is C.

use super::sizes::Sizes;
use super::symbols::{Symbols, preamble_headers};
use super::{class, counterparts, external, header, parameters, program};
use crate::emit::{EmitError, File, Job, SourceMap};
use crate::languages::rust::crates::{main, root};
use crate::languages::rust::federate::{self, Bodies};
use crate::languages::rust::{manifest, rti};
use crate::plan::{FileIndex, Location, Logging, Plan};

/// Adds a crate's files.
///
/// # Errors
/// The first thing of which no C can be made.
pub(in crate::languages) fn emit(job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError> {
    let (plan, folder, deployment) = (job.plan, job.folder, job.settings.deployment);
    let sizes = Sizes::new(plan, job.federate, job.rti);
    files.push(File { path: format!("{folder}/Cargo.toml"), text: manifest::of_crate(job, manifest::Bodies::C) });
    build_script(job, files)?;
    for (index, header) in preamble_headers(plan).iter().enumerate() {
        files.push(class::preamble_header(plan, index, header, folder));
    }
    files.push(sizes.file(folder));
    let mut generated = vec![root(job, None)?];
    if let Some(federate) = job.federate {
        let symbols = Symbols::new(plan, federate);
        external::check(&symbols)?;
        for (class, _) in symbols.classes() {
            files.push(class::emit(&symbols, class, folder)?);
        }
        files.extend(header::emit(plan, folder));
        files.push(program::emit(&symbols, folder));
        files.extend(counterparts::emit(plan, federate, folder));
        let path = format!("{folder}/src/federate.rs");
        generated.push(federate::emit(
            plan,
            federate,
            Bodies::C { sizes: &sizes, is_image: job.is_image },
            deployment,
            path,
        )?);
        if !job.is_image {
            generated.push(main(job, federate, &[], parameters::of_main(plan))?);
        }
    }
    if let Some(deployed) = deployment.rti_of(plan).filter(|_| job.rti) {
        generated.push(rti::emit_with(job, sizes.all(), &deployed, format!("{folder}/src/rti.rs"))?);
    }
    for (file, file_map) in generated {
        map.insert(file.path.clone(), file_map);
        files.push(file);
    }
    Ok(())
}

/// The file by which the programs for this computer are built together.
pub(in crate::languages) fn workspace(plan: &Plan, folders: &[String]) -> File {
    manifest::of_workspace(plan, folders)
}

/// How the C of a program is compiled.
#[derive(Default)]
struct Compilation {
    folders: Vec<String>,
    flags: Vec<String>,
    sources: Vec<String>,
    libraries: Vec<String>,
}

impl Compilation {
    fn new(job: &Job<'_>) -> Self {
        let (plan, native, mut all) = (job.plan, &job.plan.target.c, Self::default());
        // Headers lie beside the program, or where `files` are, each of which code calls by its own name.
        let beside = [plan.files.first().map_or("", |file| file.path.as_str())].into_iter();
        for path in
            beside.chain(native.files.iter().filter(|file| concerns(job, file.at)).map(|file| file.path.as_str()))
        {
            let folder = path.trim_end_matches('/').rsplit_once('/').map(|(folder, _)| job.settings.absolute(folder));
            let folder = folder.unwrap_or_else(|| job.settings.current.to_owned());
            if !all.folders.contains(&folder) {
                all.folders.push(folder);
            }
        }
        let source = all.folders[0].clone();
        let package = source.strip_suffix("/src").or_else(|| source.split_once("/src/").map(|(package, _)| package));
        for (name, folder) in [("SOURCE", source.as_str()), ("PACKAGE", package.unwrap_or(&source))] {
            all.flags.push(format!("-DLF_{name}_DIRECTORY={folder:?}"));
        }
        // As many threads run reactions as in images.
        all.flags.push("-DNUMBER_OF_WORKERS=1".to_owned());
        all.flags.extend(logging(job));
        all.flags.extend(
            native
                .definitions
                .iter()
                .filter(|one| concerns(job, one.at))
                .map(|one| format!("-D{}={}", one.name, one.value)),
        );
        all.flags.extend(native.flags.iter().cloned());
        all
    }

    /// Adds what files for CMake say, for a program that is built without it.
    fn add_cmake(&mut self, job: &Job<'_>) -> Result<(), EmitError> {
        for cmake in job.plan.target.c.cmake.iter().filter(|cmake| concerns(job, cmake.at)) {
            if let Some(unread) = &cmake.unread {
                let message =
                    format!("`{unread}` in {} is understood by CMake only, and so on boards only", cmake.path);
                return Err(EmitError::new(job.plan, cmake.at, message));
            }
            self.folders.extend(cmake.folders.iter().map(|folder| job.settings.absolute(folder)));
            self.sources.extend(cmake.sources.iter().map(|source| job.settings.absolute(source)));
            self.flags.extend(cmake.definitions.iter().map(|definition| format!("-D{definition}")));
            self.flags.extend(cmake.options.iter().cloned());
            self.libraries.extend(cmake.libraries.iter().cloned());
        }
        Ok(())
    }
}

/// How much `lf_print` and its kin print, where the program says it: LF's numbers of levels, in LF's macro. In images
/// that name is one of Zephyr's own macros.
fn logging(job: &Job<'_>) -> Option<String> {
    let name = if job.is_image { "LF_LOG_LEVEL" } else { "LOG_LEVEL" };
    let level = match job.plan.target.logging {
        Logging::Error => 0,
        Logging::Warn => 1,
        // The default of the header.
        Logging::Info => return None,
        Logging::Log => 3,
        Logging::Debug => 4,
    };
    let is_defined = job.plan.target.c.definitions.iter().any(|one| one.name == name);
    (!is_defined).then(|| format!("-D{name}={level}"))
}

/// Whether a participant is meant by what a file says: the main one, or one of which it has reactors.
fn concerns(job: &Job<'_>, at: Location) -> bool {
    let classes = job.federate.iter().flat_map(|federate| &federate.instances);
    let mut classes = classes.map(|instance| &job.plan.classes[instance.class.0]);
    at.file == FileIndex(0) || classes.any(|class| class.at.file == at.file || class.files.contains(&at.file))
}

/// What has the C compiled, and its sizes measured. Zephyr's build compiles C itself, and asks for the sizes only.
fn build_script(job: &Job<'_>, files: &mut Vec<File>) -> Result<(), EmitError> {
    let (mut all, folder, mut calls) = (Compilation::new(job), job.folder, String::new());
    if job.is_image {
        files.push(File { path: format!("{folder}/c/program.cmake"), text: cmake(job, &all) });
    } else {
        all.add_cmake(job)?;
        if header::are_needed(job.plan) {
            all.folders.extend(header::FOLDERS.map(str::to_owned));
        }
        let lists =
            [("include", all.folders), ("flag", all.flags), ("source", all.sources), ("library", all.libraries)];
        for (method, argument) in lists.iter().flat_map(|(method, list)| list.iter().map(move |one| (method, one))) {
            calls = format!("{calls}        .{method}({argument:?})\n");
        }
    }
    let text = format!(
        "// Generated by lfz; do not edit.\n//! Has the C compiled.\n\nfn main() {{\n    lf_c_build::program()\n\
         {calls}        .build();\n}}\n"
    );
    files.push(File { path: format!("{folder}/build.rs"), text });
    Ok(())
}

/// What Zephyr's build does for the program, beside compiling the files of this folder.
fn cmake(job: &Job<'_>, all: &Compilation) -> String {
    let mut text = String::from("# Generated by lfz; do not edit.\nset(LF_MAIN_TARGET app)\n");
    let mut add = |command: &str, list: &[String]| {
        for one in list {
            text = format!("{text}{command}(app PRIVATE [=[{one}]=])\n");
        }
    };
    add("target_include_directories", &all.folders);
    add("target_compile_options", &all.flags);
    if header::are_needed(job.plan) {
        for folder in header::FOLDERS {
            text = format!("{text}target_include_directories(app PRIVATE ${{CMAKE_CURRENT_LIST_DIR}}/../{folder})\n");
        }
    }
    // A program names its files by paths from its own folders, which CMake looks for in that of the application.
    let mut places = all.folders.clone();
    for cmake in job.plan.target.c.cmake.iter().filter(|cmake| concerns(job, cmake.at)) {
        let path = job.settings.absolute(&cmake.path);
        text = format!("{text}include([=[{path}]=])\n");
        places.extend(path.rsplit_once('/').map(|(folder, _)| folder.to_owned()));
    }
    if !job.plan.target.c.cmake.is_empty() {
        text = format!("{text}lf_find_program_files(app [=[{}]=])\n", places.join("]=] [=["));
    }
    text
}
