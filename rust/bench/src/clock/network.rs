// SPDX-License-Identifier: Apache-2.0
//! Delays of a network.

/// A kind of network.
#[derive(Clone, Copy, Debug)]
pub struct Network {
    /// The name in the rows.
    pub name: &'static str,
    /// The minimum latency of a message, in nanoseconds.
    pub base_ns: i64,
    /// The maximum additional latency of most messages.
    pub usual_ns: i64,
    /// The maximum additional latency of disturbed messages.
    pub jitter_ns: i64,
    /// The percentage of messages that the jitter disturbs.
    pub disturbed_percent: u64,
    /// The percentage of messages that are lost, once the federation runs.
    pub lost_percent: u64,
    /// The time from T4 to the coded probe at the RTI.
    pub between_ns: i64,
}

impl Network {
    /// A switch without other traffic.
    pub const QUIET: Self = Self {
        name: "quiet",
        base_ns: 60_000,
        usual_ns: 20_000,
        jitter_ns: 0,
        disturbed_percent: 0,
        lost_percent: 0,
        between_ns: 8_000,
    };
    /// A network that delays each message by up to 4 ms.
    pub const JITTER: Self =
        Self { name: "jitter of 4 ms", jitter_ns: 4_000_000, disturbed_percent: 100, ..Self::QUIET };
    /// A network that delays a message now and then.
    pub const BURSTS: Self =
        Self { name: "1 in 5 delayed by up to 4 ms", jitter_ns: 4_000_000, disturbed_percent: 20, ..Self::QUIET };
    /// A network that delays and loses messages.
    pub const LOSSY: Self = Self { name: "jitter of 4 ms, 5 % lost", lost_percent: 5, ..Self::JITTER };
    /// All kinds of networks.
    pub const ALL: [Self; 4] = [Self::QUIET, Self::BURSTS, Self::JITTER, Self::LOSSY];

    /// Returns the delays that follow from a seed; equal seeds have equal delays.
    pub fn delays(&self, seed: u64) -> Delays {
        Delays { network: *self, state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1 }
    }
}

/// The outcomes of the messages of a round: T1, T3, T4, coded probe.
#[derive(Clone, Copy, Debug)]
pub struct RoundDelays {
    /// The latency of each message, in nanoseconds.
    pub times: [i64; 4],
    /// Whether each message is lost.
    pub lost: [bool; 4],
}

/// The delays of one round after another.
#[derive(Clone, Debug)]
pub struct Delays {
    network: Network,
    state: u64,
}

impl Delays {
    /// Returns a random number below `limit`.
    fn below(&mut self, limit: i64) -> i64 {
        // SplitMix64.
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        i64::try_from(bits % limit.max(1).unsigned_abs()).unwrap_or(0)
    }

    fn percent(&mut self, percent: u64) -> bool {
        self.below(100).unsigned_abs() < percent
    }

    /// Returns the delays of the next round.
    pub fn next_round(&mut self) -> RoundDelays {
        let Network { base_ns, usual_ns, jitter_ns, disturbed_percent, lost_percent, .. } = self.network;
        let times = [0; 4].map(|_: i64| {
            let (usual, jitter, disturbed) =
                (self.below(usual_ns), self.below(jitter_ns), self.percent(disturbed_percent));
            base_ns + usual + if disturbed { jitter } else { 0 }
        });
        RoundDelays { times, lost: [false; 4].map(|_| self.percent(lost_percent)) }
    }
}
