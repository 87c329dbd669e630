// SPDX-License-Identifier: Apache-2.0
//! Channels of PWM by Zephyr's drivers.

use lf_devices::{Device, DeviceError, Problem, PwmChannel};

use super::spec::{Spec, outcome};
use crate::raw;

/// A channel of PWM: see [`lf_devices::Pwm`].
pub type Pwm = lf_devices::Pwm<PwmNode>;

/// A channel of PWM of the devicetree, which has not been set up yet.
#[derive(Clone, Copy, Debug)]
pub struct PwmNode {
    name: &'static str,
    spec: &'static Spec<raw::pwm_dt_spec>,
}

impl PwmNode {
    pub(crate) const fn new(name: &'static str, spec: &'static Spec<raw::pwm_dt_spec>) -> Self {
        Self { name, spec }
    }

    /// Opens it.
    ///
    /// # Errors
    /// When its driver is missing or is not ready.
    pub fn pwm(self) -> Result<Pwm, DeviceError> {
        Pwm::new(self)
    }

    fn raw(&self) -> *const raw::pwm_dt_spec {
        self.spec.raw()
    }
}

impl Device for PwmNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl PwmChannel for PwmNode {
    fn is_ready(&self) -> Result<(), Problem> {
        // SAFETY: the channel is a constant of C; so it is in all calls here.
        outcome(unsafe { raw::lf_pwm_ready(self.raw()) }).map(drop)
    }

    fn period(&self) -> u32 {
        // SAFETY: see above.
        unsafe { raw::lf_pwm_period(self.raw()) }
    }

    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem> {
        // SAFETY: see above; its driver is ready.
        outcome(unsafe { raw::lf_pwm_set_pulse(self.raw(), nanoseconds) }).map(drop)
    }
}
