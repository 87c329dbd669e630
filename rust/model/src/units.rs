// SPDX-License-Identifier: Apache-2.0
//! LF's units of time: the one table for programs, command lines and files of bounds.

/// All spellings of the units, shortest unit first, with their lengths in nanoseconds.
pub const UNITS: &[(&[&str], i64)] = &[
    (&["ns", "nsec", "nsecs"], 1),
    (&["us", "usec", "usecs"], 1_000),
    (&["ms", "msec", "msecs"], 1_000_000),
    (&["s", "sec", "secs", "second", "seconds"], 1_000_000_000),
    (&["min", "mins", "minute", "minutes"], 60_000_000_000),
    (&["h", "hour", "hours"], 3_600_000_000_000),
    (&["d", "day", "days"], 86_400_000_000_000),
    (&["wk", "week", "weeks"], 604_800_000_000_000),
];

/// The length of a unit in nanoseconds; `None` if there is no such unit.
pub const fn unit_ns(unit: &str) -> Option<i64> {
    let mut row = 0;
    while row < UNITS.len() {
        let (names, length_ns) = UNITS[row];
        let mut name = 0;
        while name < names.len() {
            if is_same(names[name].as_bytes(), unit.as_bytes()) {
                return Some(length_ns);
            }
            name += 1;
        }
        row += 1;
    }
    None
}

/// As `==`, which constants cannot be worked out with.
const fn is_same(one: &[u8], other: &[u8]) -> bool {
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_is_found_and_nothing_else() {
        for (names, length_ns) in UNITS {
            for name in *names {
                assert_eq!(unit_ns(name), Some(*length_ns), "{name}");
            }
        }
        for other in ["", "m", "n", "nsecss", "S", "fortnight"] {
            assert_eq!(unit_ns(other), None, "{other}");
        }
    }

    #[test]
    fn macros_take_the_same_words() {
        assert_eq!(crate::delay!(2 wk).as_secs(), 1_209_600);
        assert_eq!(crate::delay!(3 nsecs).as_nanos(), 3);
        assert_eq!(crate::tag!(T0 + 1 hour, 3), crate::EventTag::new(crate::delay!(3600 s), 3));
    }
}
