// SPDX-License-Identifier: Apache-2.0
//! The module of an image's RTI: what it knows of the federation.
//!
//! All that are numbers is in the Kconfig fragment, where it can be raised. But how long a message can be is known to
//! the types of the program alone, some of which preambles declare.

use std::collections::BTreeSet;

use proc_macro2::TokenStream;
use quote::quote;

use super::crate_layout::Layout;
use super::deployment::{Deployment, Platform};
use super::federate::{clock_sync_trials, interval, log_level, optional_interval};
use super::reactor::{is_copy, type_path, type_tokens};
use super::source_map::FileMap;
use super::splice::Splices;
use super::{EmitError, File};
use crate::plan::{ClassIndex, ClockSync, Federate, Plan, PortIndex, Rti, TriggerKind, Type};

/// The types of all that the RTI passes on, each once.
pub(super) struct Payloads<'p>(Vec<Payload<'p>>);

/// The type of the values of a connection.
struct Payload<'p> {
    ty: &'p Type,
    /// The class of the port at one end, and the port's name, where the type can be spelled.
    declared: Option<(ClassIndex, &'p str)>,
}

impl<'p> Payloads<'p> {
    /// The types of the connections between federates, physical ones and all of decentralized coordination left out.
    pub(super) fn new(plan: &'p Plan, deployment: &Deployment) -> Self {
        let mut payloads: Vec<Payload<'p>> = Vec::new();
        for federate in &plan.federates {
            for (port, input) in federate.inputs.iter().enumerate().filter(|(_, input)| !input.direct) {
                let payload = payload(plan, deployment, federate, port, input.federate);
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

    fn lengths(&self, plan: &Plan, layout: &Layout) -> Result<Vec<TokenStream>, EmitError> {
        let length = |payload: &Payload<'p>| {
            let ty = match payload.declared {
                Some((class, name)) => type_path(plan, layout, class, name, payload.ty)?,
                None => type_tokens(plan, payload.ty)?,
            };
            Ok(quote!(<#ty as Payload>::MAX_LEN))
        };
        self.0.iter().map(length).collect()
    }
}

impl Payload<'_> {
    /// Whether it is as long as another one for certain.
    fn is_same(&self, other: &Self) -> bool {
        let copied = is_copy(&self.ty.text) || self.declared == other.declared;
        copied && self.ty.text == other.ty.text
    }
}

/// The type of an input from another federate. What a preamble declares may ask for a system that Zephyr is not, so
/// the end of the connection that is an image is asked, and the receiver where both are.
fn payload<'p>(
    plan: &'p Plan,
    deployment: &Deployment,
    receiver: &'p Federate,
    port: usize,
    sender: u16,
) -> Payload<'p> {
    let input = &receiver.inputs[port];
    let filled = match receiver.triggers[input.trigger.0].kind {
        TriggerKind::NetworkInput { fills, .. } => Some(fills),
        _ => None,
    };
    let at_receiver = filled.and_then(|port| declared(receiver, port));
    let outputs = plan.federates.iter().filter(|federate| federate.id == sender);
    let source = outputs.flat_map(|sender| sender.outputs.iter().map(move |output| (sender, output)));
    let source = source.filter(|(_, output)| output.federate == receiver.id && usize::from(output.port) == port);
    let source = source.map(|(sender, output)| (sender, output.source)).next();
    let is_image = |federate: &Federate| deployment.place(&federate.name).platform != Platform::Host;
    let at_sender = source.filter(|(sender, _)| is_image(sender) && !is_image(receiver));
    let at_sender = at_sender.and_then(|(sender, port)| declared(sender, port));
    Payload { ty: &input.ty, declared: at_sender.or(at_receiver) }
}

/// The class and the name of a port.
fn declared(federate: &Federate, port: PortIndex) -> Option<(ClassIndex, &str)> {
    let (owner, name) = federate.ports[port.0].path.rsplit_once('.')?;
    let instance = federate.instances.iter().find(|instance| instance.path == owner)?;
    Some((instance.class, name))
}

/// Emits the module.
pub(super) fn emit(
    plan: &Plan,
    payloads: &Payloads<'_>,
    layout: &Layout,
    rti: &Rti,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let about = format!(" The RTI of {}.", plan.name);
    let federation_id = &rti.federation_id;
    let dnet = plan.target.dnet;
    let authenticates = plan.target.authentication;
    let authentication = if authenticates { quote!(Some(lf::rti::AUTHENTICATOR)) } else { quote!(None) };
    let clock_sync = match plan.target.clock_sync {
        ClockSync::Off => quote!(Off),
        ClockSync::Init => {
            let trials = clock_sync_trials(plan);
            quote!(Init { trials: #trials })
        }
        ClockSync::On => {
            let (trials, period) = (clock_sync_trials(plan), interval(plan.target.clock_sync_period_ns));
            quote!(On { trials: #trials, period: #period })
        }
    };
    let log_waits = optional_interval(plan.target.log_waits_ns);
    let logging = log_level(plan.target.logging);
    let lengths = payloads.lengths(plan, layout)?;
    let tokens = quote! {
        #![doc = #about]
        use lf::model::*;
        /// What the RTI knows of the federation; CONFIG_LF_RTI_… has the sizes.
        pub static RTI: lf::rti::Description = lf::rti::Description {
            federation_id: #federation_id,
            authentication: #authentication,
            clock_sync: lf::rti::ClockSync::#clock_sync,
            dnet: #dnet,
            log_waits: #log_waits,
            logging: lf::log::LevelFilter::#logging,
            payload_bytes_max: lf::rti::longest(&[#(#lengths),*]),
        };
    };
    Splices::new(plan).finish(path, tokens)
}
