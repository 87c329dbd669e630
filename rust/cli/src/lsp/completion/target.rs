// SPDX-License-Identifier: Apache-2.0
//! Keys and values of target properties, from the compiler's own table.

use lf_compiler::plan::Language;
use lf_compiler::{PropertyScope, TargetProperty, supported};
use lsp_types::{CompletionItem, CompletionItemKind};

use super::items::{item, markdown};

fn properties(language: Language) -> impl Iterator<Item = &'static TargetProperty> {
    supported().properties.iter().filter(move |property| match property.scope {
        PropertyScope::Bodies(own) => own == language,
        PropertyScope::Coordination | PropertyScope::Program => true,
    })
}

/// Returns the keys at the end of a path of keys.
pub(super) fn keys(language: Language, path: &[String]) -> Vec<CompletionItem> {
    let key = |name: &str, property: &TargetProperty| CompletionItem {
        insert_text: Some(format!("{name}: ")),
        documentation: markdown(property.does),
        ..item(name, CompletionItemKind::PROPERTY, &property.values.join(", "))
    };
    match path {
        [] => properties(language).map(|property| key(property.name, property)).collect(),
        [name] => {
            let inner = properties(language).filter(|property| property.name == name);
            inner.flat_map(|property| examples(property).map(move |(name, _)| key(name, property))).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns the values of the key at the end of a path.
pub(super) fn values(language: Language, path: &[String]) -> Vec<CompletionItem> {
    let value = |text: &str, property: &TargetProperty| CompletionItem {
        documentation: markdown(property.does),
        ..item(text, CompletionItemKind::VALUE, "")
    };
    match path {
        [name] => {
            let own = properties(language).filter(|property| property.name == name);
            own.flat_map(|property| property.values.iter().map(move |text| value(text, property))).collect()
        }
        [name, inner] => {
            let own = properties(language).filter(|property| property.name == name);
            let all = own.flat_map(|property| examples(property).map(move |example| (example, property)));
            all.filter(|((key, _), _)| key == inner).map(|((_, text), property)| value(text, property)).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns the keys and values within the braces of a property's examples.
fn examples(property: &'static TargetProperty) -> impl Iterator<Item = (&'static str, &'static str)> {
    let braces = property.values.iter().filter_map(|value| value.strip_prefix('{')?.strip_suffix('}'));
    braces.flat_map(|inside| inside.split(", ")).filter_map(|pair| {
        let (key, value) = pair.split_once(':')?;
        Some((key.trim(), value.trim()))
    })
}
