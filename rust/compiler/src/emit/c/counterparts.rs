// SPDX-License-Identifier: Apache-2.0
//! `counterparts.c`, or `.cpp`: lets the compiler check that types match the assumptions of federates in other
//! languages.

use super::cpp::extension;
use super::symbols::preamble_headers;
use super::text::Text;
use super::types::CType;
use crate::emit::File;
use crate::emit::view::View;
use crate::plan::{Federate, Location, PortIndex, Shape, Type};

/// Returns the file, if the federate sends or receives a type that only the compiler knows.
pub(super) fn emit(view: &View<'_>, federate: &Federate, folder: &str) -> Option<File> {
    let outputs =
        federate.outputs.iter().map(|output| (Some(output.source), &output.ty, &output.counterpart, output.at));
    let inputs = federate.inputs.iter().map(|input| (federate.filled(input), &input.ty, &input.counterpart, input.at));
    let checked = outputs
        .chain(inputs)
        .filter_map(|(port, ty, shape, at)| Some((type_of(view, federate, port?, ty)?, shape.as_ref()?, at)));
    let mut done: Vec<(CType, &Shape)> = Vec::new();
    let mut text = Text::new(
        view,
        format!("{folder}/c/counterparts.{}", extension(view)),
        "The layouts of values at the other ends of connections.",
    );
    text.line("#include <stddef.h>\n#include <lf.h>");
    for header in preamble_headers(view.plan) {
        text.line(format_args!("#include \"{header}.h\""));
    }
    text.line(MACROS);
    for (ty, shape, at) in checked {
        if done.iter().any(|(known, same)| *known == ty && *same == shape) {
            continue;
        }
        let name = format!("lf_counterpart_{}", done.len());
        // The element of a list has a shape.
        let (declared, own) = match shape {
            Shape::List(element) => (format!("{} {name}", ty.element()), &**element),
            _ => (ty.declare(&name), shape),
        };
        text.line(format_args!("\ntypedef {declared};"));
        Check { text: &mut text, name: &name, ty: ty.element(), at, is_cpp: view.native.is_cpp }.value("", own, 0);
        done.push((ty, shape));
    }
    (!done.is_empty()).then(|| text.file())
}

fn type_of(view: &View<'_>, federate: &Federate, port: PortIndex, ty: &Type) -> Option<CType> {
    let (class, _) = federate.declared_port(port)?;
    Some(CType::new(view.class(class), ty))
}

/// The macros of the checks: a value of the type at null is never read.
const MACROS: &str = "\
#define LF_AT(type, field) (((type *)0)[0] field)
#define LF_TYPE(type, field) __typeof__(LF_AT(type, field))
#define LF_INTEGER(type, field) ((LF_TYPE(type, field))0.5 == 0)
#define LF_SIGNED(type, field) (LF_INTEGER(type, field) && (LF_TYPE(type, field))-1 < 1)
#define LF_UNSIGNED(type, field) (LF_INTEGER(type, field) && (LF_TYPE(type, field))-1 > 0)
#define LF_BOOL(type, field) ((LF_TYPE(type, field))0.5 == 1)
#define LF_FLOAT(type, field) ((LF_TYPE(type, field))0.5 > 0 && (LF_TYPE(type, field))0.5 < 1)";

/// A type to check.
struct Check<'t, 'p> {
    text: &'t mut Text<'p>,
    /// Its name in this file, and in the program.
    name: &'t str,
    ty: &'t str,
    at: Location,
    is_cpp: bool,
}

impl Check<'_, '_> {
    /// Checks the type itself or a part of it, whose path follows a value, like `.a.b`, and which begins at an offset.
    fn value(&mut self, field: &str, shape: &Shape, offset: u64) {
        let name = self.name;
        let kind = match shape {
            Shape::Bool => Some("BOOL"),
            Shape::Signed(1) | Shape::Unsigned(1) | Shape::Byte => Some("INTEGER"),
            Shape::Signed(_) => Some("SIGNED"),
            Shape::Unsigned(_) => Some("UNSIGNED"),
            Shape::Float(_) => Some("FLOAT"),
            _ => None,
        };
        if let Some(kind) = kind {
            self.assert(field, &format!("LF_{kind}({name}, {field})"), &format!("is {shape}"));
        }
        if let Some(size) = shape.size() {
            self.assert(field, &format!("sizeof(LF_AT({name}, {field})) == {size}"), &format!("takes {size} bytes"));
        }
        if !field.is_empty() && !field.ends_with(']') {
            let condition = format!("offsetof({name}, {}) == {offset}", field.trim_start_matches('.'));
            self.assert(field, &condition, &format!("begins at byte {offset}"));
        }
        match shape {
            Shape::Array(element, _) => self.value(&format!("{field}[0]"), element, offset),
            Shape::Struct(fields) => {
                for index in 0..fields.len() {
                    let begin = Shape::Struct(fields[..=index].to_vec()).offset_of_last().unwrap_or_default();
                    let (name, shape) = &fields[index];
                    self.value(&format!("{field}.{name}"), shape, offset + begin);
                }
            }
            _ => {}
        }
    }

    fn assert(&mut self, field: &str, condition: &str, what: &str) {
        let (ty, field) = (self.ty, field.trim_start_matches('.'));
        let part = if field.is_empty() { "it".to_owned() } else { format!("its `{field}`") };
        let message = format!("`{ty}` is not the type of the other end, where {part} {what}");
        let word = if self.is_cpp { "static_assert" } else { "_Static_assert" };
        self.text.place(self.at).line(format_args!("{word}({condition}, {message:?});"));
    }
}
