// SPDX-License-Identifier: Apache-2.0
//! The host's access to bodies in Rust.

use core::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::TokenStream;
use quote::quote;

use super::layout::{Layout, REACTORS};
use super::payloads::Payloads;
use super::reactor::{bytes_constant, parsed_type, type_alias};
use super::{calls, file_module, reactor, sending};
use crate::emit::host::{Beside, Bodies, Members, NativeParts, Output, Owner, ReactionPart, Splices, serializer_type};
use crate::emit::{EmitError, File, Job};
use crate::languages::rust::is_copy;
use crate::plan::{ClassIndex, Port, Serializer, SourceCode, Type};
use crate::tables::HandedOverRow;

/// The words by which bodies access devices: a macro and a module.
const DEVICES: [&str; 2] = ["device", "devices"];

/// The bodies of a participant in Rust.
pub(in crate::emit) struct RustBodies<'p> {
    pub(super) job: &'p Job<'p>,
    pub(super) layout: Layout<'p>,
    /// The payloads that an RTI in the crate forwards.
    payloads: Payloads<'p>,
    beside: Beside<'p>,
    /// The classes that are named, whose modules are imported.
    named: RefCell<BTreeSet<ClassIndex>>,
}

impl<'p> RustBodies<'p> {
    pub(in crate::emit) fn new(job: &'p Job<'p>) -> Self {
        let payloads = if job.rti { Payloads::new(job) } else { Payloads::default() };
        let layout = Layout::new(job, &payloads.classes());
        let beside = Beside::new(job, |at| layout.has_file(at.file));
        Self { job, layout, payloads, beside, named: RefCell::default() }
    }

    /// Returns the path of a class's module, as far as it is not imported.
    fn module(&self, class: ClassIndex) -> String {
        self.named.borrow_mut().insert(class);
        self.layout.imported(class)
    }

    /// Returns the path of a class's struct.
    pub(super) fn class(&self, class: ClassIndex) -> String {
        format!("{}::{}", self.module(class), self.layout.name(class))
    }

    /// Returns all code of the crate.
    fn codes(&self) -> impl Iterator<Item = &str> {
        let view = self.job.view;
        let text = |code: &'p SourceCode| code.text.as_str();
        let files = self.layout.files().flat_map(move |(file, _)| view.preambles(file).iter().map(text));
        let classes = self.layout.files().flat_map(|(file, _)| self.layout.classes_of(file));
        files.chain(classes.flat_map(move |(class, _)| view.class(class).codes()))
    }
}

impl Bodies for RustBodies<'_> {
    fn native_parts(&self) -> NativeParts {
        match self.beside.is_any() {
            true if self.beside.has_headers() => NativeParts::Headers,
            true if !self.job.is_image => NativeParts::Sources,
            _ => NativeParts::None,
        }
    }

    fn build_files(&self) -> Result<Vec<File>, EmitError> {
        sending::check_heap(self.job)?;
        Ok(self.beside.files(self.job))
    }

    fn emit(&self, output: &mut Output) -> Result<(), EmitError> {
        let (view, layout, binds) = (self.job.view, &self.layout, self.beside.has_headers());
        for (file, module) in layout.files() {
            let folder = format!("{}/src/{module}", self.job.folder);
            output.mapped.push(file_module::emit(view, layout, file, binds, format!("{folder}/mod.rs"))?);
            for (class, class_module) in layout.classes_of(file) {
                output.mapped.push(reactor::emit(view, layout, class, format!("{folder}/{class_module}.rs"))?);
            }
        }
        Ok(())
    }

    fn modules(&self) -> Vec<&str> {
        self.layout.files().map(|(_, module)| module).collect()
    }

    fn reactor_modules(&self) -> Vec<String> {
        let language = self.job.view.language;
        let is_named = self.codes().any(|code| language.words(code).any(|word| word == REACTORS));
        let paths = self.layout.files().flat_map(|(file, module)| {
            self.layout.classes_of(file).map(move |(_, class)| (class, format!("{module}::{class}")))
        });
        // Two files can have reactors of one name; the paths of LF's compiler do not tell them apart either.
        paths.filter(|_| is_named).collect::<BTreeMap<_, _>>().into_values().collect()
    }

    // The compiler has not read the user's own modules.
    fn uses_devices(&self) -> bool {
        let language = self.job.view.language;
        !self.job.view.cargo.modules.is_empty()
            || self.codes().any(|code| language.words(code).any(|word| DEVICES.contains(&word)))
    }

    fn parameters(&self) -> TokenStream {
        quote!(lf::Parameters::NONE)
    }

    fn payload_lengths(&self) -> Result<Vec<String>, EmitError> {
        self.payloads.lengths(self.job.plan(), &self.layout)
    }

    fn serializer(&self, serializer: &Serializer, ty: &str) -> Option<String> {
        Some(serializer_type(serializer, ty))
    }

    fn max_len(&self, _: &Port, ty: &str, serializer: Option<&Serializer>) -> String {
        sending::max_len(serializer, ty)
    }

    fn room(&self, capacity: usize) -> usize {
        capacity
    }

    fn cell(&self, name: &str) -> String {
        name.to_owned()
    }

    fn cells_refer(&self) -> bool {
        false
    }

    // A preamble's declarations are known only to the module of the reactor, which has a name for the type.
    fn value_type(&self, path: &str, ty: &Type) -> Result<String, EmitError> {
        let declared = self.job.federate.and_then(|federate| federate.declared(path));
        match declared {
            Some((class, name)) if !is_copy(&ty.text) => Ok(format!("{}::{}", self.module(class), type_alias(name))),
            _ => parsed_type(self.job.plan(), ty).map(|_| ty.text.clone()),
        }
    }

    fn instances(&self, owner: &Owner<'_>, members: &mut Members, splices: &mut Splices<'_>) -> Result<(), EmitError> {
        self.add_instances(owner, members, splices)
    }

    fn reactions(&self, owner: &Owner<'_>, part: ReactionPart) -> Vec<(usize, String)> {
        calls::of_reactions(owner, part)
    }

    fn shares(&self, owner: &Owner<'_>) -> Vec<String> {
        calls::levels(owner)
    }

    fn resets(&self, owner: &Owner<'_>) -> Vec<String> {
        calls::modes(owner)
    }

    fn handovers(&self, owner: &Owner<'_>) -> [Vec<String>; 2] {
        calls::handovers(owner)
    }

    fn state_len(&self, owner: &Owner<'_>, row: &HandedOverRow<'_>) -> String {
        let class = owner.federate.instances[row.instance.0].class;
        format!("{}::{}", self.module(class), bytes_constant(&row.state.name))
    }

    fn implementations(&self, _: &Owner<'_>, _: &str) -> String {
        String::new()
    }

    fn imports(&self) -> String {
        let braced = |names: &[&str]| match names {
            [name] => (*name).to_owned(),
            _ => format!("{{{}}}", names.join(", ")),
        };
        let imported = self.layout.imports(&self.named.borrow());
        let lines = imported.iter().map(|(file, modules)| format!("use crate::{file}::{};\n", braced(modules)));
        format!("\n{}", lines.collect::<String>())
    }
}
