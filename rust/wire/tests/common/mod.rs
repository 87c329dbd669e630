// SPDX-License-Identifier: Apache-2.0
//! Arbitrary messages.

use lf_testkit::messages::Parts;
use lf_wire::{MessageType, Tag};
use proptest::collection::vec;
use proptest::prelude::*;

/// Times with the special ones often among them.
fn time() -> impl Strategy<Value = i64> {
    prop_oneof![any::<i64>(), Just(i64::MIN), Just(i64::MAX), Just(0)]
}

/// Parts for a message of one of `types`.
pub(crate) fn parts(types: &'static [MessageType]) -> impl Strategy<Value = Parts> {
    let scalars = (any::<u8>(), any::<u16>(), any::<u16>(), time(), any::<u32>(), any::<i32>(), any::<Option<bool>>());
    let arrays = (any::<[u8; 4]>(), any::<[u8; 8]>(), any::<[u8; 32]>());
    let lists = (
        vec(any::<u8>(), 0..=255),
        vec(any::<u8>(), 0..300),
        vec((any::<u16>(), time()), 0..12),
        vec(any::<u16>(), 0..12),
    );
    (proptest::sample::select(types), scalars, arrays, lists).prop_map(|(message_type, scalars, arrays, lists)| {
        let (code, port, federate, time, microstep, int, is_transient) = scalars;
        let (address, nonce, hmac) = arrays;
        let (id, payload, upstream, downstream) = lists;
        Parts {
            message_type,
            code,
            port,
            federate,
            tag: Tag::new(time, microstep),
            int,
            address,
            nonce,
            hmac,
            is_transient,
            id,
            payload,
            upstream,
            downstream,
        }
    })
}
