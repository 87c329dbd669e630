// SPDX-License-Identifier: Apache-2.0
//! Devices with registers: the first written byte selects one, and further bytes are written or read from there on.

use std::collections::BTreeMap;

use lf_model::time::Interval;

/// The value of an unknown register, as on a bus that no device drives.
const NOTHING: u8 = 0xff;
/// The bit of the first byte of an SPI transfer that reads registers. Most devices use it.
const READ: u8 = 0x80;

/// The registers of a device.
#[derive(Debug, Default)]
pub(super) struct Registers {
    /// The bytes of each register, and since when.
    values: BTreeMap<u8, (Interval, Vec<u8>)>,
    /// The register and the index of its byte that comes next.
    cursor: (u8, usize),
    /// The length in bytes of unknown registers: that of the longest one.
    length: usize,
    pub(super) now: Interval,
}

impl Registers {
    /// Sets the bytes of a register from a time on, unless something was written to it since.
    pub(super) fn becomes(&mut self, register: u8, at: Interval, bytes: &[u8]) {
        self.length = self.length.max(bytes.len());
        let value = self.values.entry(register).or_insert_with(|| (at, bytes.to_vec()));
        if value.0 < at {
            *value = (at, bytes.to_vec());
        }
    }

    /// Writes bytes after a start of the bus.
    pub(super) fn write(&mut self, bytes: &[u8]) {
        let Some((&first, bytes)) = bytes.split_first() else { return };
        self.cursor = (first, 0);
        self.write_on(bytes);
    }

    /// Writes further bytes.
    pub(super) fn write_on(&mut self, bytes: &[u8]) {
        let now = self.now;
        for byte in bytes {
            let (since, next) = self.next();
            *since = now;
            *next = *byte;
        }
    }

    /// Reads bytes.
    pub(super) fn read(&mut self, bytes: &mut [u8]) {
        bytes.fill_with(|| *self.next().1);
    }

    /// Returns the next byte, and since when its register has it.
    fn next(&mut self) -> (&mut Interval, &mut u8) {
        let (mut register, mut byte) = self.cursor;
        if self.values.get(&register).is_some_and(|(_, value)| byte >= value.len()) {
            (register, byte) = (register.wrapping_add(1), 0);
        }
        self.cursor = (register, byte + 1);
        let unknown = || (Interval::from_nanos(i64::MIN), vec![NOTHING; self.length.max(1)]);
        let (since, value) = self.values.entry(register).or_insert_with(unknown);
        (since, &mut value[byte])
    }

    /// Sends a byte and receives one, in an SPI transfer with this first byte, or as its first byte.
    pub(super) fn exchange(&mut self, command: &mut Option<u8>, sent: u8) -> u8 {
        match *command {
            None => {
                *command = Some(sent);
                self.cursor = (sent & !READ, 0);
                NOTHING
            }
            Some(command) if command & READ != 0 => *self.next().1,
            Some(_) => {
                self.write_on(&[sent]);
                NOTHING
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: i64) -> Interval {
        Interval::from_millis(ms)
    }

    /// Returns what a driver reads from this register on.
    fn read<const N: usize>(registers: &mut Registers, first: u8) -> [u8; N] {
        let mut bytes = [0; N];
        registers.write(&[first]);
        registers.read(&mut bytes);
        bytes
    }

    #[test]
    fn registers_keep_their_values_until_the_script_changes_them() {
        let mut registers = Registers::default();
        registers.becomes(0, at(0), &[0x19, 0x80]);
        registers.becomes(3, at(0), &[0x50, 0]);
        registers.now = at(5);
        registers.write(&[3, 0x40, 0x10]);
        registers.write(&[1, 0x01]);
        registers.becomes(3, at(0), &[0x50, 0]);
        assert_eq!(read(&mut registers, 0), [0x19, 0x80]);
        assert_eq!(read(&mut registers, 1), [0x01]);
        assert_eq!(read(&mut registers, 3), [0x40, 0x10]);
        assert_eq!(read(&mut registers, 9), [NOTHING; 2]);
        registers.becomes(3, at(6), &[1, 2]);
        assert_eq!(read(&mut registers, 3), [1, 2]);
    }

    #[test]
    fn registers_of_a_byte_each_are_read_and_written_in_a_row() {
        let mut registers = Registers::default();
        for (register, byte) in (0x10..).zip([1, 2, 3, 4]) {
            registers.becomes(register, at(0), &[byte]);
        }
        assert_eq!(read(&mut registers, 0x11), [2, 3, 4, NOTHING, NOTHING]);
        registers.write(&[0x12, 30, 40]);
        registers.write_on(&[50]);
        assert_eq!(read(&mut registers, 0x11), [2, 30, 40, 50, NOTHING]);
        assert_eq!(read(&mut registers, 0xff), [NOTHING; 2]);
    }

    #[test]
    fn over_spi_a_bit_says_whether_registers_are_read() {
        let mut registers = Registers::default();
        registers.becomes(0, at(0), &[0xd1]);
        let exchange = |registers: &mut Registers, bytes: &[u8]| {
            let mut command = None;
            bytes.iter().map(|byte| registers.exchange(&mut command, *byte)).collect::<Vec<_>>()
        };
        assert_eq!(exchange(&mut registers, &[0x80, 0, 0]), [NOTHING, 0xd1, NOTHING]);
        exchange(&mut registers, &[0x7e, 0x11]);
        assert_eq!(exchange(&mut registers, &[0xfe, 0]), [NOTHING, 0x11]);
    }
}
