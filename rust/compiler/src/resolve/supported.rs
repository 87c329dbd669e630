// SPDX-License-Identifier: Apache-2.0
//! What of LF there is, for the documents.

use super::unsupported::Feature;
use super::{attributes, properties};

/// What of LF there is and what is refused by name, for the documents. All texts are Markdown.
#[derive(Clone, Debug)]
pub struct Supported {
    /// Parts of the language that are refused, each with what to do instead.
    pub refused: Vec<(String, &'static str)>,
    /// Target properties that are honoured.
    pub properties: &'static [properties::TargetProperty],
    /// Target properties that are refused, each with what to do instead.
    pub refused_properties: &'static [(&'static str, &'static str)],
}

/// What of LF there is, from the tables by which programs are judged.
pub fn supported() -> Supported {
    let attributes = attributes::UNSUPPORTED.iter().map(|(names, instead)| {
        let all: Vec<_> = names.iter().map(|name| format!("`@{name}`")).collect();
        (format!("the attribute{} {}", if all.len() > 1 { "s" } else { "" }, all.join(", ")), *instead)
    });
    let features = Feature::ALL.iter().map(|feature| (feature.name().to_owned(), feature.instead()));
    Supported {
        refused: features.chain(attributes).collect(),
        properties: properties::PROPERTIES,
        refused_properties: properties::REFUSED,
    }
}
