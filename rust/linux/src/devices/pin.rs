// SPDX-License-Identifier: Apache-2.0
//! Pins by the simulation.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use lf_devices::{DeviceError, Edge, EdgePoster, Pin, Problem};
use lf_model::time::{Instant, Interval};
use lf_model::{Outside, PhysicalLink};
use lf_runtime::{DeviceRemark, tell};
use log::Level;

use super::simulation::Simulation;
use crate::outside::HostOutside;

/// A pin that is driven: see [`lf_devices::Output`].
pub type Output = lf_devices::Output<Gpio>;
/// A pin that is read: see [`lf_devices::Input`].
pub type Input = lf_devices::Input<Gpio>;

/// A pin, which has not been set up yet.
#[derive(Clone, Copy, Debug)]
pub struct Gpio {
    name: &'static str,
}

impl Gpio {
    /// What `device!` gives.
    #[doc(hidden)]
    pub const fn named(name: &'static str) -> Self {
        Self { name }
    }

    /// Makes it an output, which is inactive at first.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing, is not ready or refuses.
    pub fn output(self) -> Result<Output, DeviceError> {
        Output::new(self, false)
    }

    /// Makes it an output, which is active at first.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing, is not ready or refuses.
    pub fn output_active(self) -> Result<Output, DeviceError> {
        Output::new(self, true)
    }

    /// Makes it an input.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing, is not ready or refuses.
    pub fn input(self) -> Result<Input, DeviceError> {
        Input::new(self)
    }
}

impl Pin for Gpio {
    type Watch = Watch;

    fn name(&self) -> &'static str {
        self.name
    }

    fn is_active_low(&self) -> bool {
        false
    }

    fn configure_output(&self, active: bool) -> Result<(), Problem> {
        self.set(active)
    }

    fn configure_input(&self) -> Result<(), Problem> {
        Simulation::of_program().reads(self.name);
        Ok(())
    }

    fn set(&self, active: bool) -> Result<(), Problem> {
        Simulation::of_program().drives(self.name, active);
        Ok(())
    }

    fn is_active(&self) -> Result<bool, Problem> {
        Ok(Simulation::of_program().is_active(self.name))
    }

    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EdgePoster) -> Result<Watch, Problem> {
        let (alive, ended) = channel::<()>();
        let name = self.name;
        let run = move || {
            let start = link.get_start_time();
            let changes = Simulation::of_program().changes(name);
            let now = link.get_physical_time();
            let mut lost = 0;
            for &(offset, active) in changes.iter().filter(|(offset, active)| edge.is(*active) && start + *offset > now)
            {
                if !wait_until(start + offset, &ended) {
                    break;
                }
                if poster.post(active).is_err() {
                    lost += 1;
                } else if lost > 0 {
                    tell_of_lost(name, std::mem::take(&mut lost));
                }
            }
            tell_of_lost(name, lost);
        };
        let thread = thread::Builder::new().name(name.to_owned()).spawn(run);
        thread.map(|_| Watch { _alive: alive }).map_err(|error| Problem::Failed(error.raw_os_error().unwrap_or(0)))
    }
}

/// The interrupts of a pin, until this is dropped.
#[derive(Debug)]
pub struct Watch {
    /// When it is gone the thread ends that makes them.
    _alive: Sender<()>,
}

/// Waits for a physical time; `false` when the watch has ended before.
fn wait_until(time: Instant, ended: &std::sync::mpsc::Receiver<()>) -> bool {
    loop {
        let left = time.since(HostOutside::of_program().physical_time());
        if left <= Interval::ZERO {
            return true;
        }
        let left = Duration::from_nanos(u64::try_from(left.as_nanos()).unwrap_or(0));
        if ended.recv_timeout(left) == Err(RecvTimeoutError::Disconnected) {
            return false;
        }
    }
}

fn tell_of_lost(device: &'static str, events: u32) {
    if events > 0 {
        tell(Level::Warn, &DeviceRemark::EventsLost { device, events });
    }
}
