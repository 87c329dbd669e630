// SPDX-License-Identifier: Apache-2.0
//! What differs where bodies are compiled as C++: names of files, names that cannot be, and values that are no bytes.

use crate::emit::EmitError;
use crate::plan::{Location, Plan, ReactorClass};

/// Words of C++ that are none of C.
const KEYWORDS: &[&str] = &[
    "and",
    "and_eq",
    "asm",
    "bitand",
    "bitor",
    "catch",
    "char8_t",
    "char16_t",
    "char32_t",
    "class",
    "co_await",
    "co_return",
    "co_yield",
    "compl",
    "concept",
    "const_cast",
    "consteval",
    "constinit",
    "decltype",
    "delete",
    "dynamic_cast",
    "explicit",
    "export",
    "friend",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "not",
    "not_eq",
    "operator",
    "or",
    "or_eq",
    "private",
    "protected",
    "public",
    "reinterpret_cast",
    "requires",
    "static_cast",
    "template",
    "this",
    "throw",
    "try",
    "typeid",
    "typename",
    "using",
    "virtual",
    "wchar_t",
    "xor",
    "xor_eq",
];

/// What the names of files end with that have code of the program.
pub(super) fn extension(plan: &Plan) -> &'static str {
    if plan.target.c.is_cpp { "cpp" } else { "c" }
}

/// A declaration that the compiler refuses unless values of a type can be copied as bytes.
pub(super) fn as_bytes(ty: &str, what: &str) -> String {
    format!(
        "static_assert(__is_trivially_copyable({ty}), \"{what} are copied as bytes, which those of a class with a \
         copy constructor of its own cannot be: use a pointer\");"
    )
}

/// Refuses names of a reactor that C++ keeps for itself.
pub(super) fn check(plan: &Plan, class: &ReactorClass) -> Result<(), EmitError> {
    if !plan.target.c.is_cpp {
        return Ok(());
    }
    match names(class).find(|(name, _)| KEYWORDS.contains(name)) {
        Some((name, at)) => {
            let message = format!("nothing can be called `{name}` here: it is a word of C++");
            Err(EmitError::new(plan, at, message))
        }
        None => Ok(()),
    }
}

/// All names of a reactor that code has, with where they are declared.
fn names(class: &ReactorClass) -> impl Iterator<Item = (&str, Location)> {
    let parameters = class.parameters.iter().map(|one| (one.name.as_str(), one.at));
    let state = class.state.iter().map(|one| (one.name.as_str(), one.at));
    let ports = class.ports.iter().map(|one| (one.name.as_str(), one.at));
    let actions = class.actions.iter().map(|one| (one.name.as_str(), one.at));
    let timers = class.timers.iter().chain(&class.watchdogs).map(|one| (one.name.as_str(), one.at));
    let children = class.children.iter().map(|one| (one.name.as_str(), one.at));
    let methods = class.methods.iter().map(|one| (one.name.as_str(), one.at));
    let functions = class.reactions.iter().filter_map(|one| Some((one.name.as_deref()?, one.at)));
    parameters.chain(state).chain(ports).chain(actions).chain(timers).chain(children).chain(methods).chain(functions)
}
