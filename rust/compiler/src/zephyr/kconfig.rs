// SPDX-License-Identifier: Apache-2.0
//! Generates, per Zephyr image, a Kconfig fragment with the values that follow from the plan and the deployment, and a
//! devicetree overlay with the MAC address. A user's own files are added to both.

use core::fmt::Write;
use core::net::IpAddr;
use std::collections::BTreeSet;

use super::network_buffers::Connections;
use crate::deployment::{Deployment, Mac, Place, Platform};
use crate::plan::{ClockSync, Federate, Logging, Plan, Rti, Security, TriggerKind};

/// Connections whose peer has not sent its id, at most (`rust/runtime/src/federate/accept_queue.rs`).
const UNIDENTIFIED_MAX: usize = 2;

/// The file with the keys of an image, in its folder of keys.
pub const KEYS_HEADER: &str = "keys.h";

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

/// Returns the Kconfig fragment of a federate, or of an unfederated program; `is_cpp` says whether its bodies are
/// compiled as C++, and `keys` is the folder with a folder of keys for each participant.
pub(crate) fn federate_kconfig(
    plan: &Plan,
    federate: &Federate,
    deployment: &Deployment,
    keys: &str,
    is_cpp: bool,
) -> String {
    let place = deployment.place(&federate.name);
    let is_joint = plan.rti.is_some() && deployment.is_joint(&federate.name);
    let mut fragment = Fragment(header("#", plan, &federate.name));
    if let Some(deployed) = deployment.rti_of(plan) {
        federation(&mut fragment, plan, &deployed, &place);
        security(&mut fragment, plan, &format!("{keys}/{}", federate.name), &place);
        // The symbol accepts addresses only; a name such as localhost leaves the default.
        if let Ok(address) = deployed.host.parse::<IpAddr>() {
            fragment.set_text("LF_RTI_ADDRESS", &deployed.host);
            if address.is_ipv6() && place.is_offloaded() {
                fragment.comment("The RTI has an IPv6 address.");
                fragment.set("NET_IPV6", "y");
                fragment.set("NET_IPV4_MAPPING_TO_IPV6", "y");
            }
        }
    }
    if is_joint {
        rti(&mut fragment, plan);
        fragment.comment("The RTI, which serves all, comes before this federate.");
        fragment.set("MAIN_THREAD_PRIORITY", 1);
        fragment.set("LF_USER_THREAD_PRIORITY", 2);
    }
    if is_cpp {
        fragment.comment("Bodies are C++.");
        fragment.set("CPP", "y");
        fragment.set("STD_CPP17", "y");
    }
    if plan.is_federated() {
        network_of_federate(&mut fragment, plan, federate, is_joint, deployment);
    } else {
        fragment
            .comment("The program is not federated. It can use the network all the same, if other settings say so.");
        fragment.set("LF_NETWORK", "n");
    }
    user_threads(&mut fragment, plan, federate);
    receive_buffer(&mut fragment, federate, &place);
    logging(&mut fragment, plan.target.logging);
    fragment.0
}

/// Adds the sockets of a federate, and those of the RTI in its image, with what they need.
fn network_of_federate(
    fragment: &mut Fragment,
    plan: &Plan,
    federate: &Federate,
    is_joint: bool,
    deployment: &Deployment,
) {
    let place = &deployment.place(&federate.name);
    let spares = deployment.spares();
    network(fragment, place);
    let own = federate_sockets(plan, federate);
    fragment.comment("The sockets of the federate.");
    fragment.set("LF_SOCKETS", own);
    if !plan.transient_neighbors(federate).is_empty() {
        fragment.comment("Federates come and go while the federation runs.");
        fragment.set("LF_TRANSIENTS", "y");
    }
    if place.restarts {
        fragment.comment("It starts again when it has failed, and joins the running federation.");
        fragment.set("LF_FATAL_REBOOT", "y");
    }
    sockets(fragment, own, if is_joint { rti_sockets(plan) } else { 0 }, place);
    buffers(fragment, connections(plan, federate, is_joint), place);
    let peers: BTreeSet<u16> = federate.peers_in().into_iter().chain(federate.peers_out()).collect();
    let others = if is_joint { plan.federates.len() } else { 1 + peers.len() };
    neighbors(fragment, others + spares, place);
    datagrams(fragment, plan);
}

/// Returns the Kconfig fragment of an image that is the RTI and nothing else.
pub(crate) fn rti_kconfig(plan: &Plan, name: &str, place: &Place, deployment: &Deployment, keys: &str) -> String {
    let mut fragment = Fragment(header("#", plan, name));
    if let Some(deployed) = deployment.rti_of(plan) {
        federation(&mut fragment, plan, &deployed, place);
        security(&mut fragment, plan, &format!("{keys}/{name}"), place);
    }
    rti(&mut fragment, plan);
    fragment.set("LF_FEDERATE", "n");
    network(&mut fragment, place);
    sockets(&mut fragment, 0, rti_sockets(plan), place);
    let federates = plan.federates.len();
    buffers(&mut fragment, Connections { ends: federates, receiving: federates, local: false }, place);
    neighbors(&mut fragment, plan.federates.len() + deployment.spares(), place);
    datagrams(&mut fragment, plan);
    fragment.set("LF_USER_THREADS", 0);
    logging(&mut fragment, plan.target.logging);
    fragment.0
}

fn federation(fragment: &mut Fragment, plan: &Plan, rti: &Rti, place: &Place) {
    fragment.comment("The federation.");
    fragment.set_text("LF_FEDERATION_ID", &rti.federation_id);
    fragment.set("LF_RTI_PORT", rti.port);
    if plan.target.authentication {
        fragment.set("LF_AUTHENTICATION", "y");
        // native_sim uses the computer's random numbers, not those of its driver for tests.
        if !place.platform.is_native_sim() {
            fragment.set("ENTROPY_GENERATOR", "y");
        }
    }
}

/// Adds the encryption of all connections, with the folder of the keys of the image.
fn security(fragment: &mut Fragment, plan: &Plan, keys: &str, place: &Place) {
    if plan.target.security != Security::Noise {
        return;
    }
    fragment.comment("All connections are encrypted. The header is secret.");
    fragment.set("LF_SECURITY", "y");
    fragment.set_text("LF_SECURITY_KEYS", &format!("{keys}/{KEYS_HEADER}"));
    if !place.platform.is_native_sim() {
        fragment.set("ENTROPY_GENERATOR", "y");
    }
}

/// Adds the sizes of an RTI: as many slots as there are federates, and as the federate with the most neighbors has.
fn rti(fragment: &mut Fragment, plan: &Plan) {
    let upstream = plan.federates.iter().map(|federate| federate.upstream.len()).max().unwrap_or(0);
    fragment.comment("The RTI.");
    fragment.set("LF_RTI", "y");
    fragment.set("LF_RTI_FEDERATES", plan.federates.len());
    fragment.set("LF_RTI_UPSTREAM", upstream);
    fragment.set("LF_RTI_CONNECTIONS", rti_connections(plan));
    if plan.transients() > 0 {
        fragment.set("LF_RTI_TRANSIENTS", plan.transients());
    }
}

/// Returns the number of connections: one for each federate, and one to reject a stranger.
fn rti_connections(plan: &Plan) -> usize {
    // A second instance of a transient federate connects while the first one is there.
    plan.federates.len() + 1 + usize::from(plan.transients() > 0)
}

/// Returns the number of sockets: the connections, the listener, and a port for the datagrams of clock synchronization.
fn rti_sockets(plan: &Plan) -> usize {
    rti_connections(plan) + 1 + usize::from(has_datagrams(plan))
}

fn has_datagrams(plan: &Plan) -> bool {
    plan.is_federated() && plan.target.clock_sync == ClockSync::On
}

fn network(fragment: &mut Fragment, place: &Place) {
    let Some(network) = &place.network else { return };
    if place.platform.is_native_sim() {
        fragment.comment("Zephyr's own network stack over a TAP interface, instead of the sockets of this computer.");
        fragment.set("NET_SOCKETS_OFFLOAD", "n");
        fragment.set("NET_NATIVE_OFFLOADED_SOCKETS", "n");
        fragment.set("HEAP_MEM_POOL_SIZE", 0);
        fragment.set("NET_L2_ETHERNET", "y");
        fragment.set("ETH_NATIVE_TAP", "y");
        fragment.set("ETH_NATIVE_TAP_RANDOM_MAC", "n");
        // Virtual boards without a MAC address derive one from their IP address.
        if let Some(mac) = place.mac {
            fragment.set_text("ETH_NATIVE_TAP_MAC_ADDR", &mac.to_string());
        }
    }
    fragment.comment("This board's address.");
    fragment.set("NET_CONFIG_SETTINGS", "y");
    // Without a gateway, that of the board's own configuration must not remain.
    let gateway = network.gateway.map(|gateway| gateway.to_string()).unwrap_or_default();
    if let Some(netmask) = network.netmask() {
        fragment.set("NET_CONFIG_NEED_IPV4", "y");
        fragment.set_text("NET_CONFIG_MY_IPV4_ADDR", &network.ip.to_string());
        fragment.set_text("NET_CONFIG_MY_IPV4_NETMASK", &netmask.to_string());
        fragment.set_text("NET_CONFIG_MY_IPV4_GW", &gateway);
        return;
    }
    fragment.set("NET_IPV6", "y");
    fragment.set("NET_CONFIG_NEED_IPV6", "y");
    fragment.set_text("NET_CONFIG_MY_IPV6_ADDR", &network.ip.to_string());
    fragment.set("LF_IPV6_PREFIX_LENGTH", network.prefix_bits);
    fragment.set_text("LF_IPV6_GATEWAY", &gateway);
    fragment
        .comment("All others have IPv6 addresses, too, and what the board's own configuration says of IPv4 is void.");
    fragment.set("NET_IPV4", "n");
    fragment.set("NET_CONFIG_NEED_IPV4", "n");
    for symbol in ["ADDR", "NETMASK", "GW"] {
        fragment.set_text(&format!("NET_CONFIG_MY_IPV4_{symbol}"), "");
    }
    fragment.comment("Addresses are unique as deployed, and names are not looked up.");
    fragment.set("NET_IPV6_DAD", "n");
    fragment.set("NET_IPV6_RA_RDNSS", "n");
}

/// Returns the number of sockets: one to the RTI, which is closed before another is made; one per physical connection,
/// one that listens for them, those of peers that have not sent their id, and one for the datagrams of clock
/// synchronization.
fn federate_sockets(plan: &Plan, federate: &Federate) -> usize {
    let (peers_in, peers_out) = (federate.peers_in().len(), federate.peers_out().len());
    let listening = if peers_in > 0 { 1 + UNIDENTIFIED_MAX } else { 0 };
    1 + peers_in + listening + peers_out + usize::from(has_datagrams(plan))
}

/// Adds the configuration for the sockets of the federate and of the RTI, either of which may be none.
fn sockets(fragment: &mut Fragment, federate: usize, rti: usize, place: &Place) {
    let all = federate + rti;
    fragment.comment("Descriptors for the sockets, the wake-up and the console; each event loop polls its own.");
    fragment.set("ZVFS_OPEN_MAX", all + 3);
    fragment.set("ZVFS_POLL_MAX", 2 * federate.max(rti) + 1);
    if all > 0 && !place.is_offloaded() {
        // Zephyr keeps a closed connection for a while, and an incoming one before it is accepted.
        fragment.comment("The contexts and connections of Zephyr's own network stack.");
        fragment.set("NET_MAX_CONTEXTS", all + 2);
        fragment.set("NET_MAX_CONN", all + 3);
    }
}

/// Returns the connections of a federate, and of the RTI in the same image if there is one. Over a physical connection
/// data flows in one direction.
fn connections(plan: &Plan, federate: &Federate, is_joint: bool) -> Connections {
    let (peers_in, peers_out) = (federate.peers_in().len(), federate.peers_out().len());
    let rti_ends = usize::from(plan.is_federated());
    let (federates, others) = if is_joint { (plan.federates.len(), plan.federates.len() - 1) } else { (0, rti_ends) };
    Connections { ends: rti_ends + federates + peers_in + peers_out, receiving: others + peers_in, local: is_joint }
}

/// Adds packets and buffers of Zephyr's own network stack.
fn buffers(fragment: &mut Fragment, connections: Connections, place: &Place) {
    let Platform::Zephyr(board) = &place.platform else { return };
    if connections.ends == 0 || place.is_offloaded() {
        return;
    }
    let pools = connections.pools_on(board);
    fragment.comment("Packets and buffers by connection, so that an unread one does not starve the others.");
    fragment.set("NET_TCP_MAX_RECV_WINDOW_SIZE", pools.window_bytes);
    fragment.set("NET_PKT_RX_COUNT", pools.packets_in);
    fragment.set("NET_PKT_TX_COUNT", pools.packets_out);
    fragment.set("NET_BUF_RX_COUNT", pools.buffers_in);
    fragment.set("NET_BUF_TX_COUNT", pools.buffers_out);
}

/// Adds room for the MAC addresses of this number of other devices on the same network, and of the gateway.
fn neighbors(fragment: &mut Fragment, count: usize, place: &Place) {
    if let Some(network) = place.network {
        fragment.comment("The MAC addresses of neighbors.");
        let symbol = if network.ip.is_ipv4() { "NET_ARP_TABLE_SIZE" } else { "NET_IPV6_MAX_NEIGHBORS" };
        fragment.set(symbol, count + 1);
    }
}

fn datagrams(fragment: &mut Fragment, plan: &Plan) {
    if has_datagrams(plan) {
        fragment.comment("Clock synchronization while the federation runs.");
        fragment.set("NET_UDP", "y");
    }
}

fn user_threads(fragment: &mut Fragment, plan: &Plan, federate: &Federate) {
    let is_physical = |kind: &TriggerKind| matches!(kind, TriggerKind::Action { physical: true, .. });
    let threads = match plan.target.user_threads {
        0 => federate.triggers.iter().filter(|trigger| is_physical(&trigger.kind)).count(),
        given => usize::from(given),
    };
    fragment.comment("Threads that bodies start: `user-threads`, or one for each physical action.");
    fragment.set("LF_USER_THREADS", threads);
}

/// Adds the size of the receive buffer. A federate with several upstream federates may have to hold messages of the
/// fastest until the slowest lets it continue; those that its queues do not hold stay in the receive buffer. With one
/// upstream federate a grant follows every message.
fn receive_buffer(fragment: &mut Fragment, federate: &Federate, place: &Place) {
    if federate.upstream.len() < 2 {
        return;
    }
    let bytes = match &place.platform {
        Platform::Zephyr(_) if !place.platform.is_native_sim() => 2048,
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

/// Returns the devicetree overlay of an image; without a MAC address it changes nothing.
pub(crate) fn overlay(plan: &Plan, name: &str, mac: Option<(Mac, &str)>) -> String {
    let mut text = header("//", plan, name);
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

fn header(mark: &str, plan: &Plan, name: &str) -> String {
    format!(
        "{mark} SPDX-License-Identifier: Apache-2.0\n\
         {mark} Generated by lfz for {name} of {}; do not edit.\n\
         {mark} Settings of your own belong into prj_{name}.conf and boards/<board>_{name}.overlay.\n",
        plan.name
    )
}
