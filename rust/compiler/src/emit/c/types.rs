// SPDX-License-Identifier: Apache-2.0
//! Types of C as declarations, and the kinds of their values.

use crate::plan::{ReactorClass, Type};

/// The type without values.
const NOTHING: &str = "void";

/// A type in a class: with the arguments for its type parameters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CType(String);

impl CType {
    pub(super) fn new(class: &ReactorClass, ty: &Type) -> Self {
        let mut text = String::new();
        let mut rest = ty.text.trim();
        while !rest.is_empty() {
            let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            let (word, after) = rest.split_at(word.max(rest.chars().next().map_or(1, char::len_utf8)));
            let given = class.types.iter().find(|(name, _)| name == word);
            text.push_str(given.map_or(word, |(_, ty)| &ty.text));
            rest = after;
        }
        Self(text)
    }

    /// Returns the type as bodies spell it.
    pub(super) fn text(&self) -> &str {
        &self.0
    }

    /// Returns whether there are no values.
    pub(super) fn is_nothing(&self) -> bool {
        self.0 == NOTHING
    }

    /// Returns whether values are pointers to the contents of tokens.
    pub(super) fn is_token(&self) -> bool {
        self.0.ends_with('*') || self.0.ends_with("[]")
    }

    /// Returns whether values are texts, which end with a zero.
    pub(super) fn is_text(&self) -> bool {
        self.0 == "string"
    }

    /// Returns whether it is an array with a length.
    pub(super) fn is_array(&self) -> bool {
        self.0.ends_with(']') && !self.is_token()
    }

    /// Returns the type behind a pointer: the elements of a token.
    pub(super) fn element(&self) -> &str {
        self.0.strip_suffix("[]").or_else(|| self.0.strip_suffix('*')).unwrap_or(&self.0).trim_end()
    }

    /// Returns a declaration of this type, without a semicolon.
    pub(super) fn declare(&self, name: &str) -> String {
        if let Some(element) = self.0.strip_suffix("[]") {
            return format!("{} *{name}", element.trim_end());
        }
        match self.0.split_once('[').filter(|_| self.is_array()) {
            Some((element, length)) => format!("{} {name}[{length}", element.trim_end()),
            None => format!("{} {name}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_those_of_c() {
        let declared = |text: &str| CType(text.to_owned()).declare("x");
        assert_eq!(declared("int"), "int x");
        assert_eq!(declared("int[]"), "int *x");
        assert_eq!(declared("char*"), "char* x");
        assert_eq!(declared("int[3][4]"), "int x[3][4]");
        assert_eq!(CType("hello_t*".to_owned()).element(), "hello_t");
    }
}
