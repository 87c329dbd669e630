// SPDX-License-Identifier: Apache-2.0
//! `program.c`: the addresses of everything, its initialisation, and the functions that Rust calls.

use std::collections::BTreeSet;

use super::class::{handover_function, reset_function};
use super::reactions::all_arguments;
use super::storage::pool_name;
use super::symbols::Symbols;
use super::text::Text;
use super::types::CType;
use crate::emit::File;
use crate::emit::host::{ReactionPart, merge_cases};
use crate::plan::{Argument, Reaction, ReactionKind, ScheduledReaction, TriggerKind, VariableKind};
use crate::tables::handed_over;

/// Emits the file.
pub(super) fn emit(symbols: &Symbols<'_>, folder: &str) -> File {
    let text = Text::new(
        symbols.view,
        format!("{folder}/c/program.c"),
        "The addresses of all variables, and the functions that Rust calls.",
    );
    let mut program = ProgramFile { symbols, text };
    program
        .text
        .line("#include <stddef.h>\n#include <lf.h>\n\n/* Only the files of the classes define these types. */");
    program.text.line("struct lf_storage;");
    program.declarations();
    program.tables();
    program.construct();
    program.multiports();
    for part in ReactionPart::ALL {
        program.reactions(part);
    }
    program.reset();
    program.handover();
    program.text.file()
}

struct ProgramFile<'p, 's> {
    symbols: &'s Symbols<'p>,
    text: Text<'p>,
}

impl ProgramFile<'_, '_> {
    /// Emits declarations of the variables and functions in the classes' files.
    fn declarations(&mut self) {
        let symbols = self.symbols;
        let (plan, federate) = (symbols.plan, symbols.federate);
        if self.has_main() {
            self.text.line("extern struct lf_storage lf_self_main;");
        }
        for index in 0..federate.instances.len() {
            self.text.line(format_args!("extern struct lf_storage {};", Symbols::instance(Some(index))));
        }
        for index in 0..federate.ports.len() {
            self.text.line(format_args!("extern struct lf_storage lf_port_{index};"));
        }
        for (index, trigger) in federate.triggers.iter().enumerate() {
            if is_shown(&trigger.kind) {
                self.text.line(format_args!("extern struct lf_storage lf_trigger_{index};"));
            }
            if self.queues(index) {
                self.text.line(format_args!("extern lf_pool_t {};", pool_name(index)));
            }
        }
        let main = symbols.class(plan.main);
        self.text.line(format_args!("bool {main}_give(int, long long, double, char *);"));
        for (class, name) in symbols.classes() {
            self.text.line(format_args!("void {name}_construct(void *, const void *const *, int);"));
            let declared = symbols.view.class(class);
            for child in (0..declared.children.len()).filter(|child| symbols.makes(class, *child)) {
                self.text.line(format_args!("void {name}_make_{child}(void *, void *, int);"));
            }
            let modes: BTreeSet<Option<usize>> = declared.state.iter().map(|state| state.mode).collect();
            for mode in modes.into_iter().filter(|mode| declared.has_resets(*mode)) {
                self.text.line(format_args!("void {}(void *);", reset_function(name, mode)));
            }
            if declared.state.iter().any(|state| state.handed_over.is_some()) {
                self.text.line(format_args!("void *{}(void *, int, size_t *);", handover_function(name)));
            }
            for reaction in declared.reactions.iter().filter(|reaction| symbols.reacts(class, reaction.number)) {
                let given = all_arguments(reaction);
                for part in ReactionPart::ALL.into_iter().filter(|part| part.code(reaction).is_some()) {
                    let number = reaction.number;
                    self.text.line(format_args!("void {name}_reaction_{number}{}(void *self{given});", part.suffix()));
                }
            }
        }
    }

    /// Returns whether the federated reactor exists only for the parameters of its federates.
    fn has_main(&self) -> bool {
        let (plan, federate) = (self.symbols.plan, self.symbols.federate);
        plan.is_federated() && federate.instances.iter().all(|instance| instance.path != plan.name)
    }

    /// Returns whether a trigger has a queue of values that are not pointers.
    fn queues(&self, trigger: usize) -> bool {
        let federate = self.symbols.federate;
        let trigger = &federate.triggers[trigger];
        let (TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. }) = &trigger.kind else {
            return false;
        };
        let port = &federate.ports[fills.0];
        let here = federate.declared(&trigger.path).is_some();
        let class = federate.declared(&port.path).filter(|_| here);
        class.is_some_and(|(class, _)| {
            let ty = CType::new(self.symbols.view.class(class), &port.ty);
            !ty.is_nothing() && !ty.is_token() && !ty.is_text()
        })
    }

    fn tables(&mut self) {
        let federate = self.symbols.federate;
        let ports = (0..federate.ports.len()).map(|index| format!("(lf_port_base_t *)&lf_port_{index}"));
        self.table("lf_port_base_t *const lf_ports[]", ports.collect());
        self.text.line(format_args!("const uint16_t lf_port_count = {};", federate.ports.len()));
        let instances = (0..federate.instances.len()).map(|index| format!("&{}", Symbols::instance(Some(index))));
        self.table("static void *const lf_instances[]", instances.collect());
        let triggers = federate.triggers.iter().enumerate().map(|(index, trigger)| {
            if is_shown(&trigger.kind) { format!("(lf_action_base_t *)&lf_trigger_{index}") } else { "NULL".to_owned() }
        });
        self.table("lf_action_base_t *const lf_triggers[]", triggers.collect());
        let pools = (0..federate.triggers.len())
            .map(|index| if self.queues(index) { format!("&{}", pool_name(index)) } else { "NULL".to_owned() });
        let pools = pools.collect();
        self.table("lf_pool_t *const lf_queue_pools[]", pools);
        self.text.line(format_args!("const uint16_t lf_trigger_count = {};", federate.triggers.len()));
    }

    fn table(&mut self, name: &str, mut rows: Vec<String>) {
        // C has no arrays of no elements.
        if rows.is_empty() {
            rows.push("0".to_owned());
        }
        self.text.line(format_args!("\n{name} = {{"));
        for row in rows {
            self.text.line(format_args!("    {row},"));
        }
        self.text.line("};");
    }

    /// Emits the initialisation of the parameters and the state of all instances, containers first.
    fn construct(&mut self) {
        let symbols = self.symbols;
        let (plan, federate) = (symbols.plan, symbols.federate);
        let (main, count) = (symbols.class(plan.main), symbols.view.class(plan.main).parameters.len());
        self.text.line(format_args!(
            "\n/* Values of the main reactor's parameters that differ from the defaults. */\n\
             const void *lf_main_given[{count} + 1];\n\n\
             bool lf_give_parameter(uint16_t parameter, long long whole, double real, char *text) {{\n    \
             return {main}_give(parameter, whole, real, text);\n}}\n\nvoid lf_construct(void) {{"
        ));
        if self.has_main() {
            self.text.line(format_args!("    {main}_construct(&lf_self_main, lf_main_given, 0);"));
        }
        for (index, instance) in federate.instances.iter().enumerate() {
            let own = Symbols::instance(Some(index));
            let Some(child) = instance.child else {
                self.text.line(format_args!("    {main}_construct(&{own}, lf_main_given, 0);"));
                continue;
            };
            let container = Symbols::instance(instance.parent.map(|parent| parent.0));
            let class = instance.parent.map_or(plan.main, |parent| federate.instances[parent.0].class);
            let (class, member) = (symbols.class(class), instance.bank_index.unwrap_or(0));
            self.text.line(format_args!("    {class}_make_{child}(&{container}, &{own}, {member});"));
        }
        self.text.line("}");
    }

    /// Emits the addresses of the channels of each reaction's multiports. As constants they take no time, and no memory
    /// of a board.
    fn multiports(&mut self) {
        for (id, reaction) in self.symbols.federate.reactions.iter().enumerate() {
            let ReactionKind::Body { arguments, .. } = &reaction.kind else { continue };
            for (position, argument) in arguments.iter().enumerate() {
                let ports = match argument {
                    Argument::Ports(ports) => ports,
                    Argument::Bank { ports, widths } => {
                        let widths = widths.iter().map(ToString::to_string).collect();
                        self.table(&format!("static const int {}[]", widths_name(id, position)), widths);
                        ports
                    }
                    _ => continue,
                };
                let places = ports.iter().map(|port| format!("&lf_port_{}", port.0)).collect();
                self.table(&format!("static void *const {}[]", places_name(id, position)), places);
            }
        }
    }

    /// Adds the function that runs a part of each reaction by its number.
    fn reactions(&mut self, part: ReactionPart) {
        let function = part.method();
        self.text.line(format_args!("\nvoid lf_{function}(uint16_t id) {{\n    switch (id) {{"));
        let reactions = self.symbols.federate.reactions.iter().enumerate();
        let calls = reactions.filter_map(|(id, reaction)| Some((id, self.call(id, reaction, part)?)));
        for case in merge_cases(&calls.collect::<Vec<_>>()) {
            self.text.line(case);
        }
        self.text.line("    default:\n        break;\n    }\n}");
    }

    fn call(&self, id: usize, reaction: &ScheduledReaction, part: ReactionPart) -> Option<String> {
        let (plan, federate) = (self.symbols.plan, self.symbols.federate);
        let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
        let class = plan.class(&federate.instances[instance.0]);
        let declared: &Reaction = &class.reactions[number - 1];
        let suffix = part.run(declared)?.suffix();
        let given = declared.parameters.iter().zip(arguments).enumerate();
        let given = given.map(|(position, (parameter, argument))| match argument {
            Argument::Port(place) => format!(", lf_ports[{}]", place.0),
            Argument::Ports(ports) => format!(", (void **){}, {}", places_name(id, position), ports.len()),
            Argument::Bank { widths, .. } => {
                let (places, listed) = (places_name(id, position), widths_name(id, position));
                format!(", (void **){places}, {listed}, {}", widths.len())
            }
            Argument::Trigger(trigger) => format!(", lf_triggers[{}]", trigger.0),
            Argument::Mode(mode) => {
                let history = matches!(parameter.kind, VariableKind::Mode { history: true });
                format!(", (lf_mode_change_t){{ {mode}, {history} }}")
            }
        });
        let given: String = given.collect();
        let name = self.symbols.class(federate.instances[instance.0].class);
        Some(format!("{name}_reaction_{number}{suffix}(lf_instances[{}]{given})", instance.0))
    }

    fn reset(&mut self) {
        let (plan, federate) = (self.symbols.plan, self.symbols.federate);
        self.text.line("\nvoid lf_reset_mode(uint16_t mode) {\n    switch (mode) {");
        for (id, resets) in plan.resets(federate).into_iter().enumerate() {
            self.text.line(format_args!("    case {id}:"));
            for (instance, of) in resets {
                let function = reset_function(self.symbols.class(federate.instances[instance.0].class), of);
                self.text.line(format_args!("        {function}(&{});", Symbols::instance(Some(instance.0))));
            }
            self.text.line("        break;");
        }
        self.text.line("    default:\n        break;\n    }\n}");
    }
}

impl ProgramFile<'_, '_> {
    /// Emits the function that returns the place of a state that is handed over, by its number in the program.
    fn handover(&mut self) {
        let (plan, federate) = (self.symbols.plan, self.symbols.federate);
        self.text.line("\nvoid *lf_handed_over(uint16_t state, size_t *size) {\n    switch (state) {");
        for (id, row) in handed_over(plan, federate).into_iter().enumerate() {
            let class = federate.instances[row.instance.0].class;
            let states = plan.classes[class.0].state.iter().filter(|state| state.handed_over.is_some());
            let number = states.take_while(|state| state.name != row.state.name).count();
            let (function, own) =
                (handover_function(self.symbols.class(class)), Symbols::instance(Some(row.instance.0)));
            self.text.line(format_args!("    case {id}:\n        return {function}(&{own}, {number}, size);"));
        }
        self.text.line("    default:\n        (void)size;\n        return NULL;\n    }\n}");
    }
}

/// Returns the name of the addresses for a parameter of a reaction, by its position.
fn places_name(reaction: usize, parameter: usize) -> String {
    format!("lf_places_{reaction}_{parameter}")
}

/// Returns the name of the widths of a bank's ports, for the same.
fn widths_name(reaction: usize, parameter: usize) -> String {
    format!("lf_widths_{reaction}_{parameter}")
}

/// Returns whether bodies see a trigger.
fn is_shown(kind: &TriggerKind) -> bool {
    matches!(kind, TriggerKind::Action { .. } | TriggerKind::Timer { .. } | TriggerKind::Watchdog { .. })
}
