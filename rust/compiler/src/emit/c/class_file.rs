// SPDX-License-Identifier: Apache-2.0
//! The file of a reactor class in the making.

use super::symbols::Symbols;
use super::text::Text;
use super::types::CType;
use crate::plan::{ClassIndex, ReactorClass, Type};

/// A class of which a file is made.
pub(super) struct ClassFile<'p, 's> {
    pub(super) symbols: &'s Symbols<'p>,
    pub(super) index: ClassIndex,
    pub(super) class: &'p ReactorClass,
    /// What all its names begin with.
    pub(super) name: &'s str,
    /// What the names of its types begin with.
    pub(super) types: &'s str,
    pub(super) text: Text<'p>,
}

impl ClassFile<'_, '_> {
    /// What stands before a function that is called from elsewhere.
    pub(super) fn linkage(&self) -> &'static str {
        if self.symbols.view.native.is_cpp { "extern \"C\" " } else { "" }
    }

    /// A type in this class.
    pub(super) fn ty(&self, ty: &Type) -> CType {
        CType::new(self.class, ty)
    }
}
