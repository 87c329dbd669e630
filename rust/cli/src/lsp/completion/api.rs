// SPDX-License-Identifier: Apache-2.0
//! The words of bodies: the elements of their signatures, their reactor, and the API of their language.

use lf_compiler::NameKind;
use lf_compiler::plan::Language;
use lf_compiler::syntax::ast::{ReactionSyntax, Reactor, Reference};
use lsp_types::{CompletionItem, CompletionItemKind};

use super::items::{declared, item, markdown, of_kinds, ports_of, signature};
use crate::lsp::asked::Asked;

/// The methods of `ctx`, each with its arguments and what it does.
const CTX: &[(&str, &str, &str)] = &[
    ("get", "(x)", "Returns the value of a port or an action at this tag, `None` when it is absent."),
    ("get_ref", "(x)", "Returns the value as a reference, for types that are not `Copy`."),
    ("use_ref", "(x, |value| …)", "Calls a function with the value, or with `None`."),
    ("use_ref_opt", "(x, |value| …)", "Calls a function with the value if there is one."),
    ("is_present", "(x)", "Returns whether a port, an action, a watchdog or a timer has an event at this tag."),
    ("set", "(y, value)", "Sets a port at this tag; the last value counts."),
    ("set_opt", "(y, Some(value))", "Sets a port unless the value is `None`."),
    ("schedule", "(a, Asap)", "Schedules an action without a value."),
    ("schedule_with_v", "(a, Some(value), Asap)", "Schedules an action with a value."),
    ("start_watchdog", "(w, delay!(0))", "Starts a watchdog, or puts it off; the duration is added to its timeout."),
    ("stop_watchdog", "(w)", "Stops a watchdog."),
    ("set_mode", "(Mode)", "Changes to a mode of the signature at the next microstep."),
    ("request_stop", "(Asap)", "Asks the program to stop."),
    ("stop", "()", "Stops this federate alone, at the next microstep."),
    ("get_effective_start", "()", "Returns the first tag of this program, relative to the start."),
    ("get_federation_id", "()", "Returns the id of the federation."),
    ("get_tag", "()", "Returns the current tag, relative to the start."),
    ("get_elapsed_logical_time", "()", "Returns the logical time since the start."),
    ("get_elapsed_physical_time", "()", "Returns the physical time since the start."),
    ("get_logical_time", "()", "Returns the logical time."),
    ("get_physical_time", "()", "Returns the physical time."),
    ("get_start_time", "()", "Returns the time at which the program started."),
    ("get_intended_tag", "(x)", "Returns the tag that an input's value was meant for."),
    ("is_shutdown", "()", "Returns whether this is the last tag."),
    ("num_workers", "()", "Returns the number of threads that run reactions."),
    ("spawn_physical_thread", "(|link| { … })", "Runs a closure on a thread of its own."),
    ("schedule_physical", "(&a, Asap)", "Schedules a physical action as other threads do."),
    ("schedule_physical_with_v", "(&a, Some(value), Asap)", "Schedules a physical action with a value."),
    ("physical_link", "()", "Returns a link for threads that `spawn_physical_thread` does not start."),
];

/// Further words of bodies in Rust.
const RUST: &[(&str, &str)] = &[
    ("self", "the reactor: its parameters and state variables are fields"),
    ("ctx", "the context of the reaction"),
    ("Asap", "no further offset"),
    ("After", "a further offset: `After(duration)`"),
    ("delay!", "a duration: `delay!(10 ms)`"),
    ("after!", "an offset: `after!(10 ms)`"),
    ("tag!", "a tag: `tag!(T0 + 10 ms)`"),
    ("println!", "prints a line"),
    ("info!", "logs a line"),
    ("warn!", "logs a warning"),
    ("error!", "logs an error"),
];

/// Functions that bodies in C call.
const C: &[(&str, &str, &str)] = &[
    ("lf_set", "(y, value)", "Sets a port at this tag."),
    ("lf_set_present", "(y)", "Makes a port present without a value."),
    ("lf_set_array", "(y, elements, count)", "Sets a port to an array that a token counts."),
    ("lf_set_token", "(y, token)", "Sets a port to the value of a token."),
    ("lf_schedule", "(a, MSEC(0))", "Schedules an action without a value."),
    ("lf_schedule_int", "(a, MSEC(0), value)", "Schedules an action with an `int`."),
    ("lf_schedule_copy", "(a, MSEC(0), &value, 1)", "Schedules an action with a copy of values."),
    ("lf_schedule_value", "(a, MSEC(0), values, count)", "Schedules an action with an array."),
    ("lf_schedule_token", "(a, MSEC(0), token)", "Schedules an action with a token."),
    ("lf_time_logical", "()", "Returns the logical time."),
    ("lf_time_logical_elapsed", "()", "Returns the logical time since the start."),
    ("lf_time_physical", "()", "Returns the physical time."),
    ("lf_time_physical_elapsed", "()", "Returns the physical time since the start."),
    ("lf_time_start", "()", "Returns the time at which the program started."),
    ("lf_tag", "()", "Returns the current tag."),
    ("lf_request_stop", "()", "Asks the program to stop."),
    ("lf_stop", "()", "Stops this federate alone, at the next microstep."),
    ("lf_tag_start_effective", "()", "Returns the first tag of this program."),
    ("lf_get_federation_id", "()", "Returns the id of the federation."),
    ("lf_set_mode", "(Mode)", "Changes to a mode of the signature at the next microstep."),
    ("lf_check_deadline", "(self, true)", "Returns whether the deadline has passed."),
    ("lf_watchdog_start", "(w, 0)", "Starts a watchdog, or puts it off."),
    ("lf_watchdog_stop", "(w)", "Stops a watchdog."),
    ("lf_print", "(\"…\")", "Prints a line."),
    ("lf_print_warning", "(\"…\")", "Prints a warning."),
    ("lf_print_error", "(\"…\")", "Prints an error."),
    ("lf_sleep", "(MSEC(10))", "Waits for physical time."),
];

/// The fields of variables in C.
const C_FIELDS: &[(&str, &str)] = &[
    ("value", "the value at this tag"),
    ("is_present", "whether there is an event at this tag"),
    ("has_value", "whether the action has a value"),
    ("length", "the number of elements of an array"),
    ("token", "the token of an array"),
    ("intended_tag", "the tag that a late value was meant for"),
];

/// Returns what may stand in a body at the place.
pub(super) fn in_code(
    asked: &Asked<'_>,
    language: Language,
    reaction: Option<&ReactionSyntax>,
    reactor: Option<&Reactor>,
) -> Vec<CompletionItem> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let before = asked.text[..asked.byte].trim_end_matches(is_word);
    let receiver = |marks: &str| {
        let rest = before.strip_suffix(marks)?;
        Some(&rest[rest.trim_end_matches(is_word).len()..])
    };
    // A body that belongs to no reaction is a method's, a preamble or a value.
    let in_reaction = |one: &&ReactionSyntax| {
        let ends = [one.code.as_ref(), one.deadline.as_ref().map(|deadline| &deadline.code)];
        let late = one.tardy.as_ref().and_then(|tardy| tardy.code.as_ref());
        let mut codes = ends.into_iter().flatten().chain(late);
        codes.any(|code| (code.span.start..=code.span.end).contains(&asked.byte))
    };
    let is_open = reactor.is_some_and(|reactor| {
        reactor.body.methods.iter().all(|method| !(method.code.span.start..=method.code.span.end).contains(&asked.byte))
    });
    let reaction = reaction.filter(|one| in_reaction(one) || (one.code.is_none() && is_open));
    let fields = &[NameKind::State, NameKind::Parameter, NameKind::Method];
    match language {
        Language::Rust => match receiver(".") {
            Some("self") => of_kinds(asked, fields),
            Some("ctx") => functions(CTX),
            Some(_) => Vec::new(),
            None if before.ends_with("::") => Vec::new(),
            None => {
                let words = RUST.iter().map(|(word, what)| item(word, CompletionItemKind::KEYWORD, what));
                variables(asked, reaction, |instance, port| format!("{instance}__{port}")).chain(words).collect()
            }
        },
        Language::C => match (receiver("->"), receiver(".")) {
            (Some("self"), _) => of_kinds(asked, fields),
            (Some(_), _) => C_FIELDS.iter().map(|(name, what)| item(name, CompletionItemKind::FIELD, what)).collect(),
            (_, Some(instance)) if !instance.is_empty() => ports_of(asked, instance),
            (_, Some(_)) => Vec::new(),
            _ => {
                let own = item("self", CompletionItemKind::KEYWORD, "the reactor: its parameters and state variables");
                let methods = of_kinds(asked, &[NameKind::Method]);
                let variables = variables(asked, reaction, |instance, port| format!("{instance}.{port}"));
                variables.chain([own]).chain(methods).chain(functions(C)).collect()
            }
        },
    }
}

fn functions(all: &[(&str, &str, &str)]) -> Vec<CompletionItem> {
    let function = |(name, arguments, what): &(&str, &str, &str)| CompletionItem {
        documentation: markdown(what),
        ..item(name, CompletionItemKind::METHOD, &format!("{name}{arguments}"))
    };
    all.iter().map(function).collect()
}

/// Returns the variables of a reaction's signature, those of contained reactors in the language's form.
fn variables<'a>(
    asked: &'a Asked<'_>,
    reaction: Option<&'a ReactionSyntax>,
    of_child: fn(&str, &str) -> String,
) -> impl Iterator<Item = CompletionItem> + 'a {
    let all: Vec<&Reference> = reaction.map(|reaction| signature(reaction).collect()).unwrap_or_default();
    all.into_iter().filter_map(move |reference| {
        let (_, declaration) = asked.names.at(asked.file, reference.name.span.start)?;
        let plain = declared(asked, declaration);
        let label = match &reference.container {
            Some(instance) => of_child(&instance.text, &reference.name.text),
            None => plain.label.clone(),
        };
        Some(CompletionItem { label, ..plain })
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::{C, CTX};

    fn text(path: &str) -> String {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        fs::read_to_string(repository.join(path)).unwrap_or_default()
    }

    /// The guide's page, the runtime and this table know the same methods.
    #[test]
    fn the_methods_of_ctx_are_those_of_the_guide() {
        let guide = text("docs/guide/src/bodies.md");
        let quoted = guide.split("`ctx.").skip(1).filter_map(|rest| rest.split('`').next());
        let calls = quoted.filter_map(|call| call.split_once('(')).map(|(name, _)| name);
        for name in calls {
            assert!(CTX.iter().any(|(known, ..)| *known == name), "ctx.{name} is in the guide only");
        }
        for (name, ..) in CTX {
            assert!(guide.contains(&format!("`ctx.{name}(")), "ctx.{name} is not in the guide");
        }
    }

    #[test]
    fn the_functions_of_c_are_those_of_the_header() {
        let headers = ["lf.h", "lf_print.h", "lf_time.h", "lf_threads.h", "lf_token.h"];
        let all: String = headers.iter().map(|name| text(&format!("rust/c/include/{name}"))).collect();
        for (name, ..) in C {
            assert!(all.contains(&format!("{name}(")), "{name}");
        }
    }
}
