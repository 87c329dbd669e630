// SPDX-License-Identifier: Apache-2.0
//! Attributes of the main reactor that are target properties: LF has both forms.

use crate::syntax::ast::{
    Attribute, Expression, ExpressionKind, Literal, Name, Property, PropertyKind, PropertyValue, Reactor, ReactorKind,
};

/// The attributes, each with its property.
pub(super) const ATTRIBUTES: [(&str, &str); 7] = [
    ("build_type", "build-type"),
    ("clock_sync", "clock-sync"),
    ("fast", "fast"),
    ("keepalive", "keepalive"),
    ("logging", "logging"),
    ("platform", "platform"),
    ("timeout", "timeout"),
];

/// Returns the properties that the attributes of the main reactor among these stand for.
pub(super) fn properties(reactors: &[Reactor]) -> Vec<Property> {
    let mut mains = reactors.iter().filter(|reactor| reactor.kind != ReactorKind::Plain);
    mains.next().into_iter().flat_map(|main| &main.attributes).filter_map(property).collect()
}

/// Returns whether an attribute of a main reactor is read as a property.
pub(super) fn is_property(attribute: &Attribute) -> bool {
    property(attribute).is_some()
}

fn property(attribute: &Attribute) -> Option<Property> {
    let (_, name) = ATTRIBUTES.iter().find(|(name, _)| *name == attribute.name.text)?;
    let value = match attribute.single_value() {
        Some(value) => value_of(value),
        // The other arguments are for the clocks of another runtime.
        None if *name == "clock-sync" => match attribute.parameters.iter().find(|it| is_named(it.name.as_ref())) {
            Some(disabled) => off_if(disabled.value.as_ref()?),
            None => return None,
        },
        None => PropertyValue { kind: PropertyKind::List(Vec::new()), span: attribute.span },
    };
    Some(Property { key: Name { text: (*name).to_owned(), span: attribute.name.span }, value })
}

fn is_named(name: Option<&Name>) -> bool {
    name.is_some_and(|name| name.text == "disabled")
}

fn off_if(value: &Expression) -> PropertyValue {
    let is_off = matches!(value.kind, ExpressionKind::Literal(Literal::Bool(true)));
    PropertyValue { kind: PropertyKind::Path(if is_off { "off" } else { "on" }.to_owned()), span: value.span }
}

/// Returns the value of a property that is written as an expression.
fn value_of(value: &Expression) -> PropertyValue {
    let kind = match &value.kind {
        ExpressionKind::Literal(literal) => PropertyKind::Literal(literal.clone()),
        ExpressionKind::Time(time) => PropertyKind::Time(time.clone()),
        ExpressionKind::Name(name) => PropertyKind::Path(name.clone()),
        ExpressionKind::List(list) => PropertyKind::List(list.iter().map(value_of).collect()),
        // The reader of the property reports that it is no value of it.
        ExpressionKind::Code(_) => PropertyKind::List(Vec::new()),
    };
    PropertyValue { kind, span: value.span }
}
