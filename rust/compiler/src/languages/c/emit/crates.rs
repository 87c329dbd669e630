// SPDX-License-Identifier: Apache-2.0
//! A participant's crate: tables, queues and entry point in Rust, and a folder with all that is C.

use super::compilation::CompilerArguments;
use super::sizes::Sizes;
use super::symbols::{Symbols, preamble_headers};
use super::{class, counterparts, external, header, parameters, program};
use crate::emit::{EmitError, File, Job, SourceMap};
use crate::languages::rust::crates::{main, root};
use crate::languages::rust::federate::{self, Bodies};
use crate::languages::rust::manifest::{self, CParts};
use crate::languages::rust::rti;
use crate::plan::{FileIndex, Location, Plan};

/// Adds a crate's files.
///
/// # Errors
/// The first thing of which no C can be made.
pub(in crate::languages) fn emit(job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError> {
    let (plan, folder, deployment) = (job.plan, job.folder, job.settings.deployment);
    let sizes = Sizes::new(plan, job.federate, job.rti);
    files.push(File { path: format!("{folder}/Cargo.toml"), text: manifest::of_crate(job, CParts::Bodies, false) });
    build_script(job, files)?;
    for (index, header) in preamble_headers(plan).iter().enumerate() {
        files.push(class::preamble_header(plan, index, header, folder));
    }
    files.push(sizes.file(folder));
    let mut generated = vec![root(job, None, false)?];
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

/// What has the C compiled, and its sizes measured. Zephyr's build compiles C itself, and asks for the sizes only.
fn build_script(job: &Job<'_>, files: &mut Vec<File>) -> Result<(), EmitError> {
    let (mut all, folder) = (CompilerArguments::of_bodies(job), job.folder);
    let headers = if header::are_needed(job.plan) { &header::FOLDERS[..] } else { &[] };
    if job.is_image {
        if let Some(word) = all.needs_library() {
            let flag = job.plan.target.c.flags.iter().find(|flag| flag.text == word);
            let at = flag.map_or(Location { file: FileIndex(0), line: 1, column: 1 }, |flag| flag.at);
            let hint = "remove it; on native_sim, `CONFIG_ASAN=y` and `CONFIG_UBSAN=y` in prj.conf look for mistakes";
            let message = format!("`{word}` needs a library that images do not have: {hint}");
            return Err(EmitError::new(job.plan, at, message));
        }
        let own = headers.iter().map(|folder| format!("${{CMAKE_CURRENT_LIST_DIR}}/../{folder}"));
        files.push(File { path: format!("{folder}/c/program.cmake"), text: all.cmake(job, own) });
        all = CompilerArguments::default();
    } else {
        all.read_cmake(job)?;
        all.folders.extend(headers.iter().map(|folder| (*folder).to_owned()));
    }
    files.push(File { path: format!("{folder}/build.rs"), text: all.build_script("program") });
    Ok(())
}
