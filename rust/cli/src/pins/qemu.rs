// SPDX-License-Identifier: Apache-2.0
//! QEMU's traces of the pins of its boards, by the computer's clock: lines such as
//!
//! ```text
//! 17791@1795560628.161624:pl061_set_output /machine/unattached/device[13] setting output 0 to 1
//! ```

use std::collections::BTreeMap;

use lf_linux::devices::recording::{Changes, Recording, Signal};
use lf_linux::model::time::{Instant, Interval};

/// A line of QEMU about a controller of pins.
struct QemuLine<'t> {
    time: Instant,
    event: &'t str,
    /// The path of the controller in QEMU's tree of devices.
    path: &'t str,
    rest: &'t str,
}

impl<'t> QemuLine<'t> {
    fn read(line: &'t str) -> Option<Self> {
        let (before, after) = line.split_once(':')?;
        let (seconds, micros) = before.split_once('@')?.1.split_once('.')?;
        let (seconds, micros): (i64, i64) = (seconds.parse().ok()?, micros.parse().ok()?);
        let (event, after) = after.split_once(' ')?;
        let (path, rest) = after.split_once(' ')?;
        let nanoseconds = seconds.checked_mul(1_000_000_000)?.checked_add(micros.checked_mul(1000)?)?;
        Some(Self { time: Instant::from_nanos(nanoseconds), event, path, rest })
    }

    /// Returns the pin and its level, for an output that changes.
    fn output(&self) -> Option<(u32, bool)> {
        let (pin, level) = self.rest.strip_prefix("setting output ")?.split_once(" to ")?;
        Some((pin.parse().ok()?, level.trim() == "1"))
    }
}

/// Converts QEMU's trace of a board that has started at a time to a recording. Pins have their names in the devicetree,
/// where the controllers are in the order in which QEMU makes them: `gpio5_0`. Levels are electrical.
pub(super) fn recording(name: &str, trace: &str, start: Option<Instant>) -> Recording {
    let lines: Vec<QemuLine<'_>> = trace.lines().filter_map(QemuLine::read).collect();
    // Each is reset once at the beginning; the numbers at the ends of paths are in the order of creation.
    let mut controllers: Vec<&str> =
        lines.iter().filter(|line| line.event == "pl061_reset").map(|line| line.path).collect();
    controllers.sort_by_key(|path| (path.len(), *path));
    controllers.dedup();
    let start = start.or_else(|| lines.first().map(|line| line.time));
    let since = |time: Instant| start.map_or(Interval::ZERO, |start| time.since(start));
    let mut pins: BTreeMap<String, Changes> = BTreeMap::new();
    for line in lines.iter().filter(|line| line.event == "pl061_set_output") {
        let port = controllers.iter().position(|path| *path == line.path);
        if let Some((port, (pin, active))) = port.zip(line.output()) {
            let changes = pins.entry(format!("gpio{port}_{pin}")).or_default();
            changes.push((since(line.time), Signal::Level(active)));
        }
    }
    Recording { federate: name.to_owned(), start, pins: pins.into_iter().collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As QEMU 7.2 writes it.
    const TRACE: &str = "\
17783@1795560628.137180:pl061_input_change /machine/unattached/device[13] input 1 changed to 1
17783@1795560628.138240:pl061_reset /machine/unattached/device[10] reset
17783@1795560628.138242:pl061_reset /machine/unattached/device[9] reset
17791@1795560628.161624:pl061_set_output /machine/unattached/device[10] setting output 0 to 1
something else: that is no trace
17791@1795560628.398694:pl061_set_output /machine/unattached/device[10] setting output 0 to 0
";

    #[test]
    fn outputs_are_found_by_the_order_of_controllers() {
        let start = Instant::from_nanos(1_795_560_628_161_000_000);
        let level = |nanos, active| (Interval::from_nanos(nanos), Signal::Level(active));
        let expected = vec![("gpio1_0".to_owned(), vec![level(624_000, true), level(237_694_000, false)])];
        let recording = recording("board", TRACE, Some(start));
        assert_eq!((recording.start, recording.pins), (Some(start), expected));
    }
}
