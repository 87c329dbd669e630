// SPDX-License-Identifier: Apache-2.0
//! Completion: the words that may stand at a place of a file.

mod api;
mod context;
mod items;
mod target;

use lf_compiler::plan::Language;
use lf_compiler::syntax::ast::{ReactionSyntax, Reactor};
use lf_compiler::{Declaration, NameKind, SourceProvider as _, parse, supported};
use lsp_types::{CompletionItem, CompletionItemKind, CompletionParams};

use super::asked::Asked;
use super::buffers::Buffers;
use context::Wanted;
use items::{declared, item, markdown, of_kinds, ports_of};

/// The words that begin declarations in a reactor.
const MEMBERS: &[&str] = &[
    "input",
    "output",
    "state",
    "timer",
    "logical action",
    "physical action",
    "reaction",
    "mode",
    "initial mode",
    "watchdog",
    "preamble",
    "method",
    "reset state",
    "mutable input",
];
/// The words that begin declarations in a file.
const TOP: &[&str] = &["target", "import", "preamble", "reactor", "main reactor", "federated reactor"];
/// The events that every reactor has.
const EVENTS: &[&str] = &["startup", "shutdown", "reset"];
/// Units of time in their shortest spelling, each with its meaning.
const UNITS: &[(&str, &str)] = &[
    ("ns", "nanoseconds"),
    ("us", "microseconds"),
    ("ms", "milliseconds"),
    ("s", "seconds"),
    ("min", "minutes"),
    ("h", "hours"),
    ("d", "days"),
    ("wk", "weeks"),
];

/// Attributes with their arguments and their effects.
const ATTRIBUTES: &[(&str, &str, &str)] = &[
    ("label", "(\"…\")", "the text in diagrams"),
    ("icon", "(\"…\")", "the picture in diagrams"),
    ("side", "(\"…\")", "the side of a port in diagrams: `north`, `east`, `south` or `west`"),
    ("layout", "(option=\"…\", value=\"…\")", "an option of diagrams"),
    ("capacity", "(16)", "how many events may wait, before an action, an input or a connection"),
    ("maxwait", "(10 ms)", "how long a federate waits for messages, with decentralized coordination"),
    ("absent_after", "(10 ms)", "how long an input of a connection is awaited within a tag"),
    ("serializer", "(\"…\")", "how values become bytes"),
    ("max_length", "(200)", "the largest number of bytes of a value"),
    ("transient", "", "a federate that comes and goes while the others run"),
    ("handed_over", "", "a state that a transient federate hands over to the instance that takes its place"),
    ("timeout", "(10 s)", "the target property `timeout`, before the main reactor"),
    ("fast", "", "the target property `fast`, before the main reactor"),
    ("keepalive", "", "the target property `keepalive`, before the main reactor"),
    ("logging", "(\"debug\")", "the target property `logging`, before the main reactor"),
    ("platform", "(\"Zephyr\")", "the target property `platform`, before the main reactor"),
    ("build_type", "(\"Release\")", "the target property `build-type`, before the main reactor"),
    ("clock_sync", "(\"on\")", "the target property `clock-sync`, before the main reactor"),
];

/// Returns what may stand at a place.
pub(super) fn completion(buffers: &Buffers, asked: &CompletionParams) -> Option<Vec<CompletionItem>> {
    // A colon asks for what a path of Rust or C++ leads to, which only their tools know.
    let context = asked.context.as_ref();
    if context.and_then(|context| context.trigger_character.as_deref()) == Some(":") {
        return None;
    }
    let asked = Asked::new(buffers, &asked.text_document_position)?;
    let language = language(&asked);
    let all = match context::wanted(asked.text, asked.byte) {
        Wanted::Nothing => return None,
        Wanted::Attribute => attributes().collect(),
        Wanted::Unit => UNITS.iter().map(|(unit, what)| item(unit, CompletionItemKind::UNIT, what)).collect(),
        Wanted::PropertyKey(path) => target::keys(language, &path),
        Wanted::PropertyValue(path) => target::values(language, &path),
        Wanted::PortOf(name) => ports_of(&asked, &name),
        Wanted::Class => classes(&asked),
        Wanted::ImportFile { quoted } => files(buffers, &asked, quoted),
        Wanted::Imported(file) => imported(buffers, &asked, &file?),
        Wanted::Argument(class) => arguments(&asked, &class),
        Wanted::Value => of_kinds(&asked, &[NameKind::Parameter]),
        Wanted::Trigger => {
            let events = EVENTS.iter().map(|event| item(event, CompletionItemKind::EVENT, "of every reactor"));
            events.chain(of_kinds(&asked, TRIGGERS)).collect()
        }
        Wanted::Effect => of_kinds(&asked, EFFECTS),
        Wanted::End => of_kinds(&asked, ENDS),
        Wanted::Code => api::in_code(&asked, language, reaction_at(&asked), reactor_at(&asked)),
        Wanted::Member => {
            let names = of_kinds(&asked, ENDS);
            let words = MEMBERS.iter().map(|word| item(word, CompletionItemKind::KEYWORD, ""));
            words.chain(names).collect()
        }
        Wanted::Top => TOP.iter().map(|word| item(word, CompletionItemKind::KEYWORD, "")).collect(),
    };
    Some(all)
}

const TRIGGERS: &[NameKind] = &[
    NameKind::Input,
    NameKind::Timer,
    NameKind::LogicalAction,
    NameKind::PhysicalAction,
    NameKind::Watchdog,
    NameKind::Instance,
];
const EFFECTS: &[NameKind] = &[
    NameKind::Output,
    NameKind::LogicalAction,
    NameKind::PhysicalAction,
    NameKind::Watchdog,
    NameKind::Mode,
    NameKind::Instance,
];
const ENDS: &[NameKind] = &[NameKind::Input, NameKind::Output, NameKind::Instance];

/// Returns the language of the file's bodies.
fn language(asked: &Asked<'_>) -> Language {
    let name = asked.unit().target.as_ref().map(|target| target.name.text.as_str()).unwrap_or_default();
    let is_rust = name.is_empty() || name.eq_ignore_ascii_case(Language::Rust.name());
    if is_rust { Language::Rust } else { Language::C }
}

fn reactor_at<'a>(asked: &'a Asked<'_>) -> Option<&'a Reactor> {
    asked.unit().reactors.get(asked.reactor_at(asked.byte)?)
}

/// Returns the reaction with the code at the place.
fn reaction_at<'a>(asked: &'a Asked<'_>) -> Option<&'a ReactionSyntax> {
    let all = asked.unit().reactors.iter().flat_map(|reactor| &reactor.body.reactions);
    let before = all.filter(|reaction| reaction.keyword.start <= asked.byte);
    before.max_by_key(|reaction| reaction.keyword.start)
}

fn attributes() -> impl Iterator<Item = CompletionItem> {
    supported().attributes.into_iter().map(|name| {
        let known = ATTRIBUTES.iter().find(|(known, ..)| *known == name);
        let (arguments, what) = known.map_or(("", ""), |(_, arguments, what)| (*arguments, *what));
        CompletionItem {
            insert_text: Some(format!("{name}{arguments}")),
            documentation: markdown(what),
            ..item(name, CompletionItemKind::PROPERTY, &format!("@{name}{arguments}"))
        }
    })
}

fn classes(asked: &Asked<'_>) -> Vec<CompletionItem> {
    let is_class = |(span, one): &(_, &Declaration)| one.span == *span && one.kind == NameKind::Reactor;
    asked.names.iter().filter(is_class).map(|(_, one)| declared(asked, one)).collect()
}

fn arguments(asked: &Asked<'_>, class: &str) -> Vec<CompletionItem> {
    let members = asked.class(class).into_iter().flat_map(|class| asked.members_of(class));
    let parameters = members.filter(|one| one.kind == NameKind::Parameter);
    let assignment = |parameter: &Declaration| CompletionItem {
        insert_text: Some(format!("{} = ", asked.name(parameter))),
        ..declared(asked, parameter)
    };
    parameters.map(assignment).collect()
}

/// Returns the files beside this one.
fn files(buffers: &Buffers, asked: &Asked<'_>, quoted: bool) -> Vec<CompletionItem> {
    let folder = std::path::Path::new(asked.path).parent().unwrap_or_else(|| std::path::Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let on_disk = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let open = buffers.paths().filter_map(|path| {
        let path = std::path::Path::new(path);
        path.parent().filter(|one| *one == folder).and_then(|_| Some(path.file_name()?.to_str()?.to_owned()))
    });
    let own = std::path::Path::new(asked.path).file_name().map(|name| name.to_string_lossy().into_owned());
    let is_lf = |name: &String| matches!(name.rsplit_once('.'), Some((_, "lf" | "ulf")));
    let mut names: Vec<String> = on_disk.chain(open).filter(is_lf).filter(|name| Some(name) != own.as_ref()).collect();
    names.sort();
    names.dedup();
    let text = |name: &String| if quoted { name.clone() } else { format!("\"{name}\"") };
    names.iter().map(|name| item(&text(name), CompletionItemKind::FILE, "")).collect()
}

/// Returns the reactors of the file that an import names.
fn imported(buffers: &Buffers, asked: &Asked<'_>, file: &str) -> Vec<CompletionItem> {
    let path = std::path::Path::new(asked.path).with_file_name(file);
    let Some(text) = path.to_str().and_then(|path| buffers.read(path).ok()) else { return Vec::new() };
    let unit = parse(file, &text).unit;
    let reactors = unit.reactors.iter().filter_map(|reactor| {
        let name = reactor.name.as_ref()?;
        let documentation = markdown(reactor.docs.as_deref().unwrap_or_default());
        Some(CompletionItem { documentation, ..item(&name.text, CompletionItemKind::CLASS, file) })
    });
    reactors.collect()
}

#[cfg(test)]
mod tests {
    use lf_compiler::supported;

    use super::ATTRIBUTES;

    #[test]
    fn each_attribute_is_described() {
        for name in supported().attributes {
            assert!(ATTRIBUTES.iter().any(|(known, ..)| *known == name), "@{name}");
        }
    }
}
