// SPDX-License-Identifier: Apache-2.0
//! Addresses in sentences.

use core::fmt;
use core::net::Ipv4Addr;

use lf_texts::say;

/// An address as it is shown in sentences: `10.0.0.1`, as by its own `Display`, which takes half a KiB of flash because
/// it can be given a width.
#[derive(Clone, Copy, Debug)]
pub struct Dotted(pub Ipv4Addr);

impl fmt::Display for Dotted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second, third, fourth] = self.0.octets();
        say!(f, "{first}.{second}.{third}.{fourth}")
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString as _;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn addresses_look_as_anywhere_else(address: Ipv4Addr) {
            prop_assert_eq!(Dotted(address).to_string(), address.to_string());
        }
    }
}
