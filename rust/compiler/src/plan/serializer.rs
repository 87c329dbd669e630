// SPDX-License-Identifier: Apache-2.0
//! The serialization of values between federates, if a program sets it.

use serde::{Deserialize, Serialize};

/// The serialization of a connection's values, if their type alone does not determine it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Serializer {
    /// The serializer's name in the target language; `None` for the layout of the type itself.
    pub name: Option<String>,
    /// The maximum number of bytes of a serialized value or of a text, or of elements of a list; `None` if the type
    /// determines it.
    pub max_length: Option<usize>,
}
