// SPDX-License-Identifier: Apache-2.0
//! Per Zephyr federate: a Kconfig fragment with what follows from the plan and the deployment, and a devicetree
//! overlay with the MAC address. A user's own files are added on top of both.

use core::fmt::Write;
use core::net::Ipv4Addr;

use super::deployment::{Deployment, Mac, Place, Platform};
use crate::plan::{ClockSync, Federate, Logging, Plan, TriggerKind};

/// Devicetree labels of the Ethernet MAC by the beginning of the board's name; the first that fits is taken.
const ETHERNET_LABELS: [(&str, &str); 9] = [
    ("qemu_cortex_m3", "eth"),
    ("mps2", "eth0"),
    ("mimxrt", "enet_mac"),
    ("frdm_k64f", "enet_mac"),
    ("frdm_mcxn947", "enet_mac"),
    ("nucleo_", "mac"),
    ("stm32", "mac"),
    ("sam_", "gmac"),
    ("same54_xpro", "gmac"),
];

/// The devicetree label of a board's Ethernet MAC, if it is known.
pub(super) fn ethernet_label(board: &str) -> Option<&'static str> {
    ETHERNET_LABELS.iter().find(|(start, _)| board.starts_with(start)).map(|(_, label)| *label)
}

/// Lines of a Kconfig fragment.
struct Fragment(String);

impl Fragment {
    fn comment(&mut self, text: &str) {
        // Writing to a String cannot fail.
        let _ = write!(self.0, "\n# {text}\n");
    }

    fn set(&mut self, symbol: &str, value: impl core::fmt::Display) {
        let _ = writeln!(self.0, "CONFIG_{symbol}={value}");
    }

    fn set_text(&mut self, symbol: &str, value: &str) {
        let escaped = value.replace('\\', "\\\\").replace('"', "\\\"");
        self.set(symbol, format_args!("\"{escaped}\""));
    }
}

/// The Kconfig fragment of a federate, or of an unfederated program.
pub(super) fn kconfig(plan: &Plan, federate: &Federate, deployment: &Deployment) -> String {
    let place = deployment.place(&federate.name);
    let mut fragment = Fragment(header("#", plan, federate));
    if let Some(rti) = deployment.rti_of(plan) {
        fragment.comment("The federation.");
        fragment.set_text("LF_FEDERATION_ID", &rti.federation_id);
        // The symbol takes addresses only; a name such as localhost leaves the default.
        if rti.host.parse::<Ipv4Addr>().is_ok() {
            fragment.set_text("LF_RTI_ADDRESS", &rti.host);
        }
        fragment.set("LF_RTI_PORT", rti.port);
        if plan.target.authentication {
            fragment.set("LF_AUTHENTICATION", "y");
            // native_sim takes the computer's random numbers, not those of its driver for tests.
            if !is_native_sim(&place) {
                fragment.set("ENTROPY_GENERATOR", "y");
            }
        }
    }
    network(&mut fragment, &place);
    capacities(&mut fragment, plan, federate, &place);
    receive_buffer(&mut fragment, federate, &place);
    logging(&mut fragment, plan.target.logging);
    fragment.0
}

fn is_native_sim(place: &Place) -> bool {
    matches!(&place.platform, Platform::Zephyr(board) if board.starts_with("native_sim"))
}

fn network(fragment: &mut Fragment, place: &Place) {
    let Some(network) = &place.network else { return };
    fragment.comment("This board's address.");
    fragment.set("NET_CONFIG_SETTINGS", "y");
    fragment.set("NET_CONFIG_NEED_IPV4", "y");
    fragment.set_text("NET_CONFIG_MY_IPV4_ADDR", &network.ip.to_string());
    fragment.set_text("NET_CONFIG_MY_IPV4_NETMASK", &network.netmask.to_string());
    // Without a gateway, that of the board's own configuration must not remain.
    let gateway = network.gateway.map(|gateway| gateway.to_string()).unwrap_or_default();
    fragment.set_text("NET_CONFIG_MY_IPV4_GW", &gateway);
}

fn capacities(fragment: &mut Fragment, plan: &Plan, federate: &Federate, place: &Place) {
    // One to the RTI, which is closed before another is made; one per physical connection, one that awaits them, and
    // one for the datagrams of clock synchronization.
    let (peers_in, peers_out) = (federate.peers_in().len(), federate.peers_out().len());
    let datagrams = plan.is_federated() && plan.target.clock_sync == ClockSync::On;
    let sockets = 1 + peers_in + usize::from(peers_in > 0) + peers_out + usize::from(datagrams);
    fragment.comment("What the federate needs: sockets, and descriptors for them, the wake-up and the console.");
    fragment.set("LF_SOCKETS", sockets);
    fragment.set("ZVFS_OPEN_MAX", sockets + 3);
    fragment.set("ZVFS_POLL_MAX", 2 * sockets + 1);
    if datagrams {
        fragment.comment("Clock synchronization while the federation runs.");
        fragment.set("NET_UDP", "y");
    }
    if sockets > 1 && !is_native_sim(place) {
        fragment.comment("What Zephyr's own network stack keeps for them.");
        fragment.set("NET_MAX_CONTEXTS", sockets + 2);
        fragment.set("NET_MAX_CONN", sockets + 3);
    }
    let is_physical = |kind: &TriggerKind| matches!(kind, TriggerKind::Action { physical: true, .. });
    let threads = match plan.target.user_threads {
        0 => federate.triggers.iter().filter(|trigger| is_physical(&trigger.kind)).count(),
        given => usize::from(given),
    };
    fragment.comment("Threads that bodies start: `user-threads`, or one for each physical action.");
    fragment.set("LF_USER_THREADS", threads);
}

/// A federate with several upstream federates may have to hold messages of the fastest until the slowest lets it go on;
/// what its queues do not take stays in the receive buffer. With one upstream a grant follows every message.
fn receive_buffer(fragment: &mut Fragment, federate: &Federate, place: &Place) {
    if federate.upstream.len() < 2 {
        return;
    }
    let bytes = match &place.platform {
        Platform::Zephyr(_) if !is_native_sim(place) => 2048,
        _ => 65536,
    };
    fragment.comment("Messages of one upstream federate wait here for grants that depend on another.");
    fragment.set("LF_RECEIVE_BUFFER_SIZE", bytes);
}

fn logging(fragment: &mut Fragment, logging: Logging) {
    let level = match logging {
        Logging::Error => "ERR",
        Logging::Warn => "WRN",
        // This is Zephyr's default, which a user's own file can then change without a conflict.
        Logging::Info => return,
        Logging::Log | Logging::Debug => "DBG",
    };
    fragment.comment("The target property `logging`.");
    fragment.set(&format!("LF_LOG_LEVEL_{level}"), "y");
}

/// The devicetree overlay of a federate; without a MAC address it changes nothing.
pub(super) fn overlay(plan: &Plan, federate: &Federate, mac: Option<(Mac, &str)>) -> String {
    let mut text = header("//", plan, federate);
    if let Some((mac, label)) = mac {
        let bytes: Vec<String> = mac.0.iter().map(|byte| format!("{byte:02x}")).collect();
        let _ = write!(
            text,
            "\n&{label} {{\n\t/delete-property/ zephyr,random-mac-address;\n\tlocal-mac-address = [{}];\n}};\n",
            bytes.join(" ")
        );
    }
    text
}

fn header(mark: &str, plan: &Plan, federate: &Federate) -> String {
    let name = &federate.name;
    format!(
        "{mark} SPDX-License-Identifier: Apache-2.0\n\
         {mark} Generated by lfz for {name} of {}; do not edit.\n\
         {mark} Settings of your own belong into prj_{name}.conf and boards/<board>_{name}.overlay.\n",
        plan.name
    )
}
