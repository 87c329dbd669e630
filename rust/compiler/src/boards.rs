// SPDX-License-Identifier: Apache-2.0
//! Properties of boards that follow from their names.

/// Devicetree labels of the Ethernet MAC by the beginning of the board's name; the first match counts.
const ETHERNET_LABELS: [(&str, &str); 8] = [
    ("qemu_cortex_m3", "eth"),
    ("mimxrt", "enet_mac"),
    ("frdm_k64f", "enet_mac"),
    ("frdm_mcxn947", "enet_mac"),
    ("nucleo_", "mac"),
    ("stm32", "mac"),
    ("sam_", "gmac"),
    ("same54_xpro", "gmac"),
];

/// Returns the devicetree label of a board's Ethernet MAC, if it is known.
pub(crate) fn ethernet_label(board: &str) -> Option<&'static str> {
    ETHERNET_LABELS.iter().find(|(start, _)| board.starts_with(start)).map(|(_, label)| *label)
}

/// Beginnings of the names of boards with 512 KiB of memory and more.
const ROOMY: [&str; 3] = ["native_sim", "mps2", "mimxrt"];

/// Returns whether a board is known to have that much memory.
pub(crate) fn is_roomy(board: &str) -> bool {
    ROOMY.iter().any(|start| board.starts_with(start))
}
