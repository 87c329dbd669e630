// SPDX-License-Identifier: Apache-2.0
//! The layouts of C's types in messages, as far as they are known without a compiler.

use super::types::{INTERVAL, VOID, spelled};
use crate::languages::facts::Unsendable;
use crate::plan::Shape;

/// C's types whose sizes are the same everywhere.
const KNOWN: [(&str, Shape); 33] = [
    (VOID, Shape::Nothing),
    ("bool", Shape::Bool),
    ("_Bool", Shape::Bool),
    ("char", Shape::Byte),
    ("signed char", Shape::Signed(1)),
    ("unsigned char", Shape::Unsigned(1)),
    ("int8_t", Shape::Signed(1)),
    ("uint8_t", Shape::Unsigned(1)),
    ("short", Shape::Signed(2)),
    ("short int", Shape::Signed(2)),
    ("unsigned short", Shape::Unsigned(2)),
    ("unsigned short int", Shape::Unsigned(2)),
    ("int16_t", Shape::Signed(2)),
    ("uint16_t", Shape::Unsigned(2)),
    ("int", Shape::Signed(4)),
    ("signed", Shape::Signed(4)),
    ("signed int", Shape::Signed(4)),
    ("unsigned", Shape::Unsigned(4)),
    ("unsigned int", Shape::Unsigned(4)),
    ("int32_t", Shape::Signed(4)),
    ("uint32_t", Shape::Unsigned(4)),
    ("char32_t", Shape::Unsigned(4)),
    ("long long", Shape::Signed(8)),
    ("long long int", Shape::Signed(8)),
    ("unsigned long long", Shape::Unsigned(8)),
    ("unsigned long long int", Shape::Unsigned(8)),
    ("int64_t", Shape::Signed(8)),
    ("uint64_t", Shape::Unsigned(8)),
    (INTERVAL, Shape::Signed(8)),
    ("instant_t", Shape::Signed(8)),
    ("float", Shape::Float(4)),
    ("double", Shape::Float(8)),
    ("string", Shape::Text),
];

/// Types whose sizes vary, and their replacements.
const VARYING: [(&str, &str); 12] = [
    ("long", "int64_t"),
    ("long int", "int64_t"),
    ("unsigned long", "uint64_t"),
    ("unsigned long int", "uint64_t"),
    ("size_t", "uint32_t"),
    ("ssize_t", "int32_t"),
    ("intptr_t", "int64_t"),
    ("uintptr_t", "uint64_t"),
    ("intmax_t", "int64_t"),
    ("uintmax_t", "uint64_t"),
    ("ptrdiff_t", "int64_t"),
    ("long double", "double"),
];

/// Returns the layout of a type's values in messages.
pub(super) fn shape(ty: &str) -> Result<Shape, Unsendable> {
    let ty = spelled(ty.trim().trim_start_matches("const ").trim());
    let ty = ty.as_str();
    if let Some((_, instead)) = VARYING.iter().find(|(name, _)| *name == ty) {
        let message = format!("`{ty}` has not the same size everywhere, so another language cannot read it");
        let hint = format!("write `{instead}` at both ends, by their languages' names");
        return Err(Unsendable { message, hint, place: None });
    }
    if let Some((_, shape)) = KNOWN.iter().find(|(name, _)| *name == ty) {
        return Ok(shape.clone());
    }
    if ty == "char*" {
        return Ok(Shape::Text);
    }
    if let Some(element) = ty.strip_suffix('*').or_else(|| ty.strip_suffix("[]")) {
        return Ok(Shape::List(Box::new(shape(element)?)));
    }
    let array = ty.strip_suffix(']').and_then(|rest| rest.split_once('['));
    match array.map(|(element, length)| (element, length.parse())) {
        Some((element, Ok(length))) => Ok(Shape::Array(Box::new(shape(element)?), length)),
        _ => Ok(Shape::Named(ty.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::shape;
    use crate::plan::Shape;

    #[test]
    fn shapes_are_known_without_a_compiler() {
        let list = |of| Shape::List(Box::new(of));
        assert_eq!(shape("unsigned int"), Ok(Shape::Unsigned(4)));
        assert_eq!(shape("int []"), Ok(list(Shape::Signed(4))));
        assert_eq!(shape("const char *"), Ok(Shape::Text));
        assert_eq!(shape("double[3]"), Ok(Shape::Array(Box::new(Shape::Float(8)), 3)));
        assert_eq!(shape("struct reading *"), Ok(list(Shape::Named("struct reading".to_owned()))));
        assert_eq!(shape("int[LENGTH]"), Ok(Shape::Named("int[LENGTH]".to_owned())));
        assert!(shape("long").is_err() && shape("size_t[]").is_err());
    }
}
