// SPDX-License-Identifier: Apache-2.0
//! The structs of a reactor, and the types that they depend on.

use std::collections::BTreeSet;

use super::types::CType;
use crate::emit::view::View;
use crate::plan::{BANK_INDEX, FileIndex, Plan, PortDeclaration, ReactorClass};

/// Returns whether a reactor declares a name that bodies use as `self->bank_index`.
pub(super) fn declares_bank_index(class: &ReactorClass) -> bool {
    let is_parameter = class.parameters.iter().any(|parameter| parameter.name == BANK_INDEX);
    is_parameter || class.has_state(BANK_INDEX)
}

/// Returns the struct of the state and the parameters of an instance.
pub(super) fn self_struct(class: &ReactorClass, name: &str) -> String {
    let mut fields = vec!["lf_self_base_t base".to_owned()];
    if !declares_bank_index(class) {
        fields.push("int bank_index".to_owned());
    }
    // State hides a parameter of the same name.
    for parameter in class.parameters.iter().filter(|parameter| !class.has_state(&parameter.name)) {
        fields.push(CType::new(class, &parameter.ty).declare(&parameter.name));
    }
    fields.extend(class.state.iter().map(|state| CType::new(class, &state.ty).declare(&state.name)));
    format!("typedef struct {{\n    {};\n}} {name};", fields.join(";\n    "))
}

/// Returns the struct of a port.
pub(super) fn port_struct(class: &ReactorClass, port: &PortDeclaration, name: &str) -> String {
    format!("typedef struct {{ LF_PORT_BASE;{} }} {name};", field(&CType::new(class, &port.ty)))
}

/// Returns the field for the value, if there is one.
pub(super) fn field(ty: &CType) -> String {
    if ty.is_nothing() { String::new() } else { format!(" {};", ty.declare("value")) }
}

/// Returns the files whose preambles a class sees: the imports of a file before the file itself.
pub(super) fn files(view: &View<'_>, class: &ReactorClass) -> Vec<FileIndex> {
    fn add(plan: &Plan, file: FileIndex, seen: &mut BTreeSet<FileIndex>, files: &mut Vec<FileIndex>) {
        if seen.insert(file) {
            plan.files[file.0].imports.iter().for_each(|import| add(plan, *import, seen, files));
            files.push(file);
        }
    }
    // A class also sees the declarations behind the ports of contained reactors.
    let contained = class.children.iter().map(|child| view.class(child.class)).chain([class]);
    let (mut seen, mut files) = (BTreeSet::new(), Vec::new());
    for class in contained {
        class.files.iter().chain([&class.at.file]).for_each(|file| add(view.plan, *file, &mut seen, &mut files));
    }
    files
}
