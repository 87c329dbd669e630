// SPDX-License-Identifier: Apache-2.0
//! The structs of a reactor, and the types that they depend on.

use std::collections::BTreeSet;

use super::text::Text;
use super::types::CType;
use crate::emit::view::View;
use crate::plan::{BANK_INDEX, FileIndex, Plan, ReactorClass, Type};

/// Returns whether a reactor declares a name that bodies use as `self->bank_index`.
pub(super) fn declares_bank_index(class: &ReactorClass) -> bool {
    let is_parameter = class.parameters.iter().any(|parameter| parameter.name == BANK_INDEX);
    is_parameter || class.has_state(BANK_INDEX)
}

/// Emits the struct of the state and the parameters of an instance.
pub(super) fn self_struct(text: &mut Text<'_>, class: &ReactorClass, name: &str) {
    text.line("typedef struct {\n    lf_self_base_t base;");
    if !declares_bank_index(class) {
        text.line("    int bank_index;");
    }
    // State hides a parameter of the same name.
    let parameters = class.parameters.iter().filter(|parameter| !class.has_state(&parameter.name));
    let parameters = parameters.map(|parameter| (&parameter.ty, &parameter.name));
    for (ty, field) in parameters.chain(class.state.iter().map(|state| (&state.ty, &state.name))) {
        text.typed(ty.at, format_args!("{};", CType::new(class, ty).declare(field)));
    }
    text.line(format_args!("}} {name};")).continues();
}

/// Emits the struct of a port or an action: what all have, and the value, if there is one.
pub(super) fn value_struct(text: &mut Text<'_>, base: &str, class: &ReactorClass, ty: &Type, name: &str) {
    let value = CType::new(class, ty);
    if value.is_nothing() {
        text.line(format_args!("typedef struct {{ {base}; }} {name};"));
        return;
    }
    text.line(format_args!("typedef struct {{ {base};"));
    text.typed(ty.at, format_args!("{};", value.declare("value")));
    text.line(format_args!("}} {name};")).continues();
}

/// The fields that all ports have, a macro.
pub(super) const PORT: &str = "LF_PORT_BASE";
/// The fields that all actions have, a macro.
pub(super) const ACTION: &str = "LF_ACTION_BASE";

/// Returns the files whose preambles a class sees: the imports of a file before the file itself. The files of contained
/// reactors are among the imports.
pub(super) fn files(view: &View<'_>, class: &ReactorClass) -> Vec<FileIndex> {
    fn add(plan: &Plan, file: FileIndex, seen: &mut BTreeSet<FileIndex>, files: &mut Vec<FileIndex>) {
        if seen.insert(file) {
            plan.files[file.0].imports.iter().for_each(|import| add(plan, *import, seen, files));
            files.push(file);
        }
    }
    let (mut seen, mut files) = (BTreeSet::new(), Vec::new());
    class.files.iter().chain([&class.at.file]).for_each(|file| add(view.plan, *file, &mut seen, &mut files));
    files
}
