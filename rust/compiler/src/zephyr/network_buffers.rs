// SPDX-License-Identifier: Apache-2.0
//! Computes the packets and buffers that the network stack of a Zephyr image needs for its TCP connections.
//!
//! Zephyr keeps each received segment as a packet of its own until the program reads it, all connections take theirs
//! from one pool, and a frame that finds the pool empty is lost. TCP sends it again, but after ever longer pauses, and
//! a connection that is not read for a while must not starve the others. So each connection gets a window that fits
//! into its own share of the pool.

use crate::boards::is_roomy;

/// Bytes of one of Zephyr's buffers (`CONFIG_NET_BUF_DATA_SIZE`), and of the headers of Ethernet, IP and TCP.
const BUFFER_BYTES: usize = 128;
const HEADER_BYTES: usize = 54;
/// The number of packets that can arrive at once beside data: acknowledgements, ARP. They are processed at once, but
/// arrive as a burst.
const BURST: usize = 8;
/// Two threads may send at once, each with a packet for the data and one for the headers; others wait for an address.
const SENDING: usize = 8;
/// The minimum number of buffers for data that one of Zephyr's connections has sent ahead of its peer: 1280 bytes.
const AHEAD: usize = 1280 / BUFFER_BYTES;

/// The TCP connections of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Connections {
    /// The number of their ends in this image, including those of a connection between RTI and federate of one image.
    pub ends: usize,
    /// The number of those with other computers or boards that receive data.
    pub receiving: usize,
    /// Whether RTI and federate of this image have one between them.
    pub local: bool,
}

/// The share of a connection, by the board's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Share {
    /// The maximum number of bytes that are in transit to it, or wait until they are read.
    window_bytes: usize,
    /// The maximum number of segments of these bytes.
    segments: usize,
    /// The buffers for bytes that the other end has not acknowledged.
    unacknowledged: usize,
}

/// The share on any board, such as one with 64 KiB. A segment has 32 bytes on average, about as many as a short message
/// with its tag (25 and more); a sender that is ahead of the reader sends several messages in one. That is ten messages
/// in a round trip.
const SMALL: Share = Share { window_bytes: 256, segments: 8, unacknowledged: 256 / BUFFER_BYTES + 1 };
/// The same board with more ends of connections than these: an RTI with eight federates fits into 64 KiB, too, and one
/// with four that is in the image of one of them leaves some of it to the program.
const SMALL_CONNECTIONS: usize = 4;
const CROWDED: Share = Share { window_bytes: 128, segments: 4, unacknowledged: 128 / BUFFER_BYTES + 1 };
/// Boards with 512 KiB and more.
const ROOMY: Share = Share { window_bytes: 1024, segments: 32, unacknowledged: AHEAD };

/// The configuration for Zephyr.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pools {
    pub window_bytes: usize,
    pub packets_in: usize,
    pub packets_out: usize,
    pub buffers_in: usize,
    pub buffers_out: usize,
}

impl Connections {
    /// Returns the pools that they need on this board.
    pub(super) fn pools_on(self, board: &str) -> Pools {
        self.pools(self.share_on(board))
    }

    fn share_on(self, board: &str) -> Share {
        if is_roomy(board) {
            ROOMY
        } else if self.ends <= SMALL_CONNECTIONS {
            SMALL
        } else {
            CROWDED
        }
    }

    /// Returns the pools that the connections need if each gets this share.
    fn pools(self, share: Share) -> Pools {
        // A segment that exceeds a first buffer takes more, but such segments are few, because their bytes are limited.
        let long_segments = share.window_bytes.div_ceil(BUFFER_BYTES - HEADER_BYTES);
        let packets_in = BURST + self.receiving * share.segments;
        // Data that a board sends to itself stay in the packets and buffers for sending until they are read, the
        // headers in one of their own. A segment there contains all messages of a tag, so half as many fill a window;
        // it has two.
        let own_segments = if self.local { share.segments } else { 0 };
        // Together the connections of a small board can keep as much as one connection alone.
        let kept = (self.ends * share.unacknowledged + 2 * own_segments).max(AHEAD);
        Pools {
            window_bytes: share.window_bytes,
            packets_in,
            packets_out: SENDING + own_segments,
            buffers_in: packets_in + self.receiving * long_segments,
            // Kept data are sent as copies, with their headers; `lf_send_room` leaves this half to them.
            buffers_out: 2 * (kept + 2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The connections of a federate without peers: one to an RTI elsewhere.
    const FEDERATE: Connections = Connections { ends: 1, receiving: 1, local: false };

    #[test]
    fn windows_filled_with_segments_of_any_length_leave_room_for_a_burst() {
        for share in [SMALL, CROWDED, ROOMY] {
            for receiving in 0..20 {
                let pools = Connections { ends: receiving, receiving, local: false }.pools(share);
                assert_eq!(pools.packets_in - receiving * share.segments, BURST);
                for length in 1..=share.window_bytes {
                    let segments = share.segments.min(share.window_bytes / length);
                    let taken = receiving * segments * (HEADER_BYTES + length).div_ceil(BUFFER_BYTES);
                    assert!(pools.buffers_in >= taken + BURST, "{receiving} windows in segments of {length} bytes");
                }
            }
        }
    }

    #[test]
    fn a_frame_of_the_longest_kind_fits_even_where_there_is_one_connection() {
        let longest = 1514_usize.div_ceil(BUFFER_BYTES);
        assert!(FEDERATE.pools(SMALL).buffers_in >= longest);
    }

    #[test]
    fn kept_buffers_leave_as_many_for_copies() {
        let joint = Connections { ends: 5, receiving: 3, local: true };
        for share in [SMALL, CROWDED, ROOMY] {
            let pools = joint.pools(share);
            // `lf_send_room` in zephyr/src/platform.c hands out the buffers beyond this number.
            let for_copies = pools.buffers_out / 2 + 2;
            assert!(pools.buffers_out - for_copies >= joint.ends * share.unacknowledged);
        }
    }

    #[test]
    fn boards_of_unknown_memory_count_as_small() {
        assert_eq!(FEDERATE.share_on("qemu_cortex_m3"), SMALL);
        assert_eq!(FEDERATE.share_on("frdm_k64f"), SMALL);
        assert_eq!(FEDERATE.share_on("mimxrt1170_evk@B/mimxrt1176/cm7"), ROOMY);
        assert_eq!(FEDERATE.share_on("native_sim/native/64"), ROOMY);
    }

    #[test]
    fn an_rti_leaves_most_of_64_kib_to_others() {
        let alone = Connections { ends: 8, receiving: 8, local: false };
        let joint_with_one_of_four = Connections { ends: 5, receiving: 3, local: true };
        for (connections, limit_kib) in [(alone, 18), (joint_with_one_of_four, 13)] {
            let pools = connections.pools_on("qemu_cortex_m3");
            // Zephyr's structures take 64 bytes per packet and 28 beside the data of a buffer.
            let packets = 64 * (pools.packets_in + pools.packets_out);
            let bytes = packets + (28 + BUFFER_BYTES) * (pools.buffers_in + pools.buffers_out);
            assert!(bytes <= limit_kib * 1024, "{connections:?}: {bytes}");
        }
    }
}
