// SPDX-License-Identifier: Apache-2.0
//! The types of the values that an RTI in an image forwards.

use std::collections::BTreeSet;

use lf_model::HandedOver;

use super::layout::Layout;
use super::reactor::{bytes_constant, parsed_type, type_path};
use super::sending::max_len;
use crate::deployment::{Deployment, Platform};
use crate::emit::view::View;
use crate::emit::{EmitError, Job};
use crate::languages::rust::is_copy;
use crate::plan::{ClassIndex, Federate, InputIndex, Plan, Serializer, Type};
use crate::tables::handed_over;

/// The types of all values that the RTI forwards, each once.
#[derive(Default)]
pub(super) struct Payloads<'p> {
    of_ports: Vec<Payload<'p>>,
    /// The states that transient federates hand over, with their classes.
    states: BTreeSet<(ClassIndex, &'p str)>,
}

/// The type of the values of a connection.
struct Payload<'p> {
    ty: &'p Type,
    serializer: Option<&'p Serializer>,
    /// The class of the port at one end, and the port's name, if the type can be spelled.
    declared: Option<(ClassIndex, &'p str)>,
}

impl<'p> Payloads<'p> {
    /// Returns the types of the connections between federates, except for physical ones and those of decentralized
    /// coordination.
    pub(super) fn new(job: &'p Job<'p>) -> Self {
        let mut payloads: Vec<Payload<'p>> = Vec::new();
        for federate in &job.plan().federates {
            for (port, input) in federate.inputs.iter().enumerate().filter(|(_, input)| !input.direct) {
                let Some(payload) = payload(job.view, job.settings.deployment, federate, port, input.federate) else {
                    continue;
                };
                if !payloads.iter().any(|known| known.is_same(&payload)) {
                    payloads.push(payload);
                }
            }
        }
        let states = job.plan().federates.iter().flat_map(|federate| {
            let rows = handed_over(job.plan(), federate).into_iter();
            rows.map(|row| (federate.instances[row.instance.0].class, row.state.name.as_str()))
        });
        Self { of_ports: payloads, states: states.filter(|(class, _)| job.view.is_own(*class)).collect() }
    }

    /// Returns the classes whose types are needed.
    pub(super) fn classes(&self) -> BTreeSet<ClassIndex> {
        let of_ports = self.of_ports.iter().filter(|payload| !is_copy(&payload.ty.text));
        let of_ports = of_ports.filter_map(|payload| Some(payload.declared?.0));
        of_ports.chain(self.states.iter().map(|(class, _)| *class)).collect()
    }

    /// Returns the maximum lengths of their values, as expressions.
    pub(super) fn lengths(&self, plan: &Plan, layout: &Layout<'_>) -> Result<Vec<String>, EmitError> {
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
        let state = |(class, name): &(ClassIndex, &str)| {
            let bytes = bytes_constant(name);
            Ok(format!("{} + {}::{bytes}", HandedOver::ID_BYTES, layout.module_path(*class)))
        };
        self.of_ports.iter().map(length).chain(self.states.iter().map(state)).collect()
    }
}

impl Payload<'_> {
    /// Returns whether it certainly has the same length as another one.
    fn is_same(&self, other: &Self) -> bool {
        let copied = is_copy(&self.ty.text) || self.declared == other.declared;
        copied && self.ty.text == other.ty.text && self.serializer == other.serializer
    }
}

/// Returns the type of an input from another federate, if it is one of this language. A preamble's declarations may
/// need a system other than Zephyr, so the type is that of the end in an image, and of the receiver if both are.
fn payload<'p>(
    view: &'p View<'p>,
    deployment: &Deployment,
    receiver: &'p Federate,
    port: usize,
    sender: u16,
) -> Option<Payload<'p>> {
    let input = &receiver.inputs[port];
    let is_known = |federate: &Federate| view.is_own(federate.instances[0].class);
    let at_receiver =
        receiver.filled(input).and_then(|port| receiver.declared_port(port)).filter(|_| is_known(receiver));
    let outputs = view.plan.federates.iter().filter(|federate| federate.id == sender);
    let source = outputs.flat_map(|sender| sender.outputs.iter().map(move |output| (sender, output)));
    let mut source = source
        .filter(|(_, output)| output.federate == receiver.id && output.port == receiver.port_of(InputIndex(port)));
    let source = source.next();
    let is_image = |federate: &Federate| deployment.place(&federate.name).platform != Platform::Host;
    let asked =
        |sender: &Federate| is_known(sender) && (!is_known(receiver) || is_image(sender) && !is_image(receiver));
    let at_sender = source.filter(|(sender, _)| asked(sender));
    let ty = if is_known(receiver) { &input.ty } else { &at_sender?.1.ty };
    let at_sender = at_sender.and_then(|(sender, output)| sender.declared_port(output.source));
    let serializer = input.serializer.as_ref();
    // The length of a serialized value with a bound of its own does not depend on the type.
    let is_number = serializer.is_some_and(|by| by.name.is_some() && by.max_length.is_some());
    let declared = at_sender.or(at_receiver).filter(|_| !is_number);
    Some(Payload { ty, serializer, declared })
}
