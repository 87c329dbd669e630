// SPDX-License-Identifier: Apache-2.0
//! How values become bytes between federates, where a program says it.

use serde::{Deserialize, Serialize};

/// How the values of a connection become bytes, where their type alone does not say it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Serializer {
    /// The serializer, as the target language knows it; `None` for the layout of the type itself.
    pub name: Option<String>,
    /// The most bytes of a serialized value or of a text, or elements of a list; `None` where the type says it.
    pub max_length: Option<usize>,
}
