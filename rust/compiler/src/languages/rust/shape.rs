// SPDX-License-Identifier: Apache-2.0
//! The layouts of Rust's types in messages, as far as their text and the preambles show.

use syn::{Expr, ExprLit, Fields, GenericArgument, Item, Lit, Type, TypePath};

use super::declared::{Declarations, TypeDeclaration, derives};
use super::sendable::{Growing, arguments, growing, text};
use crate::languages::facts::{Preambles, Unsendable};
use crate::plan::Shape;

/// Types whose values all have the same number of bytes.
const KNOWN: [(&str, Shape); 15] = [
    ("bool", Shape::Bool),
    ("char", Shape::Unsigned(4)),
    ("u8", Shape::Unsigned(1)),
    ("u16", Shape::Unsigned(2)),
    ("u32", Shape::Unsigned(4)),
    ("u64", Shape::Unsigned(8)),
    ("i8", Shape::Signed(1)),
    ("i16", Shape::Signed(2)),
    ("i32", Shape::Signed(4)),
    ("i64", Shape::Signed(8)),
    ("f32", Shape::Float(4)),
    ("f64", Shape::Float(8)),
    ("Duration", Shape::Signed(8)),
    ("Instant", Shape::Signed(8)),
    ("Interval", Shape::Signed(8)),
];

/// The maximum nesting of declarations.
const DEPTH_MAX: usize = 32;

/// Returns the layout of a type's values in messages.
pub(super) fn shape(ty: &str, preambles: Preambles<'_>) -> Result<Shape, Vec<Unsendable>> {
    let refused = |reason: &str, hint: &str| Unsendable {
        message: format!("another language cannot read `{ty}`: {reason}"),
        hint: hint.to_owned(),
        place: None,
    };
    let parsed: Type = syn::parse_str(ty).map_err(|error| vec![refused(&error.to_string(), "write a type of Rust")])?;
    let reader = ShapeReader { declarations: Declarations::of(preambles) };
    let look = |ty: &Type| {
        let shape = reader.shape(ty, 0);
        shape.map_err(|all| all.into_iter().map(|(reason, hint)| refused(&reason, hint)).collect::<Vec<_>>())
    };
    match growing(&parsed) {
        Some(Growing::Text) => Ok(Shape::Text),
        Some(Growing::List(element)) => Ok(Shape::List(Box::new(look(element)?))),
        None => match bounded(&parsed) {
            Some(Growing::Text) => Ok(Shape::Text),
            Some(Growing::List(element)) => Ok(Shape::List(Box::new(look(element)?))),
            None => look(&parsed),
        },
    }
}

/// Returns a list or a text of heapless.
fn bounded(ty: &Type) -> Option<Growing<'_>> {
    let Type::Path(path) = ty else { return None };
    let name = path.path.segments.last()?.ident.to_string();
    match (name.as_str(), &arguments(path)[..]) {
        ("String", [_]) => Some(Growing::Text),
        ("Vec", [GenericArgument::Type(element), _]) => Some(Growing::List(element)),
        _ => None,
    }
}

/// All reasons why a type has no layout that other languages know, each with the replacement.
type NoShape = Vec<(String, &'static str)>;

struct ShapeReader {
    declarations: Declarations,
}

impl ShapeReader {
    fn shape(&self, ty: &Type, depth: usize) -> Result<Shape, NoShape> {
        let why = |reason: &str, hint| Err(vec![(format!("{} {reason}", named(ty)), hint)]);
        match ty {
            _ if depth > DEPTH_MAX => why("contains itself", "send something smaller"),
            Type::Paren(paren) => self.shape(&paren.elem, depth),
            Type::Group(group) => self.shape(&group.elem, depth),
            Type::Tuple(tuple) if tuple.elems.is_empty() => Ok(Shape::Nothing),
            Type::Tuple(_) => {
                why("is a tuple, whose parts have no names", "declare a struct with `#[derive(Payload)]`")
            }
            Type::Array(array) => match &array.len {
                Expr::Lit(ExprLit { lit: Lit::Int(length), .. }) => {
                    let length = length.base10_parse().unwrap_or(u64::MAX);
                    Ok(Shape::Array(Box::new(self.shape(&array.elem, depth + 1)?), length))
                }
                _ => why("has a length that is known to Rust only", "write a number as the length"),
            },
            Type::Path(path) => self.path(path, ty, depth),
            _ => why("has no such counterpart", "declare a struct with `#[derive(Payload)]`"),
        }
    }

    fn path(&self, path: &TypePath, ty: &Type, depth: usize) -> Result<Shape, NoShape> {
        let why = |reason: &str, hint| Err(vec![(format!("{} {reason}", named(ty)), hint)]);
        let Some(last) = path.path.segments.last() else { return why("has no name", "write a type") };
        let name = last.ident.to_string();
        if path.path.get_ident().is_some()
            && let Some(declared) = self.declarations.find(&name)
        {
            return self.declared(&declared, ty, depth);
        }
        if let Some((_, shape)) = KNOWN.iter().find(|(known, _)| *known == name) {
            return Ok(shape.clone());
        }
        match (name.as_str(), &arguments(path)[..]) {
            ("Option", [GenericArgument::Type(inner)]) => {
                let value = self.shape(inner, depth + 1)?;
                Ok(Shape::Struct(vec![("is_some".to_owned(), Shape::Bool), ("value".to_owned(), value)]))
            }
            ("Vec" | "String", _) => {
                why("is not the whole of the message", "send it by a port of its own, or write an array")
            }
            _ => why("is declared nowhere in the preambles", "declare a struct with `#[derive(Payload)]` there"),
        }
    }

    fn declared(&self, declared: &TypeDeclaration<'_>, ty: &Type, depth: usize) -> Result<Shape, NoShape> {
        const DERIVE: &str = "write `#[derive(Payload)]` before its declaration";
        let why = |reason: &str, hint| Err(vec![(format!("{} {reason}", named(ty)), hint)]);
        let derived = |attributes| derives(attributes).is_some_and(|all| all.iter().any(|one| one == "Payload"));
        match declared.item {
            Item::Type(alias) if alias.generics.params.is_empty() => self.shape(&alias.ty, depth + 1),
            Item::Struct(item) if !derived(&item.attrs) => why("has a layout of its own", DERIVE),
            Item::Enum(item) if !derived(&item.attrs) => why("has a layout of its own", DERIVE),
            Item::Struct(item) => match &item.fields {
                Fields::Named(fields) => {
                    let (mut shapes, mut wrong) = (Vec::new(), Vec::new());
                    for field in &fields.named {
                        let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
                        let at = |(reason, hint)| (format!("in field `{name}` of {}, {reason}", named(ty)), hint);
                        match self.shape(&field.ty, depth + 1) {
                            Ok(shape) => shapes.push((name, shape)),
                            Err(all) => wrong.extend(all.into_iter().map(at)),
                        }
                    }
                    if wrong.is_empty() { Ok(Shape::Struct(shapes)) } else { Err(wrong) }
                }
                _ => why("has fields without names", "give them names"),
            },
            Item::Enum(item) if item.variants.iter().all(|variant| variant.fields.is_empty()) => {
                Ok(integer_of(&item.attrs))
            }
            _ => why("has variants with fields", "send a struct with a number and what belongs to it"),
        }
    }
}

/// Returns the integer type of an enum without fields.
fn integer_of(attributes: &[syn::Attribute]) -> Shape {
    let mut found = Shape::Signed(4);
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("repr")) {
        // rustc reports a name that is no integer type.
        let _ = attribute.parse_nested_meta(|meta| {
            let known = KNOWN.iter().find(|(name, _)| meta.path.is_ident(name));
            if let Some((_, shape @ (Shape::Unsigned(_) | Shape::Signed(_)))) = known {
                found = shape.clone();
            }
            Ok(())
        });
    }
    found
}

fn named(ty: &Type) -> String {
    format!("`{}`", text(ty))
}

#[cfg(test)]
mod tests {
    use super::shape;
    use crate::languages::facts::Preambles;
    use crate::plan::Shape::{self, Array, Bool, Float, List, Nothing, Signed, Struct, Text, Unsigned};

    const PREAMBLE: &str = "
        #[derive(Clone, Payload)] pub struct Point { pub x: f64, pub kind: Kind, pub more: [u16; 2] }
        #[derive(Clone, Payload)] #[repr(u8)] pub enum Kind { A, B }
        #[derive(Clone, Payload)] pub enum State { On, Off }
        #[derive(Clone, Payload)] pub enum Rich { On(u8), Off }
        #[derive(Clone, Payload)] pub struct Pair(u8, u8);
        pub struct Own { x: u8 }
        type Alias = [Point; 2];
    ";

    fn of(ty: &str) -> Option<Shape> {
        let preambles = [PREAMBLE.to_owned()];
        shape(ty, Preambles { visible: &preambles, all: &preambles }).ok()
    }

    #[test]
    fn types_of_preambles_have_the_shape_of_c() {
        let field = |name: &str, shape| (name.to_owned(), shape);
        let more = Array(Box::new(Unsigned(2)), 2);
        let point = Struct(vec![field("x", Float(8)), field("kind", Unsigned(1)), field("more", more)]);
        assert_eq!(of("Point"), Some(point.clone()));
        assert_eq!(of("Alias"), Some(Array(Box::new(point.clone()), 2)));
        assert_eq!(of("heapless::Vec<Point, 4>"), Some(List(Box::new(point))));
        assert_eq!(of("State"), Some(Signed(4)));
        assert_eq!(of("Option<i16>"), Some(Struct(vec![field("is_some", Bool), field("value", Signed(2))])));
    }

    #[test]
    fn lists_and_texts_are_whole_messages() {
        assert_eq!((of("String"), of("heapless::String<8>")), (Some(Text), Some(Text)));
        assert_eq!(of("Vec<u8>"), Some(List(Box::new(Unsigned(1)))));
        assert_eq!((of("()"), of("core::time::Duration")), (Some(Nothing), Some(Signed(8))));
        assert_eq!(of("[heapless::String<8>; 2]"), None);
    }

    #[test]
    fn types_that_other_languages_cannot_know_are_refused() {
        for ty in ["(u8, u8)", "Pair", "Own", "Rich", "Elsewhere", "usize", "[u8; N]", "&str"] {
            assert_eq!(of(ty), None, "{ty}");
        }
    }
}
