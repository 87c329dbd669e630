// SPDX-License-Identifier: Apache-2.0
//! The dialect of LF's C runtime in the releases 0.12 and 0.13.
//!
//! Two messages differ between the two: in 0.13, ADDRESS_QUERY and P2P_SENDING_FED_ID have one byte more, which says
//! whether the federate in the message is transient. The release of a peer is unknown before it has sent one of these,
//! so both forms are accepted, and `is_transient` of the message, `None` for the form of 0.12, selects the form to
//! write. The other messages of 0.13 are about transient federates. TRANSIENT_FED_IDS, which a persistent federate may
//! send too, and UPSTREAM_DISCONNECTED are always here, the others with the feature `transients`: images without such
//! federates do not carry them. To a transient federate, TIMESTAMP has a long form; the receiver knows that it is one,
//! and nothing else tells the two forms apart.
//!
//! All integers are little-endian and packed. The one exception is the address in ADDRESS_QUERY_REPLY, which is in
//! network order. Decoding a message needs neither its sender nor its time.
//!
//! With the feature `ipv6` there is one message more than the stock programs have, ADDRESS_QUERY_REPLY_IPV6. It goes
//! only over connections of IPv6, which they do not make.

mod decode;
mod encode;
mod introduction;
mod layouts;
mod query_end;

#[cfg(feature = "transients")]
pub use decode::decode_to_transient;
pub use decode::{decode, decode_expected, destination_in_header, message_bytes_max, tag_in_header};
pub(crate) use encode::{PayloadHeader, encode, encoded_len};
pub use introduction::IntroductionHeader;
pub(crate) use layouts::{DOWNSTREAM_BYTES, UPSTREAM_BYTES, byte, downstream, fixed_bytes, message_type, upstream};
pub use query_end::QueryEnd;
