// SPDX-License-Identifier: Apache-2.0
//! The functions of a reaction: one with the body as it is written, and one that calls it.

use std::fmt::Write as _;

use super::class_file::ClassFile;
use crate::emit::host::ReactionPart;
use crate::plan::{ChildPort, ClassIndex, Reaction, ReactionParameter, SourceCode, VariableKind};

/// Returns the name of a parameter's variable in the function that calls a reaction.
pub(super) fn own_name(parameter: &ReactionParameter) -> String {
    parameter.name.replace('.', "__")
}

/// Returns the variables of the function that calls a reaction, one group per parameter. For a bank's multiport, the
/// width is the number of members.
fn arguments(parameter: &ReactionParameter) -> String {
    let name = own_name(parameter);
    match (&parameter.kind, &parameter.child) {
        (VariableKind::Mode { .. }, _) => format!("lf_mode_change_t {name}"),
        (VariableKind::Multiport { .. }, Some(ChildPort { is_bank: true, is_wide: true, .. })) => {
            format!("void **{name}, const int *{name}_widths, int {name}_width")
        }
        (VariableKind::Multiport { .. }, _) => format!("void **{name}, int {name}_width"),
        _ => format!("void *{name}"),
    }
}

/// Returns the variables for all parameters of a reaction, behind that of the reactor itself.
pub(super) fn all_arguments(reaction: &Reaction) -> String {
    let all: Vec<String> = reaction.parameters.iter().map(|one| format!(", {}", arguments(one))).collect();
    all.concat()
}

/// A contained reactor, or a bank of them, with the ports that a reaction uses.
struct Contained<'p> {
    first: &'p ChildPort,
    class: ClassIndex,
    ports: Vec<(&'p ReactionParameter, &'p ChildPort)>,
}

impl<'p> ClassFile<'p, '_> {
    /// Adds the functions of a part of a reaction.
    pub(super) fn reaction(&mut self, reaction: &'p Reaction, part: ReactionPart, code: &SourceCode) {
        let (name, types) = (self.name, self.types);
        let function = format!("{name}_reaction_{}{}", reaction.number, part.suffix());
        let (mut variables, mut given, mut children) = (String::new(), String::new(), Vec::<Contained<'p>>::new());
        for parameter in &reaction.parameters {
            // As with LF's compiler, whose programs may have something else of a timer's name.
            if matches!(parameter.kind, VariableKind::Timer) && !self.symbols.view.native.is_micro {
                continue;
            }
            let Some(contained) = &parameter.child else {
                variables = variables + ", " + &self.own_variable(parameter);
                given = given + ", " + &self.own_argument(parameter);
                continue;
            };
            if let Some(known) = children.iter_mut().find(|known| known.first.child == contained.child) {
                known.ports.push((parameter, contained));
                continue;
            }
            let own = &contained.child;
            // Writing to a String cannot fail.
            if contained.is_bank {
                let _ = write!(variables, ", {function}_{own}_t *{own}, int {own}_width");
                let _ = write!(given, ", lf_{own}, {}_width", own_name(parameter));
            } else {
                let _ = write!(variables, ", {function}_{own}_t {own}");
                let _ = write!(given, ", lf_{own}");
            }
            let class = self.class.children.iter().find(|child| child.name == *own).map(|child| child.class);
            let class = class.unwrap_or(self.index);
            children.push(Contained { first: contained, class, ports: vec![(parameter, contained)] });
        }
        let signature = reaction.signature.replace("*/", "* /");
        self.text.line(format_args!("\n/* `{signature}`, line {}. */", reaction.at.line));
        for Contained { first, class, ports } in &children {
            let prefix = self.symbols.types(*class);
            let fields = ports.iter().map(|(_, ChildPort { port, is_wide, .. })| match is_wide {
                true => format!(" {prefix}_{port}_t **{port}; int {port}_width;"),
                false => format!(" {prefix}_{port}_t *{port};"),
            });
            let fields: String = fields.collect();
            self.text.line(format_args!("typedef struct {{{fields} }} {function}_{}_t;", first.child));
        }
        self.text
            .line(format_args!("static void {function}_body({types}_self_t *self{variables}) {{\n    (void)self;"));
        if self.symbols.view.native.is_micro {
            self.text.line("    Environment *env = lf_uc_environment();\n    (void)env;");
        }
        self.text.code(code).line("}");
        let parameters = all_arguments(reaction);
        let linkage = self.linkage();
        self.text.line(format_args!("{linkage}void {function}(void *self{parameters}) {{"));
        for contained in &children {
            self.contained(&function, contained);
        }
        for parameter in &reaction.parameters {
            if self.is_copied(parameter) {
                self.copy(parameter);
            }
        }
        self.text.line(format_args!("    {function}_body(({types}_self_t *)self{given});\n}}"));
    }

    /// Returns the declaration of a body's variable.
    fn own_variable(&self, parameter: &ReactionParameter) -> String {
        let (class, own) = (self.types, &parameter.name);
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

    /// Returns the argument for it.
    pub(super) fn own_argument(&self, parameter: &ReactionParameter) -> String {
        let (class, own) = (self.types, &parameter.name);
        match (&parameter.kind, self.is_copied(parameter)) {
            (VariableKind::Multiport { .. }, true) => format!("lf_copies_{own}, {own}_width"),
            (VariableKind::Multiport { .. }, false) => format!("({class}_{own}_t **){own}, {own}_width"),
            (_, true) => format!("&lf_copy_{own}"),
            (VariableKind::Mode { .. }, false) => own.clone(),
            (VariableKind::Timer, false) => format!("(lf_timer_t *){own}"),
            (VariableKind::Watchdog, false) => format!("(watchdog_t *){own}"),
            (_, false) => format!("({class}_{own}_t *){own}"),
        }
    }

    /// Emits lines that put the ports of a contained reactor, or of each member of a bank, into a struct.
    fn contained(&mut self, function: &str, contained: &Contained<'_>) {
        let Contained { first: ChildPort { child, is_bank, .. }, class, ports } = contained;
        let prefix = self.symbols.types(*class);
        let ty = format!("{function}_{child}_t");
        if !is_bank {
            let fields = ports.iter().map(|(parameter, ChildPort { port, is_wide, .. })| {
                let own = own_name(parameter);
                match is_wide {
                    true => format!(" .{port} = ({prefix}_{port}_t **){own}, .{port}_width = {own}_width,"),
                    false => format!(" .{port} = ({prefix}_{port}_t *){own},"),
                }
            });
            let fields: String = fields.collect();
            self.text.line(format_args!("    {ty} lf_{child} = {{{fields} }};"));
            return;
        }
        let width = format!("{}_width", own_name(ports[0].0));
        // C has no arrays of no elements.
        self.text.line(format_args!("    {ty} lf_{child}[{width} + 1];"));
        for (parameter, ChildPort { port, is_wide, .. }) in ports {
            let own = own_name(parameter);
            self.text.line(if *is_wide {
                format!(
                    "    for (int lf_i = 0, lf_at = 0; lf_i < {width}; lf_at += {own}_widths[lf_i++]) {{\n        \
                     lf_{child}[lf_i].{port} = ({prefix}_{port}_t **)&{own}[lf_at];\n        \
                     lf_{child}[lf_i].{port}_width = {own}_widths[lf_i];\n    }}"
                )
            } else {
                format!(
                    "    for (int lf_i = 0; lf_i < {width}; lf_i++) {{\n        \
                     lf_{child}[lf_i].{port} = ({prefix}_{port}_t *){own}[lf_i];\n    }}"
                )
            });
        }
    }

    /// Returns whether a body has a copy of its own: of a `mutable` input.
    pub(super) fn is_copied(&self, parameter: &ReactionParameter) -> bool {
        let declared = self.class.ports.iter().find(|port| port.name == parameter.name);
        declared.is_some_and(|port| port.mutable && parameter.child.is_none())
    }

    pub(super) fn copy(&mut self, parameter: &ReactionParameter) {
        let (ty, own) = (format!("{}_{}_t", self.types, parameter.name), &parameter.name);
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
