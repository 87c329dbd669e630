// SPDX-License-Identifier: Apache-2.0
//! The differences of bodies that are compiled as C++: names of files, and values that are no bytes.

use crate::emit::view::View;

/// Returns the extension of files with code of the program.
pub(super) fn extension(view: &View<'_>) -> &'static str {
    if view.native.is_cpp { "cpp" } else { "c" }
}

/// Returns a declaration that the compiler refuses unless values of a type can be copied as bytes.
pub(super) fn as_bytes(ty: &str, what: &str) -> String {
    format!(
        "static_assert(__is_trivially_copyable({ty}), \"{what} are copied as bytes, which those of a class with a \
         copy constructor of its own cannot be: use a pointer\");"
    )
}
