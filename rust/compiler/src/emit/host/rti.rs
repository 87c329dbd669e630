// SPDX-License-Identifier: Apache-2.0
//! The module of an image's RTI: its description of the federation.
//!
//! All numbers are in the Kconfig fragment, where users can raise them. But only the program's types know the length of
//! messages, and preambles declare some of these types.

use lf_model::time::Interval;
use quote::quote;

use super::description::log_level;
use super::print::{Fields, interval, optional_ns};
use super::splice::Splices;
use crate::emit::{EmitError, File, FileMap, Job};
use crate::plan::{ClockSync, Rti};

/// Emits the module of an RTI that forwards payloads of these lengths, which are expressions.
pub(super) fn emit(
    job: &Job<'_>,
    mut lengths: Vec<String>,
    deployed: &Rti,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let plan = job.plan();
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
         /// The RTI's description of the federation; CONFIG_LF_RTI_… has the sizes.\n\
         pub static RTI: Description = {};\n",
        rti.block()
    ));
    splices.finish(path, quote! { #![doc = #about] #text })
}
