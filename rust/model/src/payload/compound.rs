// SPDX-License-Identifier: Apache-2.0
//! Arrays, tuples and options.
use super::layout::{Field, Fields, Layout, member};
use super::{FixedPayload, PayloadError};

impl<T: Field, const N: usize> FixedPayload for [T; N] {
    const SIZE: usize = T::LAYOUT.times(N).size();
    const ALIGN: usize = T::LAYOUT.align();

    fn write(&self, bytes: &mut [u8]) {
        write_elements(self, bytes);
    }

    fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
        let mut elements = heapless::Vec::<T, N>::new();
        let size = T::LAYOUT.size();
        for index in 0..N {
            // It fits: the list has room for as many elements as are read.
            let _ = elements.push(T::read_field(&bytes[index * size..(index + 1) * size])?);
        }
        let found = elements.len() * size;
        elements.into_array().map_err(|_| PayloadError::Length { expected: Self::SIZE, found })
    }
}

/// Writes elements one after the other.
pub(super) fn write_elements<T: Field>(elements: &[T], bytes: &mut [u8]) {
    let size = T::LAYOUT.size();
    bytes.fill(0);
    for (index, element) in elements.iter().enumerate() {
        element.write_field(&mut bytes[index * size..(index + 1) * size]);
    }
}

impl<T: Field> FixedPayload for Option<T> {
    const SIZE: usize = Layout::EMPTY.with(bool::LAYOUT).with(T::LAYOUT).size();
    const ALIGN: usize = T::LAYOUT.align();

    fn write(&self, bytes: &mut [u8]) {
        bytes.fill(0);
        let mut fields = Fields::new(bytes);
        fields.put(member(), &self.is_some());
        if let Some(value) = self {
            fields.put(member(), value);
        }
    }

    fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
        let mut fields = Fields::new(bytes);
        let is_some: bool = fields.take(member())?;
        is_some.then(|| fields.take(member())).transpose()
    }
}

macro_rules! tuples {
    ($($(($ty:ident, $value:ident))+;)+) => {$(
        impl<$($ty: Field),+> FixedPayload for ($($ty,)+) {
            const SIZE: usize = Layout::EMPTY$(.with($ty::LAYOUT))+.size();
            const ALIGN: usize = Layout::EMPTY$(.with($ty::LAYOUT))+.align();

            fn write(&self, bytes: &mut [u8]) {
                let ($($value,)+) = self;
                bytes.fill(0);
                let mut fields = Fields::new(bytes);
                $(fields.put(member(), $value);)+
            }

            fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
                let mut fields = Fields::new(bytes);
                Ok(($(fields.take(member::<$ty>())?,)+))
            }
        }
    )+};
}
tuples! {
    (A, a);
    (A, a) (B, b);
    (A, a) (B, b) (C, c);
    (A, a) (B, b) (C, c) (D, d);
    (A, a) (B, b) (C, c) (D, d) (E, e);
    (A, a) (B, b) (C, c) (D, d) (E, e) (F, f);
    (A, a) (B, b) (C, c) (D, d) (E, e) (F, f) (G, g);
    (A, a) (B, b) (C, c) (D, d) (E, e) (F, f) (G, g) (H, h);
}
