// SPDX-License-Identifier: Apache-2.0
//! The connections of a federate, either in the sender's lists or in the receiver's bytes.

use core::fmt;
use core::iter::FusedIterator;

use crate::dialect::{self, DOWNSTREAM_BYTES, UPSTREAM_BYTES};

/// Delay of a connection without `after`. A delay of 0 is one microstep, a positive one is in nanoseconds.
pub const DELAY_NONE: i64 = i64::MIN;

/// The federates that a federate is connected with. Two are equal if they list the same, wherever the lists are stored.
#[derive(Clone, Copy)]
pub struct NeighborStructure<'a> {
    upstream: List<'a, (u16, i64), UPSTREAM_BYTES>,
    downstream: List<'a, u16, DOWNSTREAM_BYTES>,
}

impl<'a> NeighborStructure<'a> {
    /// Returns the structure with these upstream federates, each with the minimum delay of its connections in
    /// nanoseconds ([`DELAY_NONE`] for none), and these downstream federates.
    pub const fn new(upstream: &'a [(u16, i64)], downstream: &'a [u16]) -> Self {
        Self { upstream: List::Values(upstream), downstream: List::Values(downstream) }
    }

    /// Returns the structure whose entries lie in these bytes; incomplete entries at the end are not part of it.
    pub(crate) fn from_bytes(upstream: &'a [u8], downstream: &'a [u8]) -> Self {
        Self { upstream: List::Bytes(upstream.as_chunks().0), downstream: List::Bytes(downstream.as_chunks().0) }
    }

    /// Iterates over the upstream federates in the order of the wire, each with its delay in nanoseconds or
    /// [`DELAY_NONE`].
    pub const fn upstream(&self) -> Upstream<'a> {
        Upstream(self.upstream)
    }

    /// Iterates over the downstream federates in the order of the wire.
    pub const fn downstream(&self) -> Downstream<'a> {
        Downstream(self.downstream)
    }

    /// Returns the length of all entries on the wire in bytes.
    pub(crate) fn entries_bytes(&self) -> usize {
        let upstream = self.upstream.len().saturating_mul(UPSTREAM_BYTES);
        upstream.saturating_add(self.downstream.len().saturating_mul(DOWNSTREAM_BYTES))
    }
}

impl PartialEq for NeighborStructure<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.upstream().eq(other.upstream()) && self.downstream().eq(other.downstream())
    }
}

impl Eq for NeighborStructure<'_> {}

impl fmt::Debug for NeighborStructure<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NeighborStructure")
            .field("upstream", &self.upstream())
            .field("downstream", &self.downstream())
            .finish()
    }
}

/// The remaining entries, of `N` bytes each if they lie in bytes.
#[derive(Clone, Copy)]
enum List<'a, T, const N: usize> {
    Values(&'a [T]),
    Bytes(&'a [[u8; N]]),
}

impl<T: Copy, const N: usize> List<'_, T, N> {
    const fn len(&self) -> usize {
        match self {
            Self::Values(values) => values.len(),
            Self::Bytes(entries) => entries.len(),
        }
    }

    fn next(&mut self, read: impl FnOnce([u8; N]) -> T) -> Option<T> {
        match self {
            Self::Values(values) => {
                let (first, rest) = values.split_first()?;
                *values = rest;
                Some(*first)
            }
            Self::Bytes(entries) => {
                let (first, rest) = entries.split_first()?;
                *entries = rest;
                Some(read(*first))
            }
        }
    }
}

/// Iterator over upstream federates: (id, delay in nanoseconds or [`DELAY_NONE`]).
#[derive(Clone)]
pub struct Upstream<'a>(List<'a, (u16, i64), UPSTREAM_BYTES>);

impl Iterator for Upstream<'_> {
    type Item = (u16, i64);

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next(dialect::upstream)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.0.len(), Some(self.0.len()))
    }
}

impl ExactSizeIterator for Upstream<'_> {}
impl FusedIterator for Upstream<'_> {}

impl fmt::Debug for Upstream<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.clone()).finish()
    }
}

/// Iterator over the ids of downstream federates.
#[derive(Clone)]
pub struct Downstream<'a>(List<'a, u16, DOWNSTREAM_BYTES>);

impl Iterator for Downstream<'_> {
    type Item = u16;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next(dialect::downstream)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.0.len(), Some(self.0.len()))
    }
}

impl ExactSizeIterator for Downstream<'_> {}
impl FusedIterator for Downstream<'_> {}

impl fmt::Debug for Downstream<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.clone()).finish()
    }
}
