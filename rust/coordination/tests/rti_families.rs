// SPDX-License-Identifier: Apache-2.0
//! Federates that have come over IPv4 and IPv6 find each other.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

use lf_coordination::IpAddress;
use lf_testkit::messages::encoded;
use lf_testkit::rti::dialogue::{config, hello_from};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{ADDRESS_PORT_UNKNOWN, Message};
use proptest::prelude::*;

const PORT: i32 = 4711;
const UNKNOWN: Message<'static> = Message::AddressQueryReply { port: ADDRESS_PORT_UNKNOWN, address: [0; 4] };

/// Returns the messages to the first federate when it asks for the address of the second one; they have come from these
/// addresses.
fn reply(asking: IpAddress, asked: IpAddress, times: usize) -> (Rig, Vec<u8>) {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    let (first, second) = (hello_from(&mut rig, 0, asking), hello_from(&mut rig, 1, asked));
    rig.message(second, &Message::AddressAdvertisement { port: PORT });
    for _ in 0..times {
        rig.message(first, &Message::AddressQuery { federate: 1, is_transient: Some(false) });
    }
    let bytes = rig.take(first, usize::MAX);
    (rig, bytes)
}

fn told(asking: IpAddr, asked: IpAddr) -> Vec<u8> {
    reply(asking.into(), asked.into(), 1).1
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// A federate that has come over IPv4, like every stock federate, receives no other message than it knows.
    #[test]
    fn over_ipv4_only_addresses_of_ipv4_are_told(asking: Ipv4Addr, asked: IpAddr) {
        let expected = match IpAddress::from(asked) {
            IpAddress::V4(asked) => Message::AddressQueryReply { port: PORT, address: asked.octets() },
            IpAddress::V6(asked, _) if asked.is_loopback() && asking.is_loopback() => return Ok(()),
            IpAddress::V6(..) => UNKNOWN,
        };
        prop_assert_eq!(told(asking.into(), asked), encoded(&expected));
    }

    #[test]
    fn over_ipv6_addresses_of_both_families_are_told(asking: Ipv6Addr, asked: IpAddr) {
        prop_assume!(asking.to_ipv4_mapped().is_none());
        let expected = match IpAddress::from(asked) {
            IpAddress::V4(asked) => Message::AddressQueryReply { port: PORT, address: asked.octets() },
            IpAddress::V6(asked, scope) => {
                Message::AddressQueryReplyIpv6 { port: PORT, address: asked.octets(), scope }
            }
        };
        prop_assert_eq!(told(asking.into(), asked), encoded(&expected));
    }
}

/// Both loopback addresses are those of one computer, and federates listen at both.
#[test]
fn a_federate_of_the_same_computer_is_found_over_either_family() {
    let expected = Message::AddressQueryReply { port: PORT, address: [127, 0, 0, 1] };
    assert_eq!(told(Ipv4Addr::LOCALHOST.into(), Ipv6Addr::LOCALHOST.into()), encoded(&expected));
}

/// It asks again and again, but the reason why it cannot receive the address is logged once, with advice.
#[test]
fn a_federate_that_cannot_be_told_an_address_is_named_once_with_advice() {
    let far = "fd00::7".parse::<Ipv6Addr>().expect("an address");
    let (rig, bytes) = reply(IpAddress::V4(Ipv4Addr::LOCALHOST), IpAddress::v6(far, 0), 5);
    assert_eq!(bytes, encoded(&UNKNOWN).repeat(5));
    let said: Vec<_> = rig.outlet.log_events.iter().filter(|event| event.contains("IPv6")).collect();
    let expected = "federate 0 sends to federate 1 directly, but cannot be told its IPv6 address over IPv4: start both \
                    with the RTI's address in the same family, `--rti` or `at`";
    assert_eq!(said, [expected]);
}

/// The number of the RTI's interface goes with a link-local address: what it is good for is the receiver's business.
#[test]
fn a_link_local_address_goes_with_its_scope() {
    let near: Ipv6Addr = "fe80::7".parse().expect("an address");
    let (_, bytes) = reply(IpAddress::v6(near, 3), IpAddress::v6(near, 4), 1);
    let expected = Message::AddressQueryReplyIpv6 { port: PORT, address: near.octets(), scope: 4 };
    assert_eq!(bytes, encoded(&expected));
}
