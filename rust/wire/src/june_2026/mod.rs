// SPDX-License-Identifier: Apache-2.0
//! The dialect of the stock C runtime in June 2026.
//!
//! All integers are little-endian and packed. The one exception is the address in ADDRESS_QUERY_REPLY, which is in
//! network order. A type byte alone decides the layout; no message needs to know who sent it or when.
//!
//! With the feature `ipv6` there is one message more than the stock programs have, ADDRESS_QUERY_REPLY_IPV6. It goes
//! over connections of IPv6 only, which they do not make.

mod decode;
mod encode;
mod layouts;

pub(crate) use decode::decode_expected;
pub use decode::{decode, destination_in_header, message_bytes_max, tag_in_header};
pub(crate) use encode::{PayloadHeader, encode, encoded_len};
pub(crate) use layouts::{DOWNSTREAM_BYTES, UPSTREAM_BYTES, byte, downstream, fixed_bytes, message_type, upstream};
