// SPDX-License-Identifier: Apache-2.0
//! Whole crates: root module, entry point, and the modules of the federate and of the RTI.

use proc_macro2::TokenStream;
use quote::quote;

use super::bodies::{Bodies, NativeParts, Output};
use super::identifiers::ident;
use super::manifest;
use super::splice::Splices;
use super::{federate, rti};
use crate::emit::{EmitError, File, FileMap, Job, Lines, Piece, SourceMap};
use crate::plan::{Cargo, Dependency, Federate, Plan};

/// Adds the files of a participant's crate, and their source map.
///
/// # Errors
/// The first element that cannot be emitted.
pub(in crate::emit) fn emit(
    job: &Job<'_>,
    bodies: &dyn Bodies,
    files: &mut Vec<File>,
    map: &mut SourceMap,
) -> Result<(), EmitError> {
    let (plan, folder, deployment) = (job.plan(), job.folder, job.settings.deployment);
    let build_files = bodies.build_files()?;
    let mut generated = vec![root(job, bodies)?];
    if let Some(federate) = job.federate {
        generated.push(federate::emit(job, federate, bodies, format!("{folder}/src/federate.rs"))?);
    }
    if let Some(deployed) = deployment.rti_of(plan).filter(|_| job.rti) {
        generated.push(rti::emit(job, bodies.payload_lengths()?, &deployed, format!("{folder}/src/rti.rs"))?);
    }
    let mut output = Output::default();
    bodies.emit(&mut output)?;
    generated.extend(output.mapped);
    if let Some(federate) = job.federate.filter(|_| !job.is_image) {
        generated.insert(1, main(job, federate, &generated, &bodies.parameters())?);
    }
    files.push(File { path: format!("{folder}/Cargo.toml"), text: manifest::of_crate(job, bodies) });
    files.extend(build_files);
    files.extend(output.files);
    for (file, file_map) in generated {
        map.insert(file.path.clone(), file_map);
        files.push(file);
    }
    Ok(())
}

/// Emits `lib.rs`: attributes and modules, perhaps one with the declarations of C headers or one with the sizes of C
/// types.
fn root(job: &Job<'_>, bodies: &dyn Bodies) -> Result<(File, FileMap), EmitError> {
    let (native, modules) = (bodies.native_parts(), bodies.modules());
    let about = format!(" `{}` of the Lingua Franca program {}.", job.name, job.plan().name);
    let no_std = (job.is_image).then(|| quote!(#![no_std]));
    let sizes = (native == NativeParts::Bodies).then(|| {
        quote!(
            mod sizes {
                include!(concat!(env!("OUT_DIR"), "/sizes.rs"));
            }
        )
    });
    let bindings = (native == NativeParts::Headers).then(|| {
        quote!(
            #[doc = " The declarations in the program's C headers."]
            #[allow(warnings, reason = "bindgen writes it")]
            pub mod c {
                include!(concat!(env!("OUT_DIR"), "/c.rs"));
            }
        )
    });
    let crates = crates(&job.view.cargo, &modules);
    let modules = modules.into_iter().map(|module| {
        let module = ident(module);
        quote!(pub mod #module;)
    });
    let reactors = bodies.reactor_modules();
    let reactors = (!reactors.is_empty()).then(|| {
        let paths = reactors.iter().filter_map(|path| path.parse::<TokenStream>().ok());
        quote!(
            #[doc = " The modules of the reactors, at the paths that LF's own compiler gives them."]
            pub mod reactors { #(pub use crate::#paths;)* }
        )
    });
    // They stay where they are, so that all messages about them name the user's own files.
    let included = job.view.cargo.modules.iter().map(|included| {
        let (path, module) = (job.settings.absolute(&included.path), ident(&included.name));
        quote!(#[path = #path] pub mod #module;)
    });
    let federate = job.federate.map(|_| {
        quote!(
            pub mod federate;
        )
    });
    let rti = job.rti.then(|| {
        quote!(
            pub mod rti;
        )
    });
    let entry = (job.is_image).then(|| zephyr_entry(job));
    let tokens = quote! {
        #![doc = #about]
        #no_std
        #![allow(
            nonstandard_style, dead_code, private_interfaces, unused_imports, unused_macros, unused_parens,
            unused_braces, clippy::all, clippy::pedantic,
            reason = "names are the program's own, and a federate uses a part of what its files declare"
        )]
        #crates
        #federate
        #rti
        #(#modules)*
        #(#included)*
        #reactors
        #sizes
        #bindings
        #entry
    };
    Splices::new(job.plan()).finish(format!("{}/src/lib.rs", job.folder), tokens)
}

/// Emits the crates that the program asks for. LF's own compiler has them at the root, too: as `crate::rug`.
fn crates(cargo: &Cargo, modules: &[&str]) -> TokenStream {
    let Cargo { dependencies, modules: included, features, .. } = cargo;
    let is_free = |name: &str| {
        !["federate", "rti", "reactors", "sizes", "c"].contains(&name)
            && !modules.contains(&name)
            && included.iter().all(|module| module.name != name)
    };
    let is_used = |one: &&Dependency| {
        let feature = |feature: &String| feature.split('/').next() == Some(&one.name);
        !one.optional || features.iter().any(feature)
    };
    let names = dependencies.iter().filter(is_used).map(|one| one.name.replace('-', "_"));
    let names = names.filter(|name| is_free(name)).map(|name| ident(&name));
    quote!(#(extern crate #names;)*)
}

/// Emits `main.rs` of a program for this computer, with the places of its lines in the LF program, and the parameters
/// that a command line can set.
fn main(
    job: &Job<'_>,
    federate: &Federate,
    generated: &[(File, FileMap)],
    parameters: &TokenStream,
) -> Result<(File, FileMap), EmitError> {
    let about = format!(" Runs `{}` on this computer.", job.name);
    let library = ident(&job.package.replace('-', "_"));
    let owner = federate::type_name(job.plan(), federate);
    let rows = generated.iter().flat_map(|(file, map)| map.lines().into_iter().map(|lines| (&file.path, lines)));
    let rows: String = rows.filter_map(|(path, lines)| lines_row(job.plan(), path, &lines)).collect();
    let mut splices = Splices::new(job.plan());
    let lines = splices.text(format!(
        "/// The map from lines of generated code to places in the program, for panics.\n\
         const LINES: &[Lines] = &[\n{rows}];\n"
    ));
    let tokens = quote! {
        #![doc = #about]
        use lf::Lines;
        use #library::federate::{DESCRIPTION, #owner, Storage};
        #lines
        const PARAMETERS: lf::Parameters = #parameters;
        fn main() -> std::process::ExitCode {
            lf::name_lf_lines(LINES);
            lf::main::<_, Storage>(PARAMETERS, &DESCRIPTION, #owner::new)
        }
    };
    splices.finish(format!("{}/src/main.rs", job.folder), tokens)
}

fn lines_row(plan: &Plan, path: &str, lines: &Lines) -> Option<String> {
    let Lines { first: Piece { line, column, to, .. }, count } = lines;
    let (lf, lf_line, lf_column) = (&plan.files.get(to.file)?.path, to.line, to.column);
    Some(format!(
        "    Lines {{ file: {path:?}, line: {line}, column: {column}, count: {count}, lf: {lf:?}, lf_line: {lf_line}, \
         lf_column: {lf_column} }},\n"
    ))
}

/// Emits the functions that a Zephyr image calls.
fn zephyr_entry(job: &Job<'_>) -> TokenStream {
    let program = job.federate.map(|federate| {
        let owner = federate::type_name(job.plan(), federate);
        quote!(lf::main!(federate::#owner);)
    });
    let rti = job.rti.then(|| quote!(lf::rti!(rti::RTI);));
    quote!(#program #rti)
}
