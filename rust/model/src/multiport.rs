// SPDX-License-Identifier: Apache-2.0
//! Several ports under one name: a multiport, or a port of a bank of reactors.
use core::ops::{Index, IndexMut};

use crate::port::Port;

/// Ports to read. Bodies index it, and iterate over it.
///
/// Generated code makes it where it calls the reaction: `&Multiport::new(&[&self.a_out, &self.b_out])`.
#[derive(Clone, Copy, Debug)]
pub struct Multiport<'a, T>(&'a [&'a Port<T>]);

impl<'a, T> Multiport<'a, T> {
    /// These ports, in this order.
    pub const fn new(ports: &'a [&'a Port<T>]) -> Self {
        Self(ports)
    }

    /// How many ports there are, set or not.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no port at all.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All ports.
    pub fn iter(&self) -> impl Iterator<Item = &'a Port<T>> + use<'a, T> {
        self.0.iter().copied()
    }

    /// The ports that are set at this tag.
    pub fn iterate_set(&self) -> impl Iterator<Item = &'a Port<T>> + use<'a, T> {
        self.iter().filter(|port| port.value.is_some())
    }

    /// The ports that are set at this tag, each with its place.
    pub fn enumerate_set(&self) -> impl Iterator<Item = (usize, &'a Port<T>)> + use<'a, T> {
        self.iter().enumerate().filter(|(_, port)| port.value.is_some())
    }

    /// The values of the ports that are set at this tag.
    pub fn iterate_values(&self) -> impl Iterator<Item = T> + use<'a, T>
    where
        T: Copy,
    {
        self.iter().filter_map(|port| port.value)
    }

    /// References to the values of the ports that are set at this tag.
    pub fn iterate_values_ref(&self) -> impl Iterator<Item = &'a T> + use<'a, T> {
        self.iter().filter_map(|port| port.value.as_ref())
    }

    /// The values of the ports that are set at this tag, each with its port's place.
    pub fn enumerate_values(&self) -> impl Iterator<Item = (usize, T)> + use<'a, T>
    where
        T: Copy,
    {
        self.iter().enumerate().filter_map(|(index, port)| Some((index, port.value?)))
    }
}

impl<T> Index<usize> for Multiport<'_, T> {
    type Output = Port<T>;
    fn index(&self, index: usize) -> &Port<T> {
        self.0[index]
    }
}

impl<'a, T> IntoIterator for Multiport<'a, T> {
    type Item = &'a Port<T>;
    type IntoIter = core::iter::Copied<core::slice::Iter<'a, &'a Port<T>>>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter().copied()
    }
}

impl<'a, T> IntoIterator for &Multiport<'a, T> {
    type Item = &'a Port<T>;
    type IntoIter = core::iter::Copied<core::slice::Iter<'a, &'a Port<T>>>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter().copied()
    }
}

/// Ports to set. Bodies index it, and iterate over it.
///
/// Generated code makes it where it calls the reaction: `&mut MultiportMut::new(&mut [&mut self.a, &mut self.b])`.
#[derive(Debug)]
pub struct MultiportMut<'a, T>(&'a mut [&'a mut Port<T>]);

impl<'a, T> MultiportMut<'a, T> {
    /// These ports, in this order.
    pub const fn new(ports: &'a mut [&'a mut Port<T>]) -> Self {
        Self(ports)
    }

    /// How many ports there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no port at all.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All ports.
    pub fn iter(&self) -> impl Iterator<Item = &Port<T>> {
        self.0.iter().map(|port| &**port)
    }

    /// All ports, to set them.
    pub fn iter_mut(&mut self) -> PortsMut<'_, 'a, T> {
        self.into_iter()
    }
}

impl<T> Index<usize> for MultiportMut<'_, T> {
    type Output = Port<T>;
    fn index(&self, index: usize) -> &Port<T> {
        self.0[index]
    }
}

impl<T> IndexMut<usize> for MultiportMut<'_, T> {
    fn index_mut(&mut self, index: usize) -> &mut Port<T> {
        self.0[index]
    }
}

impl<'m, 'a, T> IntoIterator for &'m mut MultiportMut<'a, T> {
    type Item = &'m mut Port<T>;
    type IntoIter = PortsMut<'m, 'a, T>;
    fn into_iter(self) -> PortsMut<'m, 'a, T> {
        PortsMut(self.0.iter_mut())
    }
}

/// An iteration over ports to set.
#[derive(Debug)]
pub struct PortsMut<'m, 'a, T>(core::slice::IterMut<'m, &'a mut Port<T>>);

impl<'m, T> Iterator for PortsMut<'m, '_, T> {
    type Item = &'m mut Port<T>;
    fn next(&mut self) -> Option<Self::Item> {
        self.0.next().map(|port| &mut **port)
    }
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl<T> ExactSizeIterator for PortsMut<'_, '_, T> {}
