// SPDX-License-Identifier: Apache-2.0
//! Reactions whose bodies are functions in files of the program itself.

use core::fmt::Write as _;
use std::collections::BTreeMap;

use super::class_file::ClassFile;
use super::header::{port_type, self_type};
use super::reactions::{all_arguments, own_name};
use super::symbols::Symbols;
use crate::emit::EmitError;
use crate::plan::{ChildPort, ClassIndex, Reaction, ReactorClass};

impl<'p> ClassFile<'p, '_> {
    /// Emits the function that calls the reaction's function with its ports.
    pub(super) fn external(&mut self, reaction: &'p Reaction) {
        let (view, class) = (self.symbols.view, self.class);
        let signature = reaction.signature.replace("*/", "* /");
        self.text.line(format_args!("\n/* `{signature}`, line {}: the body is elsewhere. */", reaction.at.line));
        let (name, parameters, linkage) = (self.name, all_arguments(reaction), self.linkage());
        self.text.line(format_args!("{linkage}void {name}_reaction_{}(void *self{parameters}) {{", reaction.number));
        let mut given = format!("({} *)self", self_type(class));
        for parameter in &reaction.parameters {
            let own = own_name(parameter);
            let Some((ty, stars)) = port_type(view, class, parameter) else {
                self.text.line(format_args!("    (void){own};"));
                continue;
            };
            let value = match &parameter.child {
                Some(ChildPort { is_bank: true, is_wide: true, .. }) => {
                    self.text.line(format_args!("    {ty} **lf_{own}[{own}_width + 1];"));
                    self.text.line(format_args!(
                        "    for (int lf_i = 0, lf_at = 0; lf_i < {own}_width; lf_at += {own}_widths[lf_i++]) \
                         {{\n        lf_{own}[lf_i] = ({ty} **)&{own}[lf_at];\n    }}"
                    ));
                    format!("lf_{own}")
                }
                Some(_) => own,
                None => {
                    if self.is_copied(parameter) {
                        self.copy(parameter);
                    }
                    self.own_argument(parameter).split(", ").next().unwrap_or_default().to_owned()
                }
            };
            // Writing to a String cannot fail.
            let _ = write!(given, ", ({ty} {}){value}", "*".repeat(stars));
            if stars > 1 {
                self.text.line(format_args!("    (void){}_width;", own_name(parameter)));
            }
        }
        self.text.line(format_args!("    {}({given});\n}}", reaction.name.as_deref().unwrap_or_default()));
    }
}

/// Refuses a function of two reactors, because its arguments would differ.
pub(super) fn check(symbols: &Symbols<'_>) -> Result<(), EmitError> {
    let mut functions: BTreeMap<&str, (ClassIndex, &ReactorClass)> = BTreeMap::new();
    for (index, _) in symbols.classes() {
        let class = symbols.view.class(index);
        let external = class.reactions.iter().filter(|one| one.external && symbols.reacts(index, one.number));
        for (reaction, name) in external.filter_map(|one| Some((one, one.name.as_deref()?))) {
            let (first, other) = *functions.entry(name).or_insert((index, class));
            if first != index {
                let message = format!(
                    "the function `{name}` is the body of reactions of both `{}` and `{}`, whose `self` differ: give \
                     one of the reactions another name, or a body",
                    other.name, class.name
                );
                return Err(EmitError::new(symbols.plan, reaction.at, message));
            }
        }
    }
    Ok(())
}
