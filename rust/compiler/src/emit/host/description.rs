// SPDX-License-Identifier: Apache-2.0
//! The description of a federate for the event loop.

use lf_model::time::Interval;

use super::module::FederateModule;
use super::print::{Fields, grouped, interval, optional_ns};
use crate::plan::{ClockSync, Coordination, Logging, Rti, Trigger, TriggerKind};

impl FederateModule<'_> {
    /// Returns the description, and the names of the runtime that it uses.
    pub(super) fn description(&self) -> (String, Vec<&'static str>) {
        let target = &self.owner.plan.target;
        let mut uses = vec!["Description"];
        let mut description = Fields::of("Description");
        description.set("program", format_args!("{:?}", self.owner.plan.name));
        description.set("name", format_args!("{:?}", self.owner.federate.name));
        description.set_if(target.timeout_ns.is_some(), "timeout", optional_ns(target.timeout_ns));
        // If bodies have links to schedule from outside, and other federates are known, a program without any source of
        // events ends: lfc's Rust target does the same. If any thread may schedule, the program stays for its physical
        // actions.
        let unknown_threads = self.owner.job.view.language.facts().unknown_threads;
        let physical = |trigger: &Trigger| matches!(trigger.kind, TriggerKind::Action { physical: true, .. });
        let may_end = self.rti.is_none() && self.owner.job.view.native.keepalive == Some(false);
        let stays = target.keepalive || !may_end && self.owner.federate.triggers.iter().any(physical);
        let keepalive = unknown_threads && stays;
        description.set_if(keepalive, "keepalive", true).set_if(target.fast, "fast", true);
        description.set_if(target.logging != Logging::Info, "logging", log_level(target.logging));
        let federation = self.rti.as_ref().map(|rti| self.federation(rti, &mut uses));
        description.set_if(federation.is_some(), "federation", "Some(FEDERATION.with_buffers(&TABLES))");
        let mut text = String::new();
        if let Some(federation) = federation {
            text =
                format!("/// Its part in the federation.\nconst FEDERATION: Federation = {};\n\n", federation.block());
        }
        text += "/// The description of this program for the event loop.\n";
        text = text + "pub static DESCRIPTION: Description = " + &description.block() + ";\n";
        uses.sort_unstable();
        (text, uses)
    }

    fn federation(&self, rti: &Rti, uses: &mut Vec<&'static str>) -> Fields {
        let (federate, target) = (self.owner.federate, &self.owner.plan.target);
        uses.push("Federation");
        let mut fields = Fields::of("Federation");
        fields.set("id", federate.id).set("federation_id", format_args!("{:?}", rti.federation_id));
        if target.authentication {
            uses.push("answer_rti");
        }
        fields.set_if(target.authentication, "authentication", "Some(answer_rti)");
        let decentralized = target.coordination == Coordination::Decentralized;
        if decentralized {
            uses.push("Coordination");
        }
        fields.set_if(decentralized, "coordination", "Coordination::Decentralized");
        fields.set("federates", self.owner.plan.federates.len());
        fields.set("rti_host", format_args!("{:?}", rti.host)).set("rti_port", rti.port);
        let upstream = self.owner.tables.upstream.iter().map(|(id, delay_ns)| match delay_ns {
            Some(ns) => format!("({id}, {})", grouped(*ns)),
            None => format!("({id}, DELAY_NONE)"),
        });
        let upstream: Vec<_> = upstream.collect();
        if self.owner.tables.upstream.iter().any(|(_, delay_ns)| delay_ns.is_none()) {
            uses.push("DELAY_NONE");
        }
        fields.set_if(!upstream.is_empty(), "upstream", format_args!("&[{}]", upstream.join(", ")));
        let awaited: Vec<_> = self
            .owner
            .tables
            .awaited
            .iter()
            .map(|(port, level)| format!("AwaitedInput {{ port: {port}, level: {level} }}"))
            .collect();
        if !awaited.is_empty() {
            uses.push("AwaitedInput");
        }
        let lists = [
            ("downstream", federate.downstream.clone()),
            ("peers_in", federate.peers_in()),
            ("peers_out", federate.peers_out()),
            ("transients", self.owner.plan.transient_neighbors(federate)),
        ];
        for (name, ids) in lists {
            fields.set_if(!ids.is_empty(), name, format_args!("&{ids:?}"));
        }
        fields.set_if(!awaited.is_empty(), "awaited", format_args!("&[{}]", awaited.join(", ")));
        // A federate with inputs from a cycle without delay waits there for messages or absences of the others.
        let cycles = self.owner.plan.federates.iter().flat_map(|federate| &federate.inputs).any(|input| input.awaited);
        fields.set_if(cycles && !decentralized, "cycles", true);
        self.options(&mut fields, uses);
        fields
    }

    fn options(&self, fields: &mut Fields, uses: &mut Vec<&'static str>) {
        let (federate, target) = (self.owner.federate, &self.owner.plan.target);
        let (trials, attenuation) = (target.clock_sync_trials, target.clock_sync_attenuation);
        let clock_sync = match target.clock_sync {
            ClockSync::Off => String::new(),
            ClockSync::Init => format!("ClockSync::Init {{ trials: {trials} }}"),
            ClockSync::On => format!("ClockSync::On {{ trials: {trials}, attenuation: {attenuation} }}"),
        };
        if !clock_sync.is_empty() {
            uses.push("ClockSync");
        }
        fields.set_if(!clock_sync.is_empty(), "clock_sync", clock_sync);
        fields.set_if(target.clock_sync_local || self.rti_is_image, "local_clock_sync", true);
        // As in LF, each federate's clock has a different error.
        let times = i64::from(federate.id) + 1;
        let test_offset = Interval::from_nanos(target.clock_sync_test_offset_ns.saturating_mul(times));
        fields.set_if(test_offset != Interval::ZERO, "test_offset", interval(test_offset));
        let depends_on_physical = federate.physical_delay_ns.is_some();
        fields.set_if(depends_on_physical, "physical_delay", optional_ns(federate.physical_delay_ns));
        let advance_interval = interval(Interval::from_nanos(target.advance_interval_ns));
        fields.set_if(depends_on_physical, "advance_interval", advance_interval);
        fields.set_if(target.log_waits_ns.is_some(), "log_waits", optional_ns(target.log_waits_ns));
        // `with_buffers` adds the rest.
        fields.set_if(false, "input_bytes", 0);
    }
}

/// Returns the log level, as the `log` crate calls it.
pub(super) fn log_level(logging: Logging) -> &'static str {
    match logging {
        Logging::Error => "lf::log::LevelFilter::Error",
        Logging::Warn => "lf::log::LevelFilter::Warn",
        Logging::Info => "lf::log::LevelFilter::Info",
        Logging::Log => "lf::log::LevelFilter::Debug",
        Logging::Debug => "lf::log::LevelFilter::Trace",
    }
}
