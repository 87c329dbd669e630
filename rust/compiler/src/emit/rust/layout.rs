// SPDX-License-Identifier: Apache-2.0
//! The modules of a crate: one per LF file, and in it one per reactor class that the federate needs, or whose types the
//! RTI needs.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::Ident;

use super::items::Items;
use super::prelude::{KNOWN_TYPES, PRELUDE, PRIMITIVES};
use crate::emit::Job;
use crate::emit::host::{SentPort, copied_ports, ident, sent_ports};
use crate::emit::names::{Names, shortened, snake_case};
use crate::emit::view::View;
use crate::lexical::is_plain;
use crate::plan::{ClassIndex, Federate, FileIndex, ReactorClass};

/// Root modules that a file's module must not hide: those of the crate itself, and crates at the beginning of paths.
const RESERVED: [&str; 13] =
    ["alloc", "core", "federate", "lf", "lib", "log", "main", "mod", "postcard", REACTORS, "rti", "serde", "std"];

/// The module in which LF's own compiler has the modules of all reactors.
pub(super) const REACTORS: &str = "reactors";

/// The module with the declarations of C headers.
const BINDINGS: &str = "c";

/// The modules of one crate.
pub(super) struct Layout<'p> {
    files: BTreeMap<FileIndex, String>,
    classes: BTreeMap<ClassIndex, ClassModule>,
    /// The children of each class of which this federate has instances.
    children: BTreeSet<(ClassIndex, usize)>,
    /// The reactions of each class that it has: all, except for those of the federated reactor.
    reactions: BTreeSet<(ClassIndex, usize)>,
    /// Ports that receive values from other federates or send to them, by class and name.
    sent: BTreeMap<(ClassIndex, &'p str), SentPort<'p>>,
    /// Ports whose values connections copy, by class and name.
    copied: BTreeSet<(ClassIndex, &'p str)>,
    /// The number of threads that run its reactions.
    workers: u16,
}

struct ClassModule {
    file: FileIndex,
    module: String,
    name: Ident,
    /// Whether there are reactions and state, and not only types.
    whole: bool,
}

impl<'p> Layout<'p> {
    /// Returns the modules that a federate needs: the classes of its instances, and the main one, which constructs the
    /// first; and those of classes of which only the types are needed.
    pub(super) fn new(job: &'p Job<'p>, types: &BTreeSet<ClassIndex>) -> Self {
        let (view, plan, federate) = (job.view, job.plan(), job.federate);
        let instances = || federate.iter().flat_map(|federate| &federate.instances);
        let children = federate.map(|federate| federate.children(plan.main)).unwrap_or_default();
        let reactions = federate.map(Federate::bodies).unwrap_or_default();
        let mut used: BTreeMap<ClassIndex, bool> = types.iter().map(|class| (*class, false)).collect();
        used.extend(instances().map(|instance| (instance.class, true)));
        used.extend(federate.map(|_| (plan.main, true)));
        let included = view.cargo.modules.iter().map(|module| module.name.as_str());
        let headers = (!view.native.headers.is_empty()).then_some(BINDINGS);
        // A module hides the crate, the type and the item of the same name.
        let crates = view.cargo.dependencies.iter().map(|one| one.name.replace('-', "_"));
        let crates: Vec<String> = crates.collect();
        let known = RESERVED.into_iter().chain(PRIMITIVES).chain(headers).chain(crates.iter().map(String::as_str));
        let known: Vec<&str> = known.collect();
        let reserved: Vec<&str> = known.iter().copied().chain(included).collect();
        let mut file_names = Names::reserving(&reserved);
        let mut items: BTreeMap<FileIndex, Items> = BTreeMap::new();
        let mut files = BTreeMap::new();
        let mut class_names: BTreeMap<FileIndex, Names> = BTreeMap::new();
        let mut classes = BTreeMap::new();
        for (index, whole) in used {
            let class = view.class(index);
            let file = class.at.file;
            files.entry(file).or_insert_with(|| file_names.give(&module_name(stem(&plan.files[file.0].path))));
            let of_file = items.entry(file).or_insert_with(|| Items::of(view.preambles(file)));
            let names = class_names.entry(file).or_insert_with(|| {
                let of_file = of_file.declared.iter().chain(&of_file.imported).map(String::as_str);
                Names::reserving(&known.iter().copied().chain(of_file).collect::<Vec<_>>())
            });
            let module = names.give(&module_name(&class.name));
            classes.insert(index, ClassModule { file, module, name: struct_name(class, of_file), whole });
            for file in &class.files {
                let module = || file_names.give(&module_name(stem(&plan.files[file.0].path)));
                files.entry(*file).or_insert_with(module);
            }
        }
        let sent = federate.into_iter().flat_map(|federate| {
            let place = |(port, sent): (_, SentPort<'p>)| Some(((federate.declared_port(port)?.0, sent.name), sent));
            sent_ports(federate).filter_map(place)
        });
        let copied = federate.into_iter().flat_map(copied_ports).collect();
        Self { files, classes, children, reactions, sent: sent.collect(), copied, workers: job.workers() }
    }

    /// Returns the number of threads that run its reactions. With more than one, state and values have to be `Send`.
    pub(super) fn workers(&self) -> u16 {
        self.workers
    }

    /// Returns a port of a class, if it receives values from other federates or sends to them.
    pub(super) fn sent_of(&self, class: ClassIndex, port: &str) -> Option<SentPort<'p>> {
        self.sent.get(&(class, port)).cloned()
    }

    /// Returns whether connections copy the values of a port of a class.
    pub(super) fn is_copied(&self, class: ClassIndex, port: &str) -> bool {
        self.copied.contains(&(class, port))
    }

    /// Returns the files with their modules.
    pub(super) fn files(&self) -> impl Iterator<Item = (FileIndex, &str)> {
        self.files.iter().map(|(file, module)| (*file, module.as_str()))
    }

    /// Returns whether the crate has a module of this file.
    pub(super) fn has_file(&self, file: FileIndex) -> bool {
        self.files.contains_key(&file)
    }

    /// Returns the path of a file's module from anywhere in the crate.
    pub(super) fn file_path(&self, file: FileIndex) -> Option<String> {
        self.files.get(&file).map(|module| format!("crate::{module}"))
    }

    /// Returns the classes of a file with their modules.
    pub(super) fn classes_of(&self, file: FileIndex) -> impl Iterator<Item = (ClassIndex, &str)> {
        let of_file = self.classes.iter().filter(move |(_, place)| place.file == file);
        of_file.map(|(class, place)| (*class, place.module.as_str()))
    }

    /// Returns the modules of the classes of other files, with their files' modules: in LF's Rust target all reactors
    /// are siblings, so a body may use `super::other_reactor::item`. If names clash, the file's own module wins.
    pub(super) fn siblings_of(&self, view: &View<'_>, file: FileIndex) -> Vec<(&str, &str)> {
        let own = Items::of(view.preambles(file));
        let mut taken: BTreeSet<&str> = self.classes_of(file).map(|(_, module)| module).collect();
        let others = self.classes.values().filter(|place| place.file != file);
        let named = others.filter_map(|place| Some((self.files.get(&place.file)?.as_str(), place.module.as_str())));
        named.filter(|(_, module)| !own.has(module) && taken.insert(module)).collect()
    }

    /// Returns whether the crate has this class with its reactions and its state.
    pub(super) fn has(&self, class: ClassIndex) -> bool {
        self.classes.get(&class).is_some_and(|place| place.whole)
    }

    /// Returns whether this federate has an instance of this child of a class.
    pub(super) fn makes(&self, class: ClassIndex, child: usize) -> bool {
        self.children.contains(&(class, child))
    }

    /// Returns whether this federate has a reaction of a class, by its number.
    pub(super) fn reacts(&self, class: ClassIndex, reaction: usize) -> bool {
        self.reactions.contains(&(class, reaction))
    }

    /// Returns the name of a class's struct; empty for a class that the crate does not have.
    pub(super) fn name(&self, class: ClassIndex) -> String {
        self.classes.get(&class).map_or_else(String::new, |place| place.name.to_string())
    }

    /// Returns the path of a class's module from anywhere in the crate.
    pub(super) fn module_path(&self, class: ClassIndex) -> String {
        self.place(class).map_or_else(String::new, |(file, module)| format!("crate::{file}::{module}"))
    }

    /// Returns the path of a class's struct from the module of another class.
    pub(super) fn class_path(&self, from: ClassIndex, class: ClassIndex) -> String {
        let same_file = |(one, other): (&ClassModule, &ClassModule)| one.file == other.file;
        let module = match self.classes.get(&from).zip(self.classes.get(&class)) {
            Some(places) if same_file(places) => format!("super::{}", places.1.module),
            _ => self.module_path(class),
        };
        format!("{module}::{}", self.name(class))
    }

    /// Returns the path of a class's module where it is imported: its name, if no other file has such a module.
    pub(super) fn imported(&self, class: ClassIndex) -> String {
        match self.place(class) {
            Some((_, module)) if self.is_unique(module) => module.to_owned(),
            _ => self.module_path(class),
        }
    }

    /// Returns the imports by which these classes can be named: modules by files.
    pub(super) fn imports(&self, classes: &BTreeSet<ClassIndex>) -> BTreeMap<&str, Vec<&str>> {
        let mut imports: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (file, module) in classes.iter().filter_map(|class| self.place(*class)) {
            if self.is_unique(module) {
                imports.entry(file).or_default().push(module);
            }
        }
        for modules in imports.values_mut() {
            modules.sort_unstable();
        }
        imports
    }

    fn is_unique(&self, module: &str) -> bool {
        self.classes.values().filter(|place| place.module == module).count() == 1
    }

    /// Returns the modules of a class's file and of the class.
    fn place(&self, class: ClassIndex) -> Option<(&str, &str)> {
        let place = self.classes.get(&class)?;
        Some((self.files.get(&place.file)?.as_str(), place.module.as_str()))
    }
}

/// Returns the name of a file without folders and extension.
pub(super) fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Returns the name of a class's struct: that of the class, unless it would hide another name that bodies use. No body
/// needs it, since all have `Self`.
fn struct_name(class: &ReactorClass, of_file: &Items) -> Ident {
    let own = Items::of(&class.preambles);
    let is_type = |name: &str| class.types.iter().any(|(parameter, _)| parameter == name);
    let is_taken = |name: &str| {
        let known = [&PRIMITIVES[..], &KNOWN_TYPES, &PRELUDE].iter().any(|known| known.contains(&name));
        known || is_type(name) || own.has(name) || of_file.has(name)
    };
    let mut name = class.name.clone();
    while is_taken(&name) {
        name.push_str("Reactor");
    }
    ident(&name)
}

/// Returns a module's name, which is also a file's name, and so must not need to be raw.
fn module_name(name: &str) -> String {
    let snake = shortened(&snake_case(name), '_');
    if is_plain(&snake) { snake } else { format!("{snake}_") }
}
