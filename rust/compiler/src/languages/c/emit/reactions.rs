// SPDX-License-Identifier: Apache-2.0
//! The functions of a reaction: one with the body as it is written, and one by which it is called.

use super::class::ClassFile;
use crate::plan::{Child, Code, PortDeclaration, Reaction, ReactionParameter, Tardy, VariableKind};

/// A body of a reaction, and what the name of its function ends with.
pub(super) struct Body<'p> {
    pub(super) suffix: &'static str,
    pub(super) code: &'p Code,
}

/// What the names of the functions end with that run in place of a reaction.
pub(super) const DEADLINE: &str = "_deadline";
pub(super) const TARDY: &str = "_tardy";

/// The bodies of a reaction.
pub(super) fn functions(reaction: &Reaction) -> Vec<Body<'_>> {
    let mut bodies = vec![Body { suffix: "", code: &reaction.body }];
    bodies.extend(reaction.deadline.as_ref().map(|code| Body { suffix: DEADLINE, code }));
    if let Some(Tardy::Handler(code)) = &reaction.tardy {
        bodies.push(Body { suffix: TARDY, code });
    }
    bodies
}

/// What a variable of a reaction is in C.
pub(super) enum Variable<'p> {
    /// Something of the reactor itself.
    Own,
    /// A port of a contained reactor.
    Contained {
        child: &'p Child,
        port: &'p PortDeclaration,
        /// The class of the child.
        class: crate::plan::ClassIndex,
    },
}

/// What a variable stands for, by its name.
pub(super) fn variable<'p>(
    plan: &'p crate::plan::Plan,
    class: &'p crate::plan::ReactorClass,
    parameter: &ReactionParameter,
) -> Variable<'p> {
    let contained = parameter.name.split_once('.').and_then(|(owner, name)| {
        let child = class.children.iter().find(|child| child.name == owner)?;
        let port = plan.classes[child.class.0].ports.iter().find(|port| port.name == name)?;
        Some(Variable::Contained { child, port, class: child.class })
    });
    contained.unwrap_or(Variable::Own)
}

/// The variable of a parameter in the function by which a reaction is called.
fn own_name(parameter: &ReactionParameter) -> String {
    parameter.name.replace('.', "__")
}

/// The variables of the function by which a reaction is called, one group per parameter.
pub(super) fn arguments(parameter: &ReactionParameter, variable: &Variable<'_>) -> String {
    let name = own_name(parameter);
    match (&parameter.kind, variable) {
        (VariableKind::Mode { .. }, _) => format!("lf_mode_change_t {name}"),
        (VariableKind::Multiport { .. }, Variable::Contained { child, .. }) if child.is_bank => {
            format!("void **{name}, const int *{name}_widths, int {name}_width")
        }
        (VariableKind::Multiport { .. }, _) => format!("void **{name}, int {name}_width"),
        _ => format!("void *{name}"),
    }
}

impl ClassFile<'_, '_> {
    /// The functions of a body.
    pub(super) fn reaction(&mut self, reaction: &Reaction, body: &Body<'_>) {
        let (plan, class, name) = (self.symbols.plan, self.class, self.name);
        let function = format!("{name}_reaction_{}{}", reaction.number, body.suffix);
        let named: Vec<_> =
            reaction.parameters.iter().map(|parameter| (parameter, variable(plan, class, parameter))).collect();
        let mut children: Vec<(&str, bool, Vec<&ReactionParameter>, Vec<&PortDeclaration>, crate::plan::ClassIndex)> = Vec::new();
        let (mut typed, mut calls) = (Vec::new(), Vec::new());
        for (parameter, variable) in &named {
            match variable {
                Variable::Own => {
                    typed.push(self.own_variable(parameter));
                    calls.push(self.own_argument(parameter));
                }
                Variable::Contained { child, port, class } => {
                    if let Some(known) = children.iter_mut().find(|known| known.0 == child.name) {
                        known.2.push(parameter);
                        known.3.push(port);
                        continue;
                    }
                    let (own, width) = (&child.name, if child.is_bank { format!(", int {}_width", child.name) } else { String::new() });
                    let star = if child.is_bank { "*" } else { "" };
                    typed.push(format!("{function}_{own}_t {star}{own}{width}"));
                    calls.push(if child.is_bank { format!("lf_{own}, {}_width", own_name(parameter)) } else { format!("lf_{own}") });
                    children.push((own, child.is_bank, vec![parameter], vec![port], *class));
                }
            }
        }
        self.text.line(format_args!("\n/* `{}`, line {}. */", reaction.signature.replace("*/", "* /"), reaction.at.line));
        for (child, _, _, ports, of) in &children {
            let prefix = self.symbols.class(*of).to_owned();
            let fields: String = ports
                .iter()
                .map(|port| {
                    let ty = format!("{prefix}_{}_t", port.name);
                    if port.is_wide { format!(" {ty} **{0}; int {0}_width;", port.name) } else { format!(" {ty} *{};", port.name) }
                })
                .collect();
            self.text.line(format_args!("typedef struct {{{fields} }} {function}_{child}_t;"));
        }
        let typed: String = typed.iter().map(|one| format!(", {one}")).collect();
        self.text.line(format_args!("static void {function}_body({name}_self_t *self{typed}) {{\n    (void)self;"));
        self.text.code(body.code).line("}");
        let given: String = named.iter().map(|(parameter, variable)| format!(", {}", arguments(parameter, variable))).collect();
        self.text.line(format_args!("void {function}(void *self{given}) {{"));
        for (child, is_bank, parameters, ports, _) in &children {
            self.contained(&function, child, *is_bank, parameters, ports);
        }
        let copies: Vec<&ReactionParameter> =
            named.iter().map(|(parameter, _)| *parameter).filter(|parameter| self.is_copied(parameter)).collect();
        for parameter in &copies {
            self.copy(parameter);
        }
        let calls: String = calls.iter().map(|call| format!(", {call}")).collect();
        self.text.line(format_args!("    {function}_body(self{calls});"));
        self.text.line("}");
    }

    /// The variable of a body.
    fn own_variable(&self, parameter: &ReactionParameter) -> String {
        let (class, own) = (self.name, &parameter.name);
        match &parameter.kind {
            VariableKind::Port { .. } | VariableKind::LogicalAction { .. } | VariableKind::PhysicalAction { .. } => {
                format!("{class}_{own}_t *{own}")
            }
            VariableKind::Multiport { .. } => format!("{class}_{own}_t **{own}, int {own}_width"),
            VariableKind::Timer => format!("lf_timer_t *{own}"),
            VariableKind::Watchdog => format!("watchdog_t *{own}"),
            VariableKind::Mode { .. } => format!("lf_mode_change_t {own}"),
        }
    }

    /// What is given for it.
    fn own_argument(&self, parameter: &ReactionParameter) -> String {
        let (class, own) = (self.name, &parameter.name);
        match (&parameter.kind, self.is_copied(parameter)) {
            (VariableKind::Multiport { .. }, true) => format!("lf_copies_{own}, {own}_width"),
            (VariableKind::Multiport { .. }, false) => format!("({class}_{own}_t **){own}, {own}_width"),
            (_, true) => format!("&lf_copy_{own}"),
            (_, false) => own.clone(),
        }
    }

    /// Lines that put the ports of a contained reactor, or of each member of a bank, into a struct.
    fn contained(
        &mut self,
        function: &str,
        child: &str,
        is_bank: bool,
        parameters: &[&ReactionParameter],
        ports: &[&PortDeclaration],
    ) {
        let ty = format!("{function}_{child}_t");
        if !is_bank {
            let fields = parameters.iter().zip(ports).map(|(parameter, port)| {
                let (own, name) = (own_name(parameter), &port.name);
                if port.is_wide {
                    format!(" .{name} = (void *){own}, .{name}_width = {own}_width,")
                } else {
                    format!(" .{name} = {own},")
                }
            });
            let fields: String = fields.collect();
            self.text.line(format_args!("    {ty} lf_{child} = {{{fields} }};"));
            return;
        }
        let width = format!("{}_width", own_name(parameters[0]));
        // An array of no elements is none.
        self.text.line(format_args!("    {ty} lf_{child}[{width} + 1];"));
        for (parameter, port) in parameters.iter().zip(ports) {
            let (own, name) = (own_name(parameter), &port.name);
            self.text.line(format_args!("    for (int lf_i = 0, lf_at = 0; lf_i < {width}; lf_at += {own}_widths[lf_i++]) {{"));
            self.text.line(if port.is_wide {
                format!("        lf_{child}[lf_i].{name} = (void *)&{own}[lf_at];\n        lf_{child}[lf_i].{name}_width = {own}_widths[lf_i];")
            } else {
                format!("        lf_{child}[lf_i].{name} = {own}[lf_at];")
            });
            self.text.line("    }");
        }
    }

    /// Whether a body has a copy of its own: of a `mutable` input.
    fn is_copied(&self, parameter: &ReactionParameter) -> bool {
        let declared = self.class.ports.iter().find(|port| port.name == parameter.name);
        declared.is_some_and(|port| false)
    }

    fn copy(&mut self, parameter: &ReactionParameter) {
        let (ty, own) = (format!("{}_{}_t", self.name, parameter.name), &parameter.name);
        if matches!(parameter.kind, VariableKind::Multiport { .. }) {
            self.text.line(format_args!("    {ty} lf_copy_{own}[{own}_width + 1], *lf_copies_{own}[{own}_width + 1];"));
            self.text.line(format_args!("    for (int lf_i = 0; lf_i < {own}_width; lf_i++) {{"));
            self.text.line(format_args!("        lf_copies_{own}[lf_i] = &lf_copy_{own}[lf_i];"));
            self.text.line(format_args!("        lf_copy_{own}[lf_i] = *({ty} *){own}[lf_i];"));
            self.text.line(format_args!("        lf_c_make_mutable((lf_port_base_t *)lf_copies_{own}[lf_i]);\n    }}"));
        } else {
            self.text.line(format_args!("    {ty} lf_copy_{own} = *({ty} *){own};"));
            self.text.line(format_args!("    lf_c_make_mutable((lf_port_base_t *)&lf_copy_{own});"));
        }
    }
}
