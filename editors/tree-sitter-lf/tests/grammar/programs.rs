// SPDX-License-Identifier: Apache-2.0
//! Programs that the compiler's parser accepts.

use std::env;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use lf_compiler::syntax::ast::{ActionKind, SourceUnit};
use lf_compiler::{Severity, SyntaxTree};
use tree_sitter::{Node, Tree};

use super::{codes, nodes, parse, programs, repository};

/// The variable with a folder of further programs, such as LF's own tests.
const FOLDER: &str = "LF_PROGRAMS";

/// A declaration: the kind of its node, and the place of its name.
type Declared = (&'static str, Range<usize>);

/// Returns the declarations that the compiler's parser finds.
fn declared(unit: &SourceUnit) -> Vec<Declared> {
    let mut all = Vec::new();
    for reactor in &unit.reactors {
        let mut add = |kind, name: &lf_compiler::syntax::ast::Name| all.push((kind, name.span.start..name.span.end));
        reactor.name.iter().for_each(|name| add("reactor", name));
        reactor.parameters.iter().for_each(|it| add("parameter", &it.name));
        let body = &reactor.body;
        body.states.iter().for_each(|it| add("state", &it.name));
        body.methods.iter().for_each(|it| add("method", &it.name));
        body.ports.iter().for_each(|it| add("port", &it.name));
        body.timers.iter().for_each(|it| add("timer", &it.name));
        body.instances.iter().for_each(|it| add("instantiation", &it.name));
        body.modes.iter().flat_map(|it| &it.name).for_each(|name| add("mode", name));
        for action in &body.actions {
            add(if action.kind == ActionKind::Watchdog { "watchdog" } else { "action" }, &action.name);
        }
        // The handler of a watchdog is a reaction to the compiler.
        let reactions = body.reactions.iter().filter(|it| it.triggers.first().map(|it| &it.name) != it.name.as_ref());
        reactions.flat_map(|it| &it.name).for_each(|name| add("reaction", name));
    }
    all.sort_by_key(|(_, place)| place.start);
    all
}

/// Returns the declarations in the tree.
fn found(tree: &Tree) -> Vec<Declared> {
    let kinds = [
        "reactor",
        "parameter",
        "state",
        "method",
        "port",
        "timer",
        "instantiation",
        "mode",
        "action",
        "watchdog",
        "reaction",
    ];
    let is_declaration = |node: &Node<'_>| kinds.contains(&node.kind());
    let declared = nodes(tree).into_iter().filter(is_declaration);
    let named = declared.filter_map(|node| Some((node.kind(), node.child_by_field_name("name")?.byte_range())));
    let mut all: Vec<Declared> = named.collect();
    all.sort_by_key(|(_, place)| place.start);
    all
}

/// Returns what the tree of a program has else than the compiler's, or `None` if the compiler refuses the program.
fn differences(path: &Path) -> Option<Vec<String>> {
    // The compiler's places are those of a text without carriage returns and without a mark of its order of bytes.
    let text = fs::read_to_string(path).ok()?.replace("\r\n", "\n");
    let text = text.trim_start_matches('\u{feff}');
    let SyntaxTree { unit, diagnostics } = lf_compiler::parse(&path.to_string_lossy(), text);
    if diagnostics.iter().any(|one| one.severity() == Severity::Error) {
        return None;
    }
    let tree = parse(text);
    let mut all = Vec::new();
    let mut say = |place: usize, what: &str| {
        let line = text[..place].lines().count().max(1);
        all.push(format!("{}:{line}: {what}", path.display()));
    };
    for node in nodes(&tree).iter().filter(|node| node.is_error() || node.is_missing()) {
        say(node.start_byte(), "cannot be read");
    }
    let (wanted, declared) = (declared(&unit), found(&tree));
    for (kind, place) in wanted.iter().filter(|one| !declared.contains(one)) {
        say(place.start, &format!("the {kind} {} is missing", &text[place.clone()]));
    }
    for (kind, place) in declared.iter().filter(|one| !wanted.contains(one)) {
        say(place.start, &format!("there is no {kind} {}", &text[place.clone()]));
    }
    let mut wanted: Vec<_> = unit.codes.iter().map(|(code, _)| code.span.start..code.span.end).collect();
    wanted.retain(|place| !place.is_empty());
    wanted.sort_by_key(|place| place.start);
    if let Some((wanted, _)) = wanted.iter().zip(&codes(&tree)).find(|(wanted, found)| wanted != found) {
        say(wanted.start, "code begins or ends elsewhere");
    }
    let comments: Vec<_> =
        nodes(&tree).iter().filter(|node| node.kind().ends_with("_comment")).map(Node::byte_range).collect();
    if let Some((wanted, _)) = unit.comments.iter().zip(&comments).find(|(wanted, found)| wanted != found) {
        say(wanted.start, "a comment begins or ends elsewhere");
    }
    Some(all)
}

fn check(programs: &[PathBuf]) -> usize {
    let all: Vec<Vec<String>> = programs.iter().filter_map(|path| differences(path)).collect();
    let differences: Vec<_> = all.iter().flatten().map(String::as_str).collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    all.len()
}

#[test]
fn programs_have_the_declarations_code_and_comments_that_the_compiler_finds() {
    let accepted = check(&programs(repository()));
    assert!(accepted > 300, "{accepted} programs are not those of this repository");
}

/// `LF_PROGRAMS=/clone/of/lf/test cargo test -p tree-sitter-lf further` also checks the programs of LF's own tests.
#[test]
fn further_programs_too() {
    let Some(folder) = env::var_os(FOLDER) else { return };
    let all = programs(Path::new(&folder));
    assert!(!all.is_empty(), "LF_PROGRAMS names a folder without programs");
    println!("{} of {} programs are accepted, and read alike", check(&all), all.len());
}
