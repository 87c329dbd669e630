// SPDX-License-Identifier: Apache-2.0
//! The module of a federate as a whole: tables and description, the struct that owns everything, and the `Program`
//! that the engine drives.

use proc_macro2::Ident;
use quote::{format_ident, quote};

use super::bodies::Bodies;
use super::identifiers::pascal_case;
use super::module::FederateModule;
use super::splice::Splices;
use super::symbols::Owner;
use crate::deployment::RtiHome;
use crate::emit::{EmitError, File, FileMap, Job};
use crate::plan::{Federate, Plan};

/// Emits the module of a federate.
pub(super) fn emit(
    job: &Job<'_>,
    federate: &Federate,
    bodies: &dyn Bodies,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let (plan, deployment) = (job.plan(), job.settings.deployment);
    let (owner, mut splices) = (Owner::new(job, federate), Splices::new(plan));
    let (rti, rti_is_image) = (deployment.rti_of(plan), deployment.rti.home != RtiHome::Program);
    let module = FederateModule { owner, bodies, rti, rti_is_image };
    let name = type_name(plan, federate);
    let tables = splices.text(module.tables_text()?);
    let (description, uses) = module.description();
    let description = splices.text(description);
    let inboxes = module.inboxes(&mut splices)?;
    let owner = module.owner_struct(&name, &mut splices)?;
    let program = splices.text(module.program(&name.to_string()));
    let imports = splices.text(imports(&module, &uses));
    let what = if plan.is_federated() { "Federate" } else { "Main reactor" };
    let about = format!(" {what} `{}` of {}:", federate.name, plan.name);
    let summary = plan.summary(federate, job.view.language);
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

/// Returns the name of the struct that owns everything.
pub(super) fn type_name(plan: &Plan, federate: &Federate) -> Ident {
    let kind = if plan.is_federated() { "Federate" } else { "Main" };
    format_ident!("{}{kind}", pascal_case(&federate.name))
}

/// Returns the imports: the whole model, the used names of the runtime, and those that the bodies need.
fn imports(module: &FederateModule<'_>, uses: &[&str]) -> String {
    let runtime = match uses {
        [name] => (*name).to_owned(),
        _ => format!("{{{}}}", uses.join(", ")),
    };
    format!("use lf::model::*;\nuse lf::runtime::{runtime};\n{}", module.bodies.imports())
}
