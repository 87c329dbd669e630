// SPDX-License-Identifier: Apache-2.0
//! The RTI with its memory.

use lf_compiler::plan::{ClockSync as PlannedSync, Plan};
use lf_coordination::clock_sync::RTI_UDP_PORT;
use lf_coordination::heap::{Memory, Sizes};
use lf_coordination::rti::{AfterLoss, ClockSync, Config, RtiEvent};
use lf_model::Payload as _;
use lf_model::time::Interval;
use lf_runtime::platform::{Endpoint, Platform as _};
use lf_runtime::trace::Recording;
use lf_runtime::{Inlet, Outgoing, RtiLoop, RtiSetup, RunError, buffer_bytes};

use lf_testkit::trace::Records;

use crate::program::Value;
use crate::scenario::Scenario;
use crate::world::Virtual;

pub(super) const FEDERATION_ID: &[u8] = b"simulated";
/// The port on which the RTI listens.
pub(super) const PORT: u16 = 15045;
/// Connections beyond one per federate.
const SPARE_CONNECTIONS: usize = 2;

type Log = Box<dyn FnMut(RtiEvent<'_>)>;
/// The RTI's event loop.
pub(super) type Centre<'a> = RtiLoop<'a, 'a, Virtual, Log>;

/// The buffers of all connections of an RTI, in and out.
pub(super) struct RtiBuffers(Vec<(Vec<u8>, Vec<u8>)>);

impl RtiBuffers {
    pub(super) fn new(scenario: &Scenario, federates: usize) -> Self {
        let bytes = buffer_bytes(Value::MAX_LEN, federates) + scenario.conditions.rti.spare;
        Self((0..federates + SPARE_CONNECTIONS).map(|_| (vec![0; bytes], vec![0; bytes])).collect())
    }
}

/// All memory of an RTI.
pub(super) struct RtiMemory<'a> {
    /// The recorder, if the run is recorded.
    records: Option<Records>,
    platform: Virtual,
    log: Log,
    config: Config<'static>,
    memory: Memory,
    inlets: Vec<Inlet<&'a mut [u8]>>,
    outgoings: Vec<Outgoing<&'a mut [u8]>>,
}

impl<'a> RtiMemory<'a> {
    pub(super) fn new(
        scenario: &Scenario,
        plan: &Plan,
        platform: Virtual,
        log: Log,
        buffers: &'a mut RtiBuffers,
        records: Option<Records>,
    ) -> Self {
        let conditions = &scenario.conditions.rti;
        let count = plan.federates.len();
        let connections = buffers.0.len();
        let sizes = Sizes { federates: count, connections, upstream: count, in_transit: conditions.in_transit };
        let config = Config {
            clock_sync: match plan.target.clock_sync {
                PlannedSync::Off => ClockSync::Off,
                PlannedSync::Init => ClockSync::Init { trials: plan.target.clock_sync_trials.into() },
                PlannedSync::On => ClockSync::On {
                    trials: plan.target.clock_sync_trials.into(),
                    period: Interval::from_nanos(plan.target.clock_sync_period_ns),
                },
            },
            authentication: plan.target.authentication.then_some(lf_runtime::AUTHENTICATOR),
            start_time_multiple: conditions.start_time_multiple.map(Interval::from_nanos),
            dnet: conditions.dnet,
            window: conditions.window,
            transients: u16::try_from(plan.transients()).unwrap_or(u16::MAX),
            after_loss: if conditions.stop_all_after_loss { AfterLoss::StopAll } else { AfterLoss::GoOn },
            ..Config::new(FEDERATION_ID, Value::MAX_LEN)
        };
        let buffers =
            buffers.0.iter_mut().map(|(input, output)| (Inlet::new(&mut input[..]), Outgoing::new(&mut output[..])));
        let (inlets, outgoings) = buffers.unzip();
        Self { records, platform, log, config, memory: Memory::new(sizes), inlets, outgoings }
    }

    /// Starts the RTI.
    pub(super) fn begin(&'a mut self) -> Result<Centre<'a>, RunError> {
        let datagrams = match self.config.clock_sync {
            ClockSync::On { .. } => Some(self.platform.bind(RTI_UDP_PORT).map_err(RunError::Bind)?),
            ClockSync::Off | ClockSync::Init { .. } => None,
        };
        let listener = self.platform.listen(PORT).map_err(|error| RunError::RtiUnreachable {
            address: Endpoint::new(lf_testkit::network::address_of(0), PORT),
            last: Some(error),
        })?;
        let setup = RtiSetup {
            config: self.config,
            storage: self.memory.storage(),
            inlets: &mut self.inlets,
            outgoings: &mut self.outgoings,
            datagrams,
        };
        let centre = RtiLoop::new(&mut self.platform, setup, listener, &mut self.log);
        let mut centre = centre.expect("the memory is made for the configuration");
        if let Some(records) = &mut self.records {
            centre.record(Recording::new(records, true));
        }
        Ok(centre)
    }
}
