// SPDX-License-Identifier: Apache-2.0
//! The supported part of LF, for the documents.

use super::unsupported::Feature;
use super::{attributes, properties};

/// The supported and the refused parts of LF, for the documents. All texts are Markdown.
#[derive(Clone, Debug)]
pub struct Supported {
    /// Parts of the language that are refused, each with the alternative.
    pub refused: Vec<(String, &'static str)>,
    /// Target properties that are supported.
    pub properties: &'static [properties::TargetProperty],
    /// Target properties that are refused, each with the alternative.
    pub refused_properties: &'static [(&'static str, &'static str)],
    /// Attributes that have an effect, or that diagrams use, by their names without `@`.
    pub attributes: Vec<&'static str>,
    /// Target properties without an effect, each with the reason.
    pub idle_properties: &'static [(&'static str, &'static str)],
}

/// Returns the supported part of LF, from the tables by which the compiler checks programs.
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
        attributes: attributes::honoured().collect(),
        idle_properties: properties::IDLE,
    }
}
