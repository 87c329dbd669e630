// SPDX-License-Identifier: Apache-2.0
//! Serializers that a program chooses with `@serializer` or `@max_length`.
use super::{Payload, PayloadError};

/// A conversion between values of a type and bytes.
#[diagnostic::on_unimplemented(
    message = "the serializer of this port cannot send a value of type `{T}` to another federate",
    label = "it goes to another federate",
    note = "`@max_length(n)` is for `String` and `Vec<T>`, and `@serializer(\"postcard\")` for types with \
            `#[derive(Serialize, Deserialize)]`"
)]
pub trait Serializer<T> {
    /// The maximum number of bytes of a value; the generator sizes buffers by it.
    const MAX_LEN: usize;

    /// Writes a value to the beginning of `bytes`, and returns the number of bytes.
    ///
    /// # Errors
    /// When they do not fit, or the value has no form as bytes.
    fn encode(value: &T, bytes: &mut [u8]) -> Result<usize, PayloadError>;

    /// Reads a value from all of `bytes`.
    ///
    /// # Errors
    /// When they are not one value of this type.
    fn decode(bytes: &[u8]) -> Result<T, PayloadError>;
}

/// The layout of the type itself.
#[derive(Clone, Copy, Debug)]
pub struct Native;

#[diagnostic::do_not_recommend]
impl<T: Payload> Serializer<T> for Native {
    const MAX_LEN: usize = T::MAX_LEN;

    fn encode(value: &T, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        value.encode(bytes)
    }

    fn decode(bytes: &[u8]) -> Result<T, PayloadError> {
        T::decode(bytes)
    }
}

/// Asserts that values of a type can be sent; generated code calls it where a port has its type.
pub const fn sendable<T: Payload>() {}

/// Asserts that a serializer can send values of a type.
pub const fn sendable_by<T, S: Serializer<T>>() {}

/// Asserts that a connection can copy values of a type.
pub const fn copied_by_connection<T: Clone>() {}

#[cfg(feature = "postcard")]
pub use by_postcard::{Bounded, Postcard};

#[cfg(feature = "postcard")]
mod by_postcard {
    use postcard::experimental::max_size::MaxSize;
    use serde::Serialize;
    use serde::de::DeserializeOwned;

    use super::{PayloadError, Serializer};

    /// Any type of serde, in postcard's format of at most `N` bytes.
    #[derive(Clone, Copy, Debug)]
    pub struct Postcard<const N: usize>;

    impl<T: Serialize + DeserializeOwned, const N: usize> Serializer<T> for Postcard<N> {
        const MAX_LEN: usize = N;

        fn encode(value: &T, bytes: &mut [u8]) -> Result<usize, PayloadError> {
            let available = bytes.len();
            let room = &mut bytes[..available.min(N)];
            match postcard::to_slice(value, room) {
                Ok(written) => Ok(written.len()),
                Err(postcard::Error::SerializeBufferFull) if available < N => {
                    Err(PayloadError::NoRoom { needed: N, available })
                }
                Err(postcard::Error::SerializeBufferFull) => Err(PayloadError::LongerThan(N)),
                Err(_) => Err(PayloadError::NotSerialized),
            }
        }

        fn decode(bytes: &[u8]) -> Result<T, PayloadError> {
            match postcard::take_from_bytes(bytes) {
                Ok((value, [])) => Ok(value),
                Ok(_) | Err(_) => Err(PayloadError::NotDeserialized),
            }
        }
    }

    /// A type whose postcard format has a known maximum size.
    #[diagnostic::on_unimplemented(
        message = "it is not known how many bytes a value of type `{Self}` takes at most",
        label = "it goes to another federate",
        note = "write `@max_length(200)` before the port, or derive `postcard::experimental::max_size::MaxSize`"
    )]
    pub trait Bounded {
        /// The maximum number of bytes.
        const BYTES: usize;
    }

    #[diagnostic::do_not_recommend]
    impl<T: MaxSize> Bounded for T {
        const BYTES: usize = T::POSTCARD_MAX_SIZE;
    }
}
