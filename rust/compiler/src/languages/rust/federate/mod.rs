// SPDX-License-Identifier: Apache-2.0
//! The module of a federate as a whole: tables and description, the struct that owns everything, and the `Program`
//! that the engine drives.

mod description;
mod module;
mod owner;
mod program;
mod symbols;
mod tables;

use core::cell::RefCell;
use std::collections::BTreeSet;

use proc_macro2::Ident;
use quote::{format_ident, quote};

use super::names::pascal_case;
use super::splice::Splices;
use crate::deployment::{Deployment, RtiHome};
use crate::emit::{EmitError, File, FileMap};
use crate::plan::{Federate, Plan};
use crate::tables::Tables;
pub(super) use description::log_level;
pub(in crate::languages) use module::Bodies;
use module::FederateModule;
use symbols::Identifiers;

/// Emits the module of a federate.
pub(in crate::languages) fn emit(
    plan: &Plan,
    federate: &Federate,
    bodies: Bodies<'_>,
    deployment: &Deployment,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let (tables, mut splices) = (Tables::of(plan, federate), Splices::new(plan));
    let symbols = Identifiers::new(federate, &tables);
    let (rti, rti_is_image) = (deployment.rti_of(plan), deployment.rti.home != RtiHome::Program);
    let named = RefCell::new(BTreeSet::new());
    let module = FederateModule { plan, federate, tables, bodies, rti, rti_is_image, symbols, named };
    let name = type_name(plan, federate);
    let tables = splices.text(module.tables_text()?);
    let (description, uses) = module.description();
    let description = splices.text(description);
    let inboxes = module.inboxes(&mut splices)?;
    let owner = module.owner(&name, &mut splices)?;
    let program = splices.text(module.program(&name.to_string()));
    let imports = splices.text(imports(&module, &uses));
    let what = if plan.is_federated() { "Federate" } else { "Main reactor" };
    let about = format!(" {what} `{}` of {}:", federate.name, plan.name);
    let summary = plan.summary(federate);
    let summary = summary.lines().map(|line| format!(" {line}"));
    let tokens = quote! {
        #![doc = #about]
        #![doc = ""]
        #![doc = " ```text"]
        #(#![doc = #summary])*
        #![doc = " ```"]
        #imports
        #tables
        #description
        #inboxes
        #owner
        #program
    };
    splices.finish(path, tokens)
}

/// The name of the struct that owns everything.
pub(in crate::languages) fn type_name(plan: &Plan, federate: &Federate) -> Ident {
    let kind = if plan.is_federated() { "Federate" } else { "Main" };
    format_ident!("{}{kind}", pascal_case(&federate.name))
}

/// The imports: the model whole, of the runtime what is used, and the modules of the classes.
fn imports(module: &FederateModule<'_>, uses: &[&str]) -> String {
    let braced = |names: &[&str]| match names {
        [name] => (*name).to_owned(),
        _ => format!("{{{}}}", names.join(", ")),
    };
    let mut text = format!("use lf::model::*;\nuse lf::runtime::{};\n", braced(uses));
    let Some(layout) = module.layout() else { return text + "use lf::c;\n" };
    let imported = layout.imports(&module.named.borrow());
    let lines = imported.iter().map(|(file, modules)| format!("use crate::{file}::{};\n", braced(modules)));
    text.push('\n');
    text.extend(lines);
    text
}
