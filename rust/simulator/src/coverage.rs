// SPDX-License-Identifier: Apache-2.0
//! Counts the features that occurred in runs, which shows that each feature is really tested.

use std::collections::BTreeMap;
use std::fmt;

use lf_model::time::Tag;
use lf_runtime::RunError;

use crate::check::{self, LateCounts};
use crate::run::{FederateEnd, Report};
use crate::scenario::{FaultKind, Reactor, Scenario, has_cycle};

/// The number of runs by feature.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage(pub(crate) BTreeMap<String, u64>);

impl Coverage {
    /// Counts the features of a run.
    pub(crate) fn count(&mut self, scenario: &Scenario, report: &Report) {
        self.count_program(scenario);
        let counts = &report.counts;
        let asked = report.granted.iter().filter(|granted| granted.is_some()).count();
        let failed = |wanted: fn(&RunError) -> bool| {
            report.ends.iter().any(|end| matches!(end, FederateEnd::Ended(Err(error)) if wanted(error)))
        };
        let struck = |kind| report.struck.iter().any(|(_, one)| *one == kind);
        let stop_all = scenario.conditions.rti.stop_all_after_loss;
        for (name, has) in [
            ("run: started", report.started().is_some()),
            ("run: PTAG", counts.provisional > 0),
            ("run: absent", counts.absent > 0),
            ("run: DNET", counts.dnet > 0),
            ("run: stop granted", asked > 0),
            ("run: grants revoked", counts.revoked > 0),
            ("run: cut short", report.cut_short),
            ("run: stop asked for by several", counts.stop_requests > 1),
            ("run: RTI's memory of transit full", report.rti_log.overflow),
            ("run: message late at the RTI", report.rti_log.late),
            ("run: message to one that has left", report.rti_log.dropped),
            ("run: socket full", report.refused_writes > 0),
            ("run: queue full", report.fullest_percent >= 100),
            ("run: InputFull", failed(|error| matches!(error, RunError::InputFull { .. }))),
            ("run: more messages for a tag than a queue holds", failed(|it| matches!(it, RunError::TagFull { .. }))),
            ("run: own capacity too small", check::own_fault(report)),
            (
                "run: physical events",
                report.played.iter().any(|played| played.values().any(|events| !events.is_empty())),
            ),
            ("fault: vanished, others go on", struck(FaultKind::Vanish) && !stop_all),
            ("fault: vanished, all stop", struck(FaultKind::Vanish) && stop_all),
            ("fault: connection broke, others go on", struck(FaultKind::Break) && !stop_all),
            ("fault: connection broke, all stop", struck(FaultKind::Break) && stop_all),
            ("fault: interrupted", struck(FaultKind::Interrupt)),
            ("fault: of the RTI", report.struck.iter().any(|(participant, _)| *participant == 0)),
        ] {
            self.add(name, u64::from(has));
        }
    }

    /// Counts the comings and goings of a run.
    pub(crate) fn count_incarnations(&mut self, scenario: &Scenario, report: &Report) {
        let instances = (0..scenario.instances.len()).filter(|instance| scenario.is_transient(*instance));
        for instance in instances {
            let struck = |kind| report.struck.contains(&(instance + 1, kind));
            let has_begun = report.first[instance].is_some();
            let later = scenario.instances_of(scenario.instances[instance]).find(|other| *other > instance);
            let is_back = has_begun && later.is_some_and(|later| report.first[later].is_some());
            let began_late = report.first[instance] > report.started().map(Tag::at);
            let ended = report.has_ended(instance);
            for (name, has) in [
                ("transient: there from the start on", has_begun && !began_late),
                ("transient: joined later", began_late),
                ("transient: another instance came after it", is_back),
                ("transient: vanished", has_begun && struck(FaultKind::Vanish)),
                ("transient: lost its connections", has_begun && struck(FaultKind::Break)),
                ("transient: stopped by a signal", ended && has_begun && struck(FaultKind::Interrupt)),
                ("transient: found no place", !has_begun),
                ("transient: took over a state", report.handovers[instance].taken.is_some()),
            ] {
                self.add(name, u64::from(has));
            }
        }
    }

    /// Counts the outcomes of the messages of a federation with decentralized coordination.
    pub(crate) fn count_late(&mut self, scenario: &Scenario, report: &Report, counts: &LateCounts) {
        let is_safe = scenario.decentralized.is_some_and(|it| it.is_safe);
        let connections = &scenario.connections;
        let count = scenario.federates.len();
        let has_rounds = scenario.target.rounds.is_some();
        let waits_forever =
            connections.iter().any(|one| one.max_wait.or(scenario.federates[one.to.0].max_wait).is_none());
        for (name, has) in [
            ("decentralized: waits suffice", is_safe),
            ("decentralized: waits suffice, in a cycle", is_safe && has_cycle(count, connections, false)),
            ("decentralized: waits suffice, some are infinite", is_safe && waits_forever),
            ("decentralized: waits suffice, and a stop was granted", is_safe && report.granted_stop().is_some()),
            ("decentralized: waits suffice, with physical actions", is_safe && scenario.has_physical_actions()),
            ("decentralized: waits suffice, with clocks synchronized all the time", is_safe && has_rounds),
            ("decentralized: waits suffice, and something went wrong", is_safe && !report.struck.is_empty()),
            ("decentralized: waits are too short", !is_safe),
            ("decentralized: something was late", counts.late > 0),
            ("decentralized: handlers of late messages ran", report.lateness.iter().any(|it| !it.handlers.is_empty())),
            ("decentralized: @absent_after", connections.iter().any(|one| one.absent_after.is_some())),
        ] {
            self.add(name, u64::from(has));
        }
        for (name, count) in [
            ("messages: in time", counts.in_time),
            ("messages: in time, a microstep after another one for the same tag", counts.bursts),
            ("messages: late", counts.late),
            ("messages: late, behind a late one", counts.behind),
            ("messages: so late that they did not happen", counts.lost),
            ("messages: so late that their receiver was leaving", counts.after_end),
            ("messages: to one that had failed, as their sender says", counts.undelivered),
        ] {
            self.add(name, count);
        }
    }

    fn count_program(&mut self, scenario: &Scenario) {
        let connections = &scenario.connections;
        let conditions = &scenario.conditions;
        let any = |wanted: fn(&Reactor) -> bool| {
            scenario.federates.iter().any(|federate| wanted(federate) || federate.children.iter().any(wanted))
        };
        for (name, has) in [
            ("program: 2 to 4 federates", scenario.federates.len() <= 4),
            ("program: 5 to 8 federates", (5..=8).contains(&scenario.federates.len())),
            ("program: 9 to 12 federates", scenario.federates.len() > 8),
            ("program: cycle of federates", has_cycle(scenario.federates.len(), connections, false)),
            ("program: cycle without delay", has_cycle(scenario.federates.len(), connections, true)),
            ("program: after 0", connections.iter().any(|one| one.after == Some(0))),
            ("program: after some ns", connections.iter().any(|one| one.after.is_some_and(|ns| ns > 0 && ns < 1001))),
            ("program: after more", connections.iter().any(|one| one.after.is_some_and(|ns| ns > 1000))),
            ("program: small @capacity", connections.iter().any(|one| one.capacity.is_some_and(|n| n <= 4))),
            ("program: bank", any(|reactor| reactor.bank.is_some())),
            ("program: modes", any(|reactor| reactor.modes > 0)),
            ("program: contained reactor in a mode", any(|reactor| reactor.mode.is_some())),
            ("program: connection in a mode", any(|it| it.links.iter().any(|link| link.mode.is_some()))),
            ("program: watchdog", any(|reactor| !reactor.watchdogs.is_empty())),
            ("program: multiports, connected to multiports of other federates", scenario.has_wide_connections()),
            ("program: contained reactors", any(|reactor| !reactor.children.is_empty())),
            ("program: physical action", any(|reactor| reactor.actions.iter().any(|action| action.physical))),
            ("program: slow reaction", any(|it| it.reactions.iter().any(|one| one.script.work_ns >= 500_000))),
            ("program: ends by timeout", scenario.target.timeout.is_some()),
            ("program: fast", scenario.target.fast),
            ("program: keepalive", scenario.target.keepalive),
            ("world: clocks synchronized", scenario.target.clock_sync.is_some()),
            ("world: clocks synchronized all the time", scenario.target.rounds.is_some()),
            ("world: clocks drift", conditions.hosts.iter().any(|host| host.clock_drift_ppb != 0)),
            ("world: bytes in pieces", conditions.pieces),
            ("world: a slow link", conditions.hosts.iter().any(|host| host.link.ns_per_byte >= 1000)),
            ("world: sockets of 64 bytes", conditions.hosts.iter().any(|host| host.link.socket_bytes == 64)),
            ("world: no DNET", !conditions.rti.dnet),
        ] {
            self.add(name, u64::from(has));
        }
    }

    pub(crate) fn add(&mut self, name: &str, count: u64) {
        *self.0.entry(name.to_owned()).or_default() += count;
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for (name, count) in &other.0 {
            self.add(name, *count);
        }
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, count) in &self.0 {
            writeln!(f, "{count:>9}  {name}")?;
        }
        Ok(())
    }
}
