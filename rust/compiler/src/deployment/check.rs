// SPDX-License-Identifier: Apache-2.0
//! The rules for a deployment file beyond its keys: plausible and unique addresses, and known names.

use core::net::{IpAddr, Ipv4Addr};
use std::collections::BTreeMap;

use serde_saphyr::{Location, Spanned};

use super::raw::RawPlace;
use super::{BoardNetwork, Mac, Place, Platform, RtiHome, RtiPlace};
use crate::boards::ethernet_label;
use crate::diagnostics::did_you_mean;
use crate::plan::Plan;
use crate::yaml::{FileError, place};

/// The name of the RTI in messages, which no federate can have.
pub(super) const RTI: &str = "the RTI";

/// Collects errors, and values that must not occur twice.
pub(super) struct DeploymentChecker<'a> {
    pub(super) path: &'a str,
    pub(super) errors: Vec<FileError>,
    /// The owner of each address and probe, and the line that names it.
    pub(super) taken: BTreeMap<(&'static str, String), (String, u64)>,
}

impl DeploymentChecker<'_> {
    pub(super) fn error(&mut self, at: Location, message: impl Into<String>, hint: Option<&str>) {
        let (line, column) = place(at);
        let (path, hint) = (self.path.to_owned(), hint.map(str::to_owned));
        self.errors.push(FileError { path, line, column, message: message.into(), hint });
    }

    pub(super) fn known(&mut self, name: &str, at: Location, plan: &Plan) {
        let names = || plan.federates.iter().map(|federate| federate.name.as_str());
        if names().any(|known| known == name) {
            return;
        }
        let what = if plan.is_federated() { "federate" } else { "main reactor" };
        let hint =
            did_you_mean(name, names()).unwrap_or_else(|| format!("it has {}", names().collect::<Vec<_>>().join(", ")));
        self.error(at, format!("{} has no {what} named \"{name}\"", plan.name), Some(&hint));
    }

    pub(super) fn place(&mut self, name: &str, raw: &RawPlace) -> Option<Place> {
        let platform = self.platform(&raw.platform)?;
        let keys = raw.keys();
        if platform == Platform::Host {
            let reason = "a program of this computer uses this computer's network and needs no probe";
            self.refuse_keys(&keys, &raw.platform.value, reason);
            return Some(Place { platform, ..Place::default() });
        }
        if platform.is_native_sim() {
            if raw.ip.is_none() {
                let reason = "without `ip`, a native_sim image uses this computer's network; it needs no probe";
                self.refuse_keys(&keys, &raw.platform.value, reason);
                return Some(Place { platform, ..Place::default() });
            }
            let reason = "a native_sim image is a program of this computer, which is not flashed";
            self.refuse_keys(&keys[5..], &raw.platform.value, reason);
        }
        let network = self.network(name, raw);
        let made_up = || network.filter(|_| platform.is_virtual()).map(|network| Mac::of_virtual_board(network.ip));
        let mac = raw.mac.as_ref().map_or_else(made_up, |mac| self.mac(name, mac));
        if let Some(probe) = &raw.probe {
            self.once("probe", probe.value.clone(), name, probe.referenced);
        }
        let ethernet = raw.ethernet.as_ref().and_then(|label| self.label(label));
        if let (Some(raw_mac), None, Platform::Zephyr(board)) = (&raw.mac, &raw.ethernet, &platform)
            && !platform.is_virtual()
            && ethernet_label(board).is_none()
        {
            let message = format!("`mac`: the devicetree label of the Ethernet MAC of {board} is not known");
            self.error(raw_mac.referenced, message, Some("add `ethernet: LABEL`, as in the board's devicetree"));
        }
        let text = |value: &Option<Spanned<String>>| value.as_ref().map(|text| text.value.clone());
        let (runner, probe) = (text(&raw.runner), text(&raw.probe));
        Some(Place { platform, network, mac, ethernet, runner, probe, restarts: false, spare: None })
    }

    /// Returns the place of the spare board of a federate, whose first board has this place.
    pub(super) fn spare(&mut self, name: &str, raw: &RawPlace, first: &Place, plan: &Plan) -> Option<Place> {
        let Spanned { value: spare, referenced, .. } = raw.spare.as_ref()?;
        let is_transient = plan.federates.iter().any(|federate| federate.name == name && federate.transient);
        let refused = match (first.network, is_transient) {
            // A board without a valid address has its error already.
            (None, _) if raw.ip.is_some() => return None,
            (None, _) => Some((
                format!("`spare` has no meaning for platform {}", raw.platform.value),
                "a program of this computer can run twice where it is",
            )),
            (_, false) => Some((
                format!("`spare`: {name} is not transient, and only such federates are swapped"),
                "write `@transient` before its instance",
            )),
            _ => None,
        };
        if let Some((message, hint)) = refused {
            self.error(*referenced, message, Some(hint));
            return None;
        }
        let network = first.network?;
        let ip = self.address(Some(&spare.ip), "ip")?;
        self.once("IP address", ip.to_string(), name, spare.ip.referenced);
        if !network.contains(ip) {
            let message = format!("the spare's address {ip} is not in the network of {}", network.ip);
            self.error(spare.ip.referenced, message, Some("a spare board takes the place of the first one there"));
        }
        let is_virtual = first.platform.is_virtual();
        let mac = match &spare.mac {
            Some(mac) => self.mac(name, mac),
            None => is_virtual.then(|| Mac::of_virtual_board(ip)),
        };
        if first.mac.is_some() && mac.is_none() && spare.mac.is_none() {
            let hint = "give the spare a `mac` of its own, because the first board has one";
            self.error(*referenced, "`spare`: two boards with one MAC address", Some(hint));
        }
        if let Some(probe) = &spare.probe {
            self.once("probe", probe.value.clone(), name, probe.referenced);
        }
        let probe = spare.probe.as_ref().map(|probe| probe.value.clone());
        Some(Place { network: Some(BoardNetwork { ip, ..network }), mac, probe, ..first.clone() })
    }

    /// Returns whether a federate starts again when it has failed.
    pub(super) fn restarts(&mut self, name: &str, raw: &RawPlace, plan: &Plan) -> bool {
        let Some(restart) = &raw.restart else { return false };
        let restarts = restart.value == "on-failure";
        if !restarts && restart.value != "never" {
            let message = format!("`restart`: \"{}\" is not known", restart.value);
            self.error(restart.referenced, message, Some("write `on-failure`, or `never`, which is the default"));
        }
        let is_transient = plan.federates.iter().any(|federate| federate.name == name && federate.transient);
        if restarts && !is_transient {
            let message = format!("`restart`: {name} is not transient, and a federation takes no such federate back");
            self.error(restart.referenced, message, Some("write `@transient` before its instance"));
        }
        restarts
    }

    fn platform(&mut self, raw: &Spanned<String>) -> Option<Platform> {
        if raw.value == "host" {
            return Some(Platform::Host);
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || "_/@.-".contains(c);
        if raw.value.is_empty() || !raw.value.chars().all(plain) {
            let message = format!("\"{}\" is no name of a platform", raw.value);
            self.error(raw.referenced, message, Some("write `host`, or a board's name as for `west build -b`"));
            return None;
        }
        Some(Platform::Zephyr(raw.value.clone()))
    }

    /// Refuses keys that have a meaning for other platforms only.
    pub(super) fn refuse_keys(&mut self, keys: &[(&str, &Option<Spanned<String>>)], platform: &str, reason: &str) {
        for (key, value) in keys {
            if let Some(value) = value {
                let message = format!("`{key}` has no meaning for platform {platform}");
                self.error(value.referenced, message, Some(reason));
            }
        }
    }

    /// Returns the folder of the keys.
    pub(super) fn keys(&mut self, raw: &Spanned<String>, plan: &Plan) -> Option<String> {
        if raw.value.trim().is_empty() {
            self.error(raw.referenced, "`keys`: a folder needs a name", Some("write its path, relative to this file"));
            return None;
        }
        if plan.target.security.is_none() {
            let message = format!("`keys`: the connections of {} are not encrypted", plan.name);
            let hint = "write `security: noise` into the target declaration of the program, or remove `security` here";
            self.error(raw.referenced, message, Some(hint));
            return None;
        }
        Some(raw.value.clone())
    }

    fn network(&mut self, name: &str, raw: &RawPlace) -> Option<BoardNetwork> {
        let Some(raw_ip) = &raw.ip else {
            let message = format!("{} runs on a board, so it needs an `ip`", called(name));
            self.error(raw.platform.referenced, message, None);
            return None;
        };
        let ip = self.address(Some(raw_ip), "ip")?;
        self.once("IP address", ip.to_string(), name, raw_ip.referenced);
        let prefix_bits = match ip {
            IpAddr::V4(_) => self.netmask(raw),
            IpAddr::V6(_) => self.prefix(raw),
        };
        let gateway = self.address(raw.gateway.as_ref(), "gateway");
        let network = BoardNetwork { ip, prefix_bits: prefix_bits?, gateway };
        if let (Some(gateway), Some(raw_gateway)) = (gateway, &raw.gateway)
            && !network.contains(gateway)
        {
            let message = format!("the gateway {gateway} is not in the network of {ip} with {}", network.extent());
            self.error(raw_gateway.referenced, message, None);
        }
        Some(network)
    }

    /// Returns the number of ones in the netmask; `None` if it is invalid.
    fn netmask(&mut self, raw: &RawPlace) -> Option<u8> {
        if let Some(prefix) = &raw.prefix {
            let hint = "write `netmask`, such as 255.255.255.0";
            self.error(prefix.referenced, "`prefix` is for IPv6 addresses", Some(hint));
        }
        let Some(raw) = &raw.netmask else { return Some(24) };
        match raw.value.parse::<Ipv4Addr>().map(Ipv4Addr::to_bits) {
            Ok(mask) if mask.leading_ones() + mask.trailing_zeros() == 32 => mask.leading_ones().try_into().ok(),
            Ok(mask) => {
                let message = format!("{} is no netmask: its ones must come first", Ipv4Addr::from_bits(mask));
                self.error(raw.referenced, message, None);
                None
            }
            Err(_) => {
                let message = format!("`netmask`: \"{}\" is no netmask", raw.value);
                self.error(raw.referenced, message, Some("write four numbers, such as 255.255.255.0"));
                None
            }
        }
    }

    /// Returns the length of the prefix of an IPv6 network; `None` if it is invalid.
    fn prefix(&mut self, raw: &RawPlace) -> Option<u8> {
        if let Some(netmask) = &raw.netmask {
            self.error(netmask.referenced, "`netmask` is for IPv4 addresses", Some("write `prefix`, such as 64"));
        }
        let Some(raw) = &raw.prefix else { return Some(64) };
        let bits = raw.value.parse::<u8>().ok().filter(|bits| (1..=128).contains(bits));
        if bits.is_none() {
            let message = format!("`prefix`: \"{}\" is no length of a prefix", raw.value);
            self.error(raw.referenced, message, Some("write a number from 1 to 128, such as 64"));
        }
        bits
    }

    pub(super) fn address(&mut self, raw: Option<&Spanned<String>>, key: &str) -> Option<IpAddr> {
        let raw = raw?;
        let Ok(ip) = raw.value.parse::<IpAddr>() else {
            let message = format!("`{key}`: \"{}\" is no IP address", raw.value);
            self.error(raw.referenced, message, Some("write an address such as 10.0.0.2 or fd00::2"));
            return None;
        };
        let is_of_many = |ip: Ipv4Addr| ip.is_unspecified() || ip.is_broadcast() || ip.is_multicast();
        let (is_of_many, is_local) = match ip {
            IpAddr::V4(ip) => (is_of_many(ip), false),
            IpAddr::V6(ip) => (ip.is_unspecified() || ip.is_multicast(), ip.is_unicast_link_local()),
        };
        if is_of_many {
            self.error(raw.referenced, format!("`{key}`: {ip} is not the address of one participant"), None);
        } else if is_local {
            let message = format!("`{key}`: {ip} is an address at one network interface, which differs by computer");
            self.error(raw.referenced, message, Some("write one that is the same everywhere, such as fd00::2"));
        } else if matches!(ip, IpAddr::V6(ip) if ip.to_ipv4_mapped().is_some()) {
            self.error(raw.referenced, format!("`{key}`: {ip} is an IPv4 address"), Some("write it without `::ffff:`"));
        } else {
            return Some(ip);
        }
        None
    }

    fn mac(&mut self, name: &str, raw: &Spanned<String>) -> Option<Mac> {
        let Some(mac) = parse_mac(&raw.value) else {
            let message = format!("`mac`: \"{}\" is no MAC address", raw.value);
            self.error(raw.referenced, message, Some("write six bytes in hexadecimal, such as 02:00:00:00:00:02"));
            return None;
        };
        if mac.0[0] & 1 == 1 || mac.0 == [0; 6] {
            let message = format!("`mac`: {mac} is not the address of one board");
            let hint = "the first byte must be even; 02 is for addresses that you choose yourself";
            self.error(raw.referenced, message, Some(hint));
            return None;
        }
        self.once("MAC address", mac.to_string(), name, raw.referenced);
        Some(mac)
    }

    fn label(&mut self, raw: &Spanned<String>) -> Option<String> {
        let starts_well = raw.value.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if starts_well && raw.value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Some(raw.value.clone());
        }
        let message = format!("`ethernet`: \"{}\" is no devicetree label", raw.value);
        self.error(raw.referenced, message, Some("write the label without `&`, such as enet_mac"));
        None
    }

    pub(super) fn once(&mut self, what: &'static str, value: String, owner: &str, at: Location) {
        let (line, _) = place(at);
        if let Some((other, other_line)) = self.taken.get(&(what, value.clone())) {
            let message =
                format!("the {what} {value} of {} is already that of {other} (line {other_line})", called(owner));
            self.error(at, message, None);
            return;
        }
        self.taken.insert((what, value), (called(owner), line));
    }

    /// Reports an RTI that a board cannot reach: one on this computer's loopback, or one without a route.
    pub(super) fn reachable(&mut self, federate: &Place, raw_ip: Option<&Spanned<String>>, rti: &RtiPlace) {
        let (Some(network), Some(raw_ip)) = (federate.network, raw_ip) else { return };
        let hint = match rti.home {
            RtiHome::Program => "give `rti` the `ip` under which the boards reach this computer",
            RtiHome::Image(_) => "give `rti` an `ip` of its own, or another platform",
            RtiHome::Joint(_) => "give the federate with the RTI an `ip`",
        };
        match rti.ip {
            Some(ip) if ip.is_loopback() => {
                let message = format!("the RTI's address {ip} cannot be reached from a board");
                self.error(raw_ip.referenced, message, Some(hint));
            }
            Some(ip) if ip.is_ipv4() != network.ip.is_ipv4() => {
                let message = format!("the RTI's address {ip} is of another family than {}", network.ip);
                let hint = "give the RTI and the boards addresses of IPv4 only, or of IPv6 only";
                self.error(raw_ip.referenced, message, Some(hint));
            }
            Some(ip) if network.gateway.is_none() && !network.contains(ip) => {
                let message = format!("the RTI's address {ip} is in another network than {}", network.ip);
                let key = if ip.is_ipv4() { "netmask" } else { "prefix" };
                self.error(raw_ip.referenced, message, Some(&format!("add a `gateway`, or correct `ip` or `{key}`")));
            }
            Some(_) => {}
            None => self.error(raw_ip.referenced, "a board needs to know the RTI's address", Some(hint)),
        }
    }
}

/// Returns the name of a participant in messages; the RTI has no name.
fn called(name: &str) -> String {
    if name == RTI { name.to_owned() } else { format!("\"{name}\"") }
}

impl BoardNetwork {
    /// Returns whether the network contains this address.
    fn contains(self, other: IpAddr) -> bool {
        let bits = |ip: IpAddr| match ip {
            IpAddr::V4(ip) => u128::from(ip.to_bits()) << 96,
            IpAddr::V6(ip) => ip.to_bits(),
        };
        let differing = bits(self.ip) ^ bits(other);
        self.ip.is_ipv4() == other.is_ipv4() && differing.leading_zeros() >= self.prefix_bits.into()
    }

    /// Returns the size of the network, for messages.
    fn extent(self) -> String {
        match self.netmask() {
            Some(netmask) => format!("netmask {netmask}"),
            None => format!("prefix {}", self.prefix_bits),
        }
    }
}

fn parse_mac(text: &str) -> Option<Mac> {
    let mut bytes = [0; 6];
    let mut parts = text.split([':', '-']);
    for byte in &mut bytes {
        let part = parts.next().filter(|part| part.len() == 2 && part.bytes().all(|b| b.is_ascii_hexdigit()))?;
        *byte = u8::from_str_radix(part, 16).ok()?;
    }
    parts.next().is_none().then_some(Mac(bytes))
}
