// SPDX-License-Identifier: Apache-2.0
//! Outputs that are active for a part of each period.

use core::time::Duration;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};

use crate::error::{Device, DeviceError, Problem};

/// The platform's interface of a channel of PWM.
pub trait PwmChannel: Device {
    /// Checks that it can be used.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    fn is_ready(&self) -> Result<(), Problem>;
    /// Returns the period, in nanoseconds.
    fn period(&self) -> u32;
    /// Makes it active for this many nanoseconds of each period.
    ///
    /// # Errors
    /// When its driver refuses.
    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem>;
}

/// An output that is active for a part of each period: a fan, a servo, a dimmed LED.
///
/// It implements `embedded_hal::pwm::SetDutyCycle`, of which `set_duty_cycle_percent` is the handiest.
#[derive(Debug)]
pub struct Pwm<C> {
    channel: C,
}

impl<C: PwmChannel> Pwm<C> {
    /// Opens the channel; it keeps its state.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    pub fn new(channel: C) -> Result<Self, DeviceError> {
        channel.named(channel.is_ready())?;
        Ok(Self { channel })
    }

    /// Returns the period.
    pub fn period(&self) -> Duration {
        Duration::from_nanos(self.channel.period().into())
    }

    /// Makes it active for this part of each period; always, if `pulse` is longer than a period.
    ///
    /// # Errors
    /// When its driver refuses.
    pub fn set_pulse(&mut self, pulse: Duration) -> Result<(), DeviceError> {
        let period = self.channel.period();
        let pulse = u32::try_from(pulse.as_nanos()).map_or(period, |pulse| pulse.min(period));
        self.channel.named(self.channel.set_pulse(pulse))
    }
}

impl<C: PwmChannel> ErrorType for Pwm<C> {
    type Error = DeviceError;
}

impl<C: PwmChannel> SetDutyCycle for Pwm<C> {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), DeviceError> {
        let pulse = u64::from(self.channel.period()) * u64::from(duty) / u64::from(u16::MAX);
        self.set_pulse(Duration::from_nanos(pulse))
    }
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::*;

    /// A channel that stores its pulse.
    #[derive(Debug, Default)]
    struct Remembered(Cell<u32>);

    impl Device for &Remembered {
        fn name(&self) -> &'static str {
            "fan"
        }
    }

    impl PwmChannel for &Remembered {
        fn is_ready(&self) -> Result<(), Problem> {
            Ok(())
        }
        fn period(&self) -> u32 {
            u32::MAX
        }
        fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem> {
            self.0.set(nanoseconds);
            Ok(())
        }
    }

    #[test]
    fn a_duty_cycle_is_a_part_of_the_period() {
        let channel = Remembered::default();
        let mut pwm = Pwm::new(&channel).expect("it is ready");
        for (percent, pulse) in [(0, 0), (100, u32::MAX)] {
            pwm.set_duty_cycle_percent(percent).expect("it can be set");
            assert_eq!(channel.0.get(), pulse);
        }
        pwm.set_duty_cycle(u16::MAX / 3).expect("it can be set");
        assert_eq!(channel.0.get(), u32::MAX / 3);
        pwm.set_pulse(Duration::from_secs(100)).expect("it can be set");
        assert_eq!(channel.0.get(), u32::MAX);
        pwm.set_pulse(Duration::ZERO).expect("it can be set");
        assert_eq!(channel.0.get(), 0);
    }
}
