// SPDX-License-Identifier: Apache-2.0
//! A builder for the file of a reactor class.

use super::symbols::Symbols;
use super::text::Text;
use super::types::CType;
use crate::plan::{ClassIndex, ReactorClass, Type};

/// A class and its file.
pub(super) struct ClassFile<'p, 's> {
    pub(super) symbols: &'s Symbols<'p>,
    pub(super) index: ClassIndex,
    pub(super) class: &'p ReactorClass,
    /// The prefix of all its names.
    pub(super) name: &'s str,
    /// The prefix of its types' names.
    pub(super) types: &'s str,
    pub(super) text: Text<'p>,
}

impl ClassFile<'_, '_> {
    /// Returns the linkage of a function that other files call.
    pub(super) fn linkage(&self) -> &'static str {
        if self.symbols.view.native.is_cpp { "extern \"C\" " } else { "" }
    }

    /// Returns a type in this class.
    pub(super) fn ty(&self, ty: &Type) -> CType {
        CType::new(self.class, ty)
    }
}
