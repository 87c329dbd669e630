// SPDX-License-Identifier: Apache-2.0
//! Pins by Zephyr's drivers.

use core::ffi::c_int;

use lf_devices::{Device, DeviceError, Edge, EventPoster, Pin, Problem};
use lf_model::PhysicalLink;

use super::interrupts::{Source, Watch};
use super::spec::{Spec, outcome};
use crate::raw;

/// A pin that is driven: see [`lf_devices::Output`].
pub type Output = lf_devices::Output<Gpio>;
/// A pin that is read: see [`lf_devices::Input`].
pub type Input = lf_devices::Input<Gpio>;

/// A pin of the devicetree, which has not been set up yet.
#[derive(Clone, Copy, Debug)]
pub struct Gpio {
    name: &'static str,
    spec: &'static Spec<raw::gpio_dt_spec>,
}

impl Gpio {
    pub(crate) const fn new(name: &'static str, spec: &'static Spec<raw::gpio_dt_spec>) -> Self {
        Self { name, spec }
    }

    /// Makes it an output, which is inactive at first.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or refuses.
    pub fn output(self) -> Result<Output, DeviceError> {
        Output::new(self, false)
    }

    /// Makes it an output, which is active at first.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or refuses.
    pub fn output_active(self) -> Result<Output, DeviceError> {
        Output::new(self, true)
    }

    /// Makes it an input, with the pull resistors of the devicetree.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or refuses.
    pub fn input(self) -> Result<Input, DeviceError> {
        Input::new(self)
    }

    fn raw(self) -> *const raw::gpio_dt_spec {
        self.spec.raw()
    }
}

impl Device for Gpio {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl Pin for Gpio {
    type Watch = Watch<Edges>;

    fn is_active_low(&self) -> bool {
        // SAFETY: the pin is a constant of C; so it is in all calls here.
        unsafe { raw::lf_pin_is_active_low(self.raw()) }
    }

    fn configure_output(&self, active: bool) -> Result<(), Problem> {
        // SAFETY: see above.
        outcome(unsafe { raw::lf_pin_output(self.raw(), active) }).map(drop)
    }

    fn configure_input(&self) -> Result<(), Problem> {
        // SAFETY: see above.
        outcome(unsafe { raw::lf_pin_input(self.raw()) }).map(drop)
    }

    fn set(&self, active: bool) -> Result<(), Problem> {
        // SAFETY: see above; the pin was configured, so its driver is there.
        outcome(unsafe { raw::lf_pin_set(self.raw(), active) }).map(drop)
    }

    fn is_active(&self) -> Result<bool, Problem> {
        // SAFETY: see above; the pin was configured, so its driver is there.
        outcome(unsafe { raw::lf_pin_get(self.raw()) }).map(|level| level > 0)
    }

    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem> {
        Watch::new(self.name, Edges { pin: self.spec, edge }, link, poster)
    }
}

/// The edges of a pin.
#[derive(Debug)]
pub struct Edges {
    pin: &'static Spec<raw::gpio_dt_spec>,
    edge: Edge,
}

impl Source for Edges {
    fn begin(&self, slot: usize, handler: raw::lf_device_handler) -> c_int {
        let edge = match self.edge {
            Edge::ToActive => raw::lf_edge::LF_EDGE_TO_ACTIVE,
            Edge::ToInactive => raw::lf_edge::LF_EDGE_TO_INACTIVE,
            Edge::Both => raw::lf_edge::LF_EDGE_BOTH,
        };
        // SAFETY: the slot is below CONFIG_LF_INTERRUPTS and was free, the pin is a constant of C, and the handler can
        // be called at any time.
        unsafe { raw::lf_pin_watch(slot, self.pin.raw(), edge, handler) }
    }

    fn end(&self, slot: usize) {
        // SAFETY: this slot is watched.
        unsafe { raw::lf_pin_unwatch(slot) };
    }
}
