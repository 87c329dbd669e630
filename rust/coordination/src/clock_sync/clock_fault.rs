// SPDX-License-Identifier: Apache-2.0
//! The problems that a federate's clock can have, in words.

use core::fmt;

use lf_model::time::Interval;
use lf_texts::say;

use super::correction::DRIFT_PPB_MAX;

/// The reason why a federate's times are worse than those of others.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ClockFault {
    /// Its clock has a rate that no oscillator has: the RTI's is this much faster, in parts per billion.
    Drift(i32),
    /// The rate of its clock changes so quickly that times were wrong by this much.
    Unsteady(Interval),
    /// Rounds come from two UDP ports of the RTI's address; only those of the first one count.
    OtherPort {
        /// The port whose rounds count.
        port: u16,
        /// The other port.
        other: u16,
    },
    /// A time of the RTI's is this far off the own clock, and was ignored.
    FarOff(Interval),
}

impl fmt::Display for ClockFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Drift(ppb) => {
                let verb = if ppb > 0 { "loses" } else { "gains" };
                say!(f, "the own clock {verb} {} us in a second, ", ppb.unsigned_abs() / 1_000)?;
                if ppb.unsigned_abs() > DRIFT_PPB_MAX.unsigned_abs() {
                    say!(f, "more than can be corrected, so times of this federate are wrong")?;
                } else {
                    say!(f, "more than any oscillator; it is corrected as long as this federate runs")?;
                }
                say!(f, ": check the frequency that it is configured with (CONFIG_SYS_CLOCK_HW_CYCLES_PER_SEC)")
            }
            Self::Unsteady(off) => say!(
                f,
                "the rate of the own clock changes so quickly that times were off by {} us, as on a simulated board \
                 whose computer is busy: give that less to do, or compare clocks more often (the `period` of \
                 clock-sync-options)",
                off.as_nanos() / 1_000
            ),
            Self::OtherPort { port, other } => say!(
                f,
                "clock synchronization: datagrams from port {other} of the RTI's address are ignored, because rounds \
                 come from port {port}: another program there sends them, or makes up the address"
            ),
            Self::FarOff(off) => say!(
                f,
                "clock synchronization: a time that is {} s off the own clock is ignored: another program sends it, or \
                 one of the two computers was asleep",
                off.as_nanos() / 1_000_000_000
            ),
        }
    }
}
