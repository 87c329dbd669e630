// SPDX-License-Identifier: Apache-2.0
//! The host's access to bodies in C: functions that take the number of a reaction, and cells of references to the
//! values in C.

use std::collections::BTreeMap;

use lf_model::TriggerId;
use proc_macro2::TokenStream;
use quote::quote;

use super::sizes::Sizes;
use super::symbols::{Symbols, preamble_headers};
use super::{class, counterparts, external, header, parameters, program};
use crate::emit::host::{
    Bodies, CompilerArguments, Members, NativeParts, Output, Owner, ReactionPart, Splices, ids, push_methods,
};
use crate::emit::{EmitError, File, Job};
use crate::plan::{FileIndex, Location, Port, ReactionKind, ScheduledReaction, Serializer, Type};
use crate::tables::{Cell, HandedOverRow};

/// Signatures of the methods by which C reaches cells, the value that each matches on, and its result for other values.
const ACTION: [&str; 3] =
    ["action(&mut self, trigger: TriggerId) -> Option<&mut dyn Schedulable<Value = c::Token>>", "trigger", "None,"];
const WATCHDOG: [&str; 3] = ["watchdog(&mut self, trigger: TriggerId) -> Option<&mut Watchdog>", "trigger", "None,"];
const INBOX: [&str; 3] = ["inbox(trigger: TriggerId) -> Option<&'static dyn Inbox<c::Token>>", "trigger", "None,"];

/// The minimum capacity of an action's queue in programs for this computer: C relies on queues that grow.
const ROOM: usize = 256;

/// The bodies of a participant in C.
pub(in crate::emit) struct CBodies<'p> {
    job: &'p Job<'p>,
    sizes: Sizes<'p>,
}

impl<'p> CBodies<'p> {
    pub(in crate::emit) fn new(job: &'p Job<'p>) -> Self {
        Self { job, sizes: Sizes::new(job.view, job.federate, job.rti) }
    }
}

impl Bodies for CBodies<'_> {
    fn native_parts(&self) -> NativeParts {
        NativeParts::Bodies
    }

    /// Returns the build script that compiles the C code and measures its sizes. Zephyr's build compiles C itself, and
    /// needs the sizes only.
    fn build_files(&self) -> Result<Vec<File>, EmitError> {
        let (job, mut files) = (self.job, Vec::new());
        let (mut all, folder) = (CompilerArguments::of_bodies(job), job.folder);
        let headers = if header::are_needed(job.view) { &header::FOLDERS[..] } else { &[] };
        if job.is_image {
            if let Some(file) = job.view.native.protobufs.first() {
                let hint = "have a `cmake-include` compile the messages with nanopb, which Zephyr brings";
                let message = format!("`protobufs` is for programs of a computer, as images lack protobuf-c: {hint}");
                return Err(EmitError::new(job.plan(), file.at, message));
            }
            if let Some(word) = all.needs_library() {
                let flag = job.view.native.flags.iter().find(|flag| flag.text == word);
                let at = flag.map_or(Location { file: FileIndex(0), line: 1, column: 1 }, |flag| flag.at);
                let hint =
                    "remove it; on native_sim, `CONFIG_ASAN=y` and `CONFIG_UBSAN=y` in prj.conf look for mistakes";
                let message = format!("`{word}` needs a library that images do not have: {hint}");
                return Err(EmitError::new(job.plan(), at, message));
            }
            let own = headers.iter().map(|folder| format!("${{CMAKE_CURRENT_LIST_DIR}}/../{folder}"));
            files.push(File { path: format!("{folder}/c/program.cmake"), text: all.cmake(job, own) });
            all = CompilerArguments::default();
        } else {
            all.folders.extend(headers.iter().map(|folder| (*folder).to_owned()));
            files.push(File { path: format!("{folder}/compile_flags.txt"), text: all.compile_flags(job) });
        }
        files.push(File { path: format!("{folder}/build.rs"), text: all.build_script(job, "program") });
        Ok(files)
    }

    fn emit(&self, output: &mut Output) -> Result<(), EmitError> {
        let (view, folder) = (self.job.view, self.job.folder);
        let files = &mut output.files;
        for (index, header) in preamble_headers(view.plan).iter().enumerate() {
            files.push(class::preamble_header(view, FileIndex(index), header, folder));
        }
        files.push(self.sizes.file(folder));
        if let Some(federate) = self.job.federate {
            let symbols = Symbols::new(view, federate);
            external::check(&symbols)?;
            for (class, _) in symbols.classes() {
                files.push(class::emit(&symbols, class, folder)?);
            }
            files.extend(header::emit(view, folder));
            files.push(program::emit(&symbols, folder));
            files.extend(counterparts::emit(view, federate, folder));
        }
        Ok(())
    }

    fn modules(&self) -> Vec<&str> {
        Vec::new()
    }

    fn reactor_modules(&self) -> Vec<String> {
        Vec::new()
    }

    fn uses_devices(&self) -> bool {
        false
    }

    fn parameters(&self) -> TokenStream {
        parameters::of_main(self.job.view)
    }

    fn payload_lengths(&self) -> Result<Vec<String>, EmitError> {
        Ok(self.sizes.all())
    }

    fn serializer(&self, _: &Serializer, _: &str) -> Option<String> {
        None
    }

    fn max_len(&self, port: &Port, _: &str, serializer: Option<&Serializer>) -> String {
        self.sizes.max_len(port, serializer)
    }

    fn room(&self, capacity: usize) -> usize {
        if self.job.is_image { capacity } else { capacity.max(ROOM) }
    }

    fn cell(&self, name: &str) -> String {
        format!("c::{}", name.trim_end_matches("Queue"))
    }

    fn cells_refer(&self) -> bool {
        true
    }

    fn value_type(&self, _: &str, _: &Type) -> Result<String, EmitError> {
        Ok(String::new())
    }

    fn instances(&self, _: &Owner<'_>, members: &mut Members, _: &mut Splices<'_>) -> Result<(), EmitError> {
        members.locals.extend(quote! { c::construct(); });
        Ok(())
    }

    fn reactions(&self, owner: &Owner<'_>, part: ReactionPart) -> Vec<(usize, String)> {
        let call = |(id, reaction): (usize, &ScheduledReaction)| match &reaction.kind {
            ReactionKind::Copy { from, to } if part == ReactionPart::Body => {
                let [from, to] = [from, to].map(|port| format!("c::Port::new(PortId({}))", port.0));
                Some((id, format!("c::copy(ctx, {from}, {to})")))
            }
            ReactionKind::Body { instance, reaction, .. } => {
                let declared = &owner.plan.class(&owner.federate.instances[instance.0]).reactions[reaction - 1];
                part.run(declared)?;
                Some((id, format!("c::{}(self, ReactionId({id}), ctx)", part.method())))
            }
            _ => None,
        };
        owner.federate.reactions.iter().enumerate().filter_map(call).collect()
    }

    fn shares(&self, owner: &Owner<'_>) -> Vec<String> {
        let mut triggers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (id, trigger) in owner.federate.triggers.iter().enumerate() {
            if let Some((reactor, _)) = trigger.path.rsplit_once('.') {
                triggers.entry(reactor).or_default().push(id);
            }
        }
        owner.levels(|instance, reactions| {
            let own = |kinds: &[Cell]| -> Vec<usize> {
                let all = triggers.get(&*owner.federate.instances[instance].path).into_iter().flatten();
                all.copied().filter(|id| kinds.contains(&owner.tables.triggers[*id].cell)).collect()
            };
            let cells = |ids: &[usize]| {
                let cells = ids.iter().map(|id| format!("(TriggerId({id}), &mut {})", owner.symbols.triggers[*id]));
                cells.collect::<Vec<_>>().join(", ")
            };
            let (actions, watchdogs) = (own(&[Cell::Logical, Cell::Physical]), own(&[Cell::Watchdog]));
            let reactor = format!("c::ReactorCells::new(&mut [{}], &mut [{}])", cells(&actions), cells(&watchdogs));
            let all = actions.iter().chain(&watchdogs).filter_map(|id| Some(TriggerId(u16::try_from(*id).ok()?)));
            let (reactions, all) = (ids(reactions), ids(&all.collect::<Vec<_>>()));
            format!("Job::new({reactions}, {all}, &mut |id, part, ctx| {reactor}.run::<Self>(part, id, ctx))")
        })
    }

    fn resets(&self, _: &Owner<'_>) -> Vec<String> {
        vec!["_ => c::reset_mode(mode)".to_owned()]
    }

    fn handovers(&self, owner: &Owner<'_>) -> [Vec<String>; 2] {
        let arms = |function: &str| {
            let is_any = !owner.tables.handed_over.is_empty();
            is_any.then(|| format!("_ => c::{function}(state, bytes)")).into_iter().collect()
        };
        [arms("hand_over"), arms("take_over")]
    }

    fn state_len(&self, owner: &Owner<'_>, row: &HandedOverRow<'_>) -> String {
        self.sizes.state_len(owner.federate.instances[row.instance.0].class, row.state)
    }

    fn implementations(&self, owner: &Owner<'_>, name: &str) -> String {
        let (triggers, symbols) = (&owner.tables.triggers, &owner.symbols);
        let cells = |kinds: &[Cell]| {
            let cells = triggers.iter().enumerate().filter(|(_, row)| kinds.contains(&row.cell));
            cells.map(|(id, _)| format!("TriggerId({id}) => Some(&mut {})", symbols.triggers[id])).collect()
        };
        let inboxes = triggers.iter().enumerate().filter(|(_, row)| row.cell == Cell::Physical);
        let inboxes = inboxes.map(|(id, _)| format!("TriggerId({id}) => Some(&{})", symbols.inboxes[id]));
        let mut text = format!("\nimpl c::Bodies for {name} {{\n");
        let actions = cells(&[Cell::Logical, Cell::Physical]);
        push_methods(&mut text, [(ACTION, actions), (WATCHDOG, cells(&[Cell::Watchdog])), (INBOX, inboxes.collect())]);
        text.replace(" {\n\n", " {\n") + "}\n"
    }

    fn imports(&self) -> String {
        "use lf::c;\n".to_owned()
    }
}
