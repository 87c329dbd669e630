// SPDX-License-Identifier: Apache-2.0
//! The headers through which a program's own files see reactors: for functions that are the bodies of reactions.
//!
//! They are at `include/FILE/Reactor.h`, with the names of LF's C target: `reactor_self_t`, `reactor_port_t`.

use core::fmt::Write as _;

use super::structs::{PORT, files, self_struct, value_struct};
use super::symbols::preamble_headers;
use super::text::{Text, name_of, stem};
use crate::emit::File;
use crate::emit::view::View;
use crate::plan::{ChildPort, ClassIndex, Reaction, ReactionParameter, ReactorClass, VariableKind};

/// Returns whether headers may be necessary: some function is the body of a reaction, or there are sources of C beside
/// the program, which may know its reactors.
pub(super) fn are_needed(view: &View<'_>) -> bool {
    let mut reactions = view.plan.classes.iter().flat_map(|class| &class.reactions);
    !view.native.cmake.is_empty() || reactions.any(|reaction| reaction.external)
}

/// Returns the headers of all reactors. A C file is compiled for each federate, whatever reactors that has.
pub(super) fn emit(view: &View<'_>, folder: &str) -> Vec<File> {
    let count = if are_needed(view) { view.plan.classes.len() } else { 0 };
    let own = (0..count).map(ClassIndex).filter(|class| view.is_own(*class));
    let headers = own.map(|class| header(view, class, folder));
    // Compilers look for a folder before they go up from it.
    let place =
        File { path: format!("{folder}/{PLACE}/README.md"), text: "`../../../include` begins here.\n".to_owned() };
    headers.chain((count > 0).then_some(place)).collect()
}

/// The include folders of a crate: code includes headers without a folder, by `"include/…"`, by `"../include/…"`, and
/// by longer forms of that. LF's compiler has generated files in `src-gen/PROGRAM`, deeper for programs in folders, and
/// `include` beside `src-gen`.
pub(super) const FOLDERS: [&str; 5] = ["include", ".", "src-gen", "src-gen/program", PLACE];

/// The deepest of these folders.
const PLACE: &str = "src-gen/program/nested";

/// Returns the path of a class's header in a crate.
pub(super) fn path(view: &View<'_>, class: &ReactorClass) -> String {
    let file = name_of(view.plan.path(class.at));
    format!("include/{}/{}{}.h", stem(file), base_name(class), type_arguments(class))
}

/// Returns the type of an instance.
pub(super) fn self_type(class: &ReactorClass) -> String {
    format!("{}_self_t", own_prefix(class))
}

/// Returns the type of a reaction's variable that is a port, without the `*` for the indirections between it and the
/// reaction.
pub(super) fn port_type(
    view: &View<'_>,
    class: &ReactorClass,
    parameter: &ReactionParameter,
) -> Option<(String, usize)> {
    let stars = match &parameter.kind {
        VariableKind::Port { .. } => 1,
        VariableKind::Multiport { .. } => match &parameter.child {
            Some(ChildPort { is_bank: true, is_wide: true, .. }) => 3,
            _ => 2,
        },
        _ => return None,
    };
    let name = match &parameter.child {
        Some(ChildPort { child, port, .. }) => {
            let child = class.children.iter().find(|known| known.name == *child)?;
            format!("{}_{port}_t", child_prefix(view.class(child.class)))
        }
        None => format!("{}_{}_t", own_prefix(class), parameter.name),
    };
    Some((name, stars))
}

/// Returns the name in LF, without type arguments.
fn base_name(class: &ReactorClass) -> &str {
    class.name.split('<').next().unwrap_or(&class.name).trim()
}

/// Returns the prefix of a class's types in its own header, and in that of a reactor that contains it.
fn own_prefix(class: &ReactorClass) -> String {
    child_prefix(class).to_lowercase()
}

fn child_prefix(class: &ReactorClass) -> String {
    base_name(class).to_lowercase() + &type_arguments(class)
}

/// Returns a suffix for type arguments, which distinguishes reactors of one declaration: their letters and digits, and
/// a number for all other characters.
fn type_arguments(class: &ReactorClass) -> String {
    let (mut text, mut rest) = (String::new(), 0_i32);
    for (_, ty) in &class.types {
        text.push('_');
        for (index, character) in (0_i32..).zip(ty.text.chars()) {
            if character.is_alphanumeric() {
                text.push(character);
            } else {
                rest = rest.wrapping_mul(31).wrapping_add(index);
                rest = rest.wrapping_mul(31).wrapping_add(u32::from(character).cast_signed());
            }
        }
    }
    if rest != 0 {
        // Writing to a String cannot fail.
        let _ = write!(text, "_{rest:x}");
    }
    text
}

fn header(view: &View<'_>, index: ClassIndex, folder: &str) -> File {
    let class = view.class(index);
    let about = format!("Reactor `{}`, as functions see it that are bodies of reactions.", class.name);
    let mut text = Text::new(view, format!("{folder}/{}", path(view, class)), &about);
    text.line("#pragma once\n#include <lf.h>");
    let preambles = preamble_headers(view.plan);
    for file in files(view, class) {
        text.line(format_args!("#include \"../../c/{}.h\"", preambles[file.0]));
    }
    for (name, ty) in &class.types {
        text.line(format_args!("#undef {name}\n#define {name} {}", ty.text));
    }
    text.line("");
    self_struct(&mut text, class, &self_type(class));
    for port in &class.ports {
        let name = format!("{}_{}_t", own_prefix(class), port.name);
        once(&mut text, index, &name, |text| value_struct(text, PORT, class, &port.ty, &name));
    }
    for child in &class.children {
        let target = view.class(child.class);
        for port in &target.ports {
            let name = format!("{}_{}_t", child_prefix(target), port.name);
            once(&mut text, child.class, &name, |text| value_struct(text, PORT, target, &port.ty, &name));
        }
    }
    for reaction in class.reactions.iter().filter(|reaction| reaction.external) {
        let signature = reaction.signature.replace("*/", "* /");
        text.line(format_args!("\n/* `{signature}`, line {}. */", reaction.at.line));
        text.line(declaration(view, class, reaction));
    }
    text.file()
}

/// Emits a type that occurs in several headers.
fn once(text: &mut Text<'_>, class: ClassIndex, name: &str, emit: impl FnOnce(&mut Text<'_>)) {
    let guard = format!("LF_{}_{name}_", class.0);
    text.line(format_args!("#ifndef {guard}\n#define {guard}"));
    emit(text);
    text.line("#endif");
}

/// Returns the declaration of the function that is the body of a reaction.
fn declaration(view: &View<'_>, class: &ReactorClass, reaction: &Reaction) -> String {
    let mut text = format!("void {}({} *self", reaction.name.as_deref().unwrap_or_default(), self_type(class));
    for parameter in &reaction.parameters {
        if let Some((ty, stars)) = port_type(view, class, parameter) {
            let name = parameter.name.replace('.', "_");
            let _ = write!(text, ", {ty} {}{name}", "*".repeat(stars));
        }
    }
    text + ");"
}
