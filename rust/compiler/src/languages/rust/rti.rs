// SPDX-License-Identifier: Apache-2.0
//! The module of an image's RTI: what it knows of the federation.
//!
//! All that are numbers is in the Kconfig fragment, where it can be raised. But how long a message can be is known to
//! the types of the program alone, some of which preambles declare.

use std::collections::BTreeSet;

use lf_model::time::Interval;
use quote::quote;

use super::federate::log_level;
use super::layout::Layout;
use super::print::{Fields, interval, optional_ns};
use super::reactor::{parsed_type, type_path};
use super::sending::{declared, max_len};
use super::splice::Splices;
use super::types::is_copy;
use crate::deployment::{Deployment, Platform};
use crate::emit::{EmitError, File, FileMap, Job};
use crate::plan::{ClassIndex, ClockSync, Federate, InputIndex, Plan, Rti, Serializer, TriggerKind, Type};

/// The types of all that the RTI passes on, each once.
pub(super) struct Payloads<'p>(Vec<Payload<'p>>);

/// The type of the values of a connection.
struct Payload<'p> {
    ty: &'p Type,
    serializer: Option<&'p Serializer>,
    /// The class of the port at one end, and the port's name, where the type can be spelled.
    declared: Option<(ClassIndex, &'p str)>,
}

impl<'p> Payloads<'p> {
    /// The types of the connections between federates, physical ones and all of decentralized coordination left out.
    pub(super) fn new(plan: &'p Plan, deployment: &Deployment) -> Self {
        let mut payloads: Vec<Payload<'p>> = Vec::new();
        for federate in &plan.federates {
            for (port, input) in federate.inputs.iter().enumerate().filter(|(_, input)| !input.direct) {
                let Some(payload) = payload(plan, deployment, federate, port, input.federate) else { continue };
                if !payloads.iter().any(|known| known.is_same(&payload)) {
                    payloads.push(payload);
                }
            }
        }
        Self(payloads)
    }

    /// The classes whose types are needed.
    pub(super) fn classes(&self) -> BTreeSet<ClassIndex> {
        self.0
            .iter()
            .filter(|payload| !is_copy(&payload.ty.text))
            .filter_map(|payload| Some(payload.declared?.0))
            .collect()
    }

    fn lengths(&self, plan: &Plan, layout: &Layout<'_>) -> Result<Vec<String>, EmitError> {
        let length = |payload: &Payload<'p>| {
            let ty = match payload.declared {
                Some((class, name)) => type_path(plan, layout, class, name, payload.ty)?,
                None => parsed_type(plan, payload.ty).map(|_| payload.ty.text.clone())?,
            };
            Ok(match payload.serializer {
                None => format!("<{ty} as Payload>::MAX_LEN"),
                by => max_len(by, &ty),
            })
        };
        self.0.iter().map(length).collect()
    }
}

impl Payload<'_> {
    /// Whether it is as long as another one for certain.
    fn is_same(&self, other: &Self) -> bool {
        let copied = is_copy(&self.ty.text) || self.declared == other.declared;
        copied && self.ty.text == other.ty.text && self.serializer == other.serializer
    }
}

/// The type of an input from another federate, if it is one of this language. What a preamble declares may ask for a
/// system that Zephyr is not, so the end of the connection that is an image is asked, and the receiver where both are.
fn payload<'p>(
    plan: &'p Plan,
    deployment: &Deployment,
    receiver: &'p Federate,
    port: usize,
    sender: u16,
) -> Option<Payload<'p>> {
    let input = &receiver.inputs[port];
    let filled = match receiver.triggers[input.trigger.0].kind {
        TriggerKind::NetworkInput { fills, .. } => Some(fills),
        _ => None,
    };
    let is_known = |federate: &Federate| !plan.is_foreign(federate.instances[0].class);
    let at_receiver = filled.and_then(|port| declared(receiver, port)).filter(|_| is_known(receiver));
    let outputs = plan.federates.iter().filter(|federate| federate.id == sender);
    let source = outputs.flat_map(|sender| sender.outputs.iter().map(move |output| (sender, output)));
    let mut source = source
        .filter(|(_, output)| output.federate == receiver.id && output.port == receiver.port_of(InputIndex(port)));
    let source = source.next();
    let is_image = |federate: &Federate| deployment.place(&federate.name).platform != Platform::Host;
    let asked =
        |sender: &Federate| is_known(sender) && (!is_known(receiver) || is_image(sender) && !is_image(receiver));
    let at_sender = source.filter(|(sender, _)| asked(sender));
    let ty = if is_known(receiver) { &input.ty } else { &at_sender?.1.ty };
    let at_sender = at_sender.and_then(|(sender, output)| declared(sender, output.source));
    let serializer = input.serializer.as_ref();
    // The length of a serialized value that has a bound of its own says nothing of the type.
    let is_number = serializer.is_some_and(|by| by.name.is_some() && by.max_length.is_some());
    let declared = at_sender.or(at_receiver).filter(|_| !is_number);
    Some(Payload { ty, serializer, declared })
}

/// Emits the module.
pub(super) fn emit(
    job: &Job<'_>,
    payloads: &Payloads<'_>,
    layout: &Layout<'_>,
    deployed: &Rti,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    emit_with(job, payloads.lengths(job.plan, layout)?, deployed, path)
}

/// Emits the module of an RTI that passes on payloads of these lengths, which are expressions.
pub(in crate::languages) fn emit_with(
    job: &Job<'_>,
    mut lengths: Vec<String>,
    deployed: &Rti,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let plan = job.plan;
    let (about, target) = (format!(" The RTI of {}.", plan.name), &plan.target);
    let trials = target.clock_sync_trials;
    let clock_sync = match target.clock_sync {
        ClockSync::Off => "ClockSync::Off".to_owned(),
        ClockSync::Init => format!("ClockSync::Init {{ trials: {trials} }}"),
        ClockSync::On => {
            let period = interval(Interval::from_nanos(target.clock_sync_period_ns));
            format!("ClockSync::On {{ trials: {trials}, period: {period} }}")
        }
    };
    let mut rti = Fields::of("Description");
    rti.set("federation_id", format_args!("{:?}", deployed.federation_id));
    rti.set("authentication", if target.authentication { "Some(lf::rti::AUTHENTICATOR)" } else { "None" });
    rti.set("clock_sync", clock_sync).set("dnet", target.dnet).set("log_waits", optional_ns(target.log_waits_ns));
    rti.set("logging", log_level(target.logging));
    lengths.extend(job.passed_on.iter().map(u64::to_string));
    let lengths = lengths.join(", ");
    rti.set("payload_bytes_max", format_args!("lf::rti::longest(&[{lengths}])"));
    let mut splices = Splices::new(plan);
    let text = splices.text(format!(
        "use lf::model::*;\nuse lf::rti::{{ClockSync, Description}};\n\n\
         /// What the RTI knows of the federation; CONFIG_LF_RTI_… has the sizes.\n\
         pub static RTI: Description = {};\n",
        rti.block()
    ));
    splices.finish(path, quote! { #![doc = #about] #text })
}
