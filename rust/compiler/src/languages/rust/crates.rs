// SPDX-License-Identifier: Apache-2.0
//! Whole crates: root module, a module per LF file, entry point.

use proc_macro2::TokenStream;
use quote::quote;

use super::federate::Bodies;
use super::layout::Layout;
use super::manifest::{self, CParts};
use super::names::ident;
use super::rti::{self, Payloads};
use super::splice::Splices;
use super::{federate, reactor, sending};
use crate::emit::{EmitError, File, FileMap, Job, Lines, Piece, SourceMap};
use crate::languages::c::Beside;
use crate::plan::{Federate, FileIndex, Plan};

/// Adds a crate's files and their maps.
///
/// # Errors
/// The first thing of which no Rust can be made.
pub(super) fn emit(job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError> {
    let (plan, folder, deployment) = (job.plan, job.folder, job.settings.deployment);
    sending::check_heap(job)?;
    let payloads = job.rti.then(|| Payloads::new(plan, deployment));
    let types = payloads.as_ref().map(Payloads::classes).unwrap_or_default();
    let layout = Layout::new(plan, job.federate, &types, job.workers());
    let beside = Beside::new(job, |at| layout.has_file(at.file));
    let binds = beside.has_headers();
    let c = match beside.is_any() {
        true if binds => CParts::Headers,
        true if !job.is_image => CParts::Sources,
        _ => CParts::None,
    };
    beside.emit(job, files)?;
    let mut generated = vec![root(job, Some(&layout), binds)?];
    if let Some(federate) = job.federate {
        generated.push(federate::emit(
            plan,
            federate,
            Bodies::Rust(&layout),
            deployment,
            format!("{folder}/src/federate.rs"),
        )?);
    }
    if let (Some(payloads), Some(deployed)) = (&payloads, &deployment.rti_of(plan)) {
        generated.push(rti::emit(job, payloads, &layout, deployed, format!("{folder}/src/rti.rs"))?);
    }
    for (file, module) in layout.files() {
        let folder = format!("{folder}/src/{module}");
        generated.push(file_module(plan, &layout, file, binds, format!("{folder}/mod.rs"))?);
        for (class, class_module) in layout.classes_of(file) {
            generated.push(reactor::emit(plan, &layout, class, format!("{folder}/{class_module}.rs"))?);
        }
    }
    // Bodies reach devices by paths and a macro that have this word in them. What is in modules of the user's own,
    // nobody has read.
    let may_use_devices =
        !plan.target.cargo.modules.is_empty() || generated.iter().any(|(file, _)| file.text.contains("device"));
    if let Some(federate) = job.federate.filter(|_| !job.is_image) {
        generated.insert(1, main(job, federate, &generated, None)?);
    }
    files.push(File { path: format!("{folder}/Cargo.toml"), text: manifest::of_crate(job, c, may_use_devices) });
    for (file, file_map) in generated {
        map.insert(file.path.clone(), file_map);
        files.push(file);
    }
    Ok(())
}

/// `lib.rs`: attributes and modules, perhaps one with what headers of C declare; without a layout, the sizes of what is
/// C's.
pub(in crate::languages) fn root(
    job: &Job<'_>,
    layout: Option<&Layout<'_>>,
    binds: bool,
) -> Result<(File, FileMap), EmitError> {
    let about = format!(" `{}` of the Lingua Franca program {}.", job.name, job.plan.name);
    let no_std = (job.is_image).then(|| quote!(#![no_std]));
    let sizes = layout.is_none().then(|| {
        quote!(
            mod sizes {
                include!(concat!(env!("OUT_DIR"), "/sizes.rs"));
            }
        )
    });
    let bindings = binds.then(|| {
        quote!(
            #[doc = " What the program's headers of C declare."]
            #[allow(warnings, reason = "bindgen writes it")]
            pub mod c {
                include!(concat!(env!("OUT_DIR"), "/c.rs"));
            }
        )
    });
    let modules = layout.into_iter().flat_map(Layout::files).map(|(_, module)| {
        let module = ident(module);
        quote!(pub mod #module;)
    });
    // They stay where they are, so that whatever is said about them names the user's own files.
    let included = job.plan.target.cargo.modules.iter().map(|included| {
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
        #federate
        #rti
        #(#modules)*
        #(#included)*
        #sizes
        #bindings
        #entry
    };
    Splices::new(job.plan).finish(format!("{}/src/lib.rs", job.folder), tokens)
}

/// `main.rs` of a program for this computer, which knows where in the LF program its lines stand, and perhaps which
/// parameters a command line can set.
pub(in crate::languages) fn main(
    job: &Job<'_>,
    federate: &Federate,
    generated: &[(File, FileMap)],
    parameters: Option<TokenStream>,
) -> Result<(File, FileMap), EmitError> {
    let about = format!(" Runs `{}` on this computer.", job.name);
    let library = ident(&job.package.replace('-', "_"));
    let owner = federate::type_name(job.plan, federate);
    let rows = generated.iter().flat_map(|(file, map)| map.lines().into_iter().map(|lines| (&file.path, lines)));
    let rows: String = rows.filter_map(|(path, lines)| lines_row(job.plan, path, &lines)).collect();
    let mut splices = Splices::new(job.plan);
    let lines = splices.text(format!("/// Where panics are in the program.\nconst LINES: &[Lines] = &[\n{rows}];\n"));
    let call = if let Some(parameters) = parameters {
        quote!(lf::main_with(#parameters, &DESCRIPTION, #owner::new, Storage::new))
    } else {
        quote!(lf::main(&DESCRIPTION, #owner::new, Storage::new))
    };
    let tokens = quote! {
        #![doc = #about]
        use lf::Lines;
        use #library::federate::{DESCRIPTION, #owner, Storage};
        #lines
        fn main() -> std::process::ExitCode {
            lf::name_lf_lines(LINES);
            #call
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

/// What a Zephyr image calls.
fn zephyr_entry(job: &Job<'_>) -> TokenStream {
    let program = job.federate.map(|federate| {
        let owner = federate::type_name(job.plan, federate);
        quote!(lf::main!(federate::#owner);)
    });
    let rti = job.rti.then(|| quote!(lf::rti!(rti::RTI);));
    quote!(#program #rti)
}

/// The module of an LF file: its preambles, and the modules of its reactors.
fn file_module(
    plan: &Plan,
    layout: &Layout<'_>,
    file: FileIndex,
    binds: bool,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let source = &plan.files[file.0];
    let name = source.path.rsplit(['/', '\\']).next().unwrap_or(&source.path);
    let about = format!(" What {name} declares.");
    let mut splices = Splices::new(plan);
    let mut preambles = Vec::new();
    for preamble in &source.preambles {
        preambles.push(splices.items(preamble)?);
    }
    let modules = layout.classes_of(file).map(|(_, module)| {
        let module = ident(module);
        quote!(pub mod #module;)
    });
    let siblings = layout.siblings_of(plan, file).into_iter().map(|(folder, module)| {
        let (folder, module) = (ident(folder), ident(module));
        quote!(pub use crate::#folder::#module;)
    });
    let bindings = binds.then(|| {
        quote!(
            use crate::c;
        )
    });
    let tokens = quote! {
        #![doc = #about]
        #(#modules)*
        #(#siblings)*
        use ::lf::prelude::*;
        #bindings
        #(#preambles)*
    };
    splices.finish(path, tokens)
}
