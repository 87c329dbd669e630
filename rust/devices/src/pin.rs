// SPDX-License-Identifier: Apache-2.0
//! Pins: outputs and inputs.

use core::fmt;

use embedded_hal::digital::{ErrorType, InputPin, OutputPin, StatefulOutputPin};
use lf_model::{PhysicalActionRef, PhysicalLink, ReactionContext};

use crate::error::{Device, DeviceError, Problem};
use crate::interrupt::{self, Edge, EventPoster, EventValue};

/// The platform's interface of a pin. Levels are logical.
pub trait Pin: Device {
    /// A value that ends the interrupts of a pin when it is dropped.
    type Watch: fmt::Debug;

    /// Returns whether it is low while it is active.
    fn is_active_low(&self) -> bool;
    /// Makes it an output.
    ///
    /// # Errors
    /// When its driver refuses.
    fn configure_output(&self, active: bool) -> Result<(), Problem>;
    /// Makes it an input.
    ///
    /// # Errors
    /// When its driver refuses.
    fn configure_input(&self) -> Result<(), Problem>;
    /// Drives it.
    ///
    /// # Errors
    /// When its driver refuses.
    fn set(&self, active: bool) -> Result<(), Problem>;
    /// Reads it.
    ///
    /// # Errors
    /// When its driver refuses.
    fn is_active(&self) -> Result<bool, Problem>;
    /// Posts at each such change, until the result is dropped, which also keeps the link. Posts without room are
    /// counted and logged.
    ///
    /// # Errors
    /// When its driver refuses, or there is no room for another watch.
    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem>;
}

/// A pin that is driven.
///
/// The methods of `embedded-hal`'s traits are electrical, the others logical.
#[derive(Debug)]
pub struct Output<P> {
    pin: P,
    active: bool,
}

impl<P: Pin> Output<P> {
    /// Makes the pin an output, which is active from the beginning or not.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn new(pin: P, active: bool) -> Result<Self, DeviceError> {
        pin.named(pin.configure_output(active))?;
        Ok(Self { pin, active })
    }

    /// Makes it active, or inactive.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn set(&mut self, active: bool) -> Result<(), DeviceError> {
        self.pin.named(self.pin.set(active))?;
        self.active = active;
        Ok(())
    }

    /// Makes it active.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn on(&mut self) -> Result<(), DeviceError> {
        self.set(true)
    }

    /// Makes it inactive.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn off(&mut self) -> Result<(), DeviceError> {
        self.set(false)
    }

    /// Inverts it. `OutputPin` of embedded-hal has a method of this name, too, which does the same.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn toggle(&mut self) -> Result<(), DeviceError> {
        self.set(!self.active)
    }

    /// Returns whether it was last made active.
    pub fn is_on(&self) -> bool {
        self.active
    }
}

impl<P: Pin> ErrorType for Output<P> {
    type Error = DeviceError;
}

impl<P: Pin> OutputPin for Output<P> {
    fn set_low(&mut self) -> Result<(), DeviceError> {
        self.set(self.pin.is_active_low())
    }
    fn set_high(&mut self) -> Result<(), DeviceError> {
        self.set(!self.pin.is_active_low())
    }
}

impl<P: Pin> StatefulOutputPin for Output<P> {
    fn is_set_high(&mut self) -> Result<bool, DeviceError> {
        Ok(self.active != self.pin.is_active_low())
    }
    fn is_set_low(&mut self) -> Result<bool, DeviceError> {
        Ok(self.active == self.pin.is_active_low())
    }
}

/// A pin that is read.
///
/// The methods of `embedded-hal`'s trait are electrical, the others logical.
#[derive(Debug)]
pub struct Input<P: Pin> {
    pin: P,
    watch: Option<P::Watch>,
}

impl<P: Pin> Input<P> {
    /// Makes the pin an input.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn new(pin: P) -> Result<Self, DeviceError> {
        pin.named(pin.configure_input())?;
        Ok(Self { pin, watch: None })
    }

    /// Returns whether it is active.
    ///
    /// # Errors
    /// When the pin's driver refuses.
    pub fn is_active(&self) -> Result<bool, DeviceError> {
        self.pin.named(self.pin.is_active())
    }

    /// Schedules the action at each such change from now on, at the time of its interrupt. Replaces an earlier call;
    /// earlier edges are dropped.
    ///
    /// A change without room in the action's queue is counted, and the event loop logs it. While the input lives, a
    /// program without events does not end.
    ///
    /// # Errors
    /// When the pin's driver cannot do it, or there is no room for another such input.
    pub fn on_edge<T: EventValue<bool>>(
        &mut self,
        edge: Edge,
        ctx: &ReactionContext<'_>,
        action: &PhysicalActionRef<T>,
    ) -> Result<(), DeviceError> {
        interrupt::begin(&mut self.watch, ctx, action, |link, poster| {
            self.pin.named(self.pin.watch(edge, link, poster))
        })
    }

    /// Stops scheduling at edges.
    pub fn ignore_edges(&mut self) {
        self.watch = None;
    }
}

impl<P: Pin> ErrorType for Input<P> {
    type Error = DeviceError;
}

impl<P: Pin> InputPin for Input<P> {
    fn is_high(&mut self) -> Result<bool, DeviceError> {
        Ok(self.is_active()? != self.pin.is_active_low())
    }
    fn is_low(&mut self) -> Result<bool, DeviceError> {
        Ok(self.is_active()? == self.pin.is_active_low())
    }
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::*;

    /// A pin that is low while it is active, and stores its level.
    #[derive(Debug, Default)]
    struct Inverted {
        active: Cell<bool>,
    }

    impl Device for &Inverted {
        fn name(&self) -> &'static str {
            "inverted"
        }
    }

    impl Pin for &Inverted {
        type Watch = ();
        fn is_active_low(&self) -> bool {
            true
        }
        fn configure_output(&self, active: bool) -> Result<(), Problem> {
            self.set(active)
        }
        fn configure_input(&self) -> Result<(), Problem> {
            Err(Problem::NotReady)
        }
        fn set(&self, active: bool) -> Result<(), Problem> {
            self.active.set(active);
            Ok(())
        }
        fn is_active(&self) -> Result<bool, Problem> {
            Ok(self.active.get())
        }
        fn watch(&self, _: Edge, _: PhysicalLink, _: EventPoster) -> Result<(), Problem> {
            Err(Problem::NotSupported)
        }
    }

    #[test]
    fn embedded_hal_is_electrical_and_the_rest_is_logical() {
        let pin = Inverted::default();
        let mut output = Output::new(&pin, false).expect("it can be an output");
        assert_eq!(output.is_set_high(), Ok(true));
        output.on().expect("it can be driven");
        assert!(pin.active.get());
        assert_eq!(output.is_set_low(), Ok(true));
        output.set_high().expect("it can be driven");
        assert!(!pin.active.get() && !output.is_on());
        StatefulOutputPin::toggle(&mut output).expect("it can be driven");
        assert!(output.is_on());
        output.toggle().expect("it can be driven");
        assert!(!pin.active.get());
    }

    #[test]
    fn the_error_of_a_driver_names_the_device() {
        let pin = Inverted::default();
        let error = Input::new(&pin).expect_err("it is not ready");
        assert_eq!(error, DeviceError { device: "inverted", problem: Problem::NotReady });
    }
}
