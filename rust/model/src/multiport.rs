// SPDX-License-Identifier: Apache-2.0
//! Multiports, and ports of banks, as bodies see them: several ports under one name.
use core::fmt;
use core::ops::{Index, IndexMut};
use core::slice;

use crate::cell::Readable;
use crate::port::Port;

/// The channels of a multiport that a body reads, or the ports of the members of a bank, member by member.
pub struct Multiport<'a, T> {
    ports: &'a [&'a Port<T>],
}

impl<'a, T> Multiport<'a, T> {
    /// Returns a multiport of these ports.
    pub const fn new(ports: &'a [&'a Port<T>]) -> Self {
        Self { ports }
    }

    /// Returns the number of channels.
    pub const fn len(&self) -> usize {
        self.ports.len()
    }

    /// Returns whether there are no channels.
    pub const fn is_empty(&self) -> bool {
        self.ports.is_empty()
    }

    /// Returns one of the ports.
    pub fn get(&self, channel: usize) -> Option<&'a Port<T>> {
        self.ports.get(channel).copied()
    }

    /// Iterates over all ports.
    pub fn iter(&self) -> Iter<'a, T> {
        Iter(self.ports.iter())
    }

    /// Iterates over the ports that are present.
    pub fn iterate_set(&self) -> impl Iterator<Item = &'a Port<T>> {
        self.iter().filter(|port| port.is_present())
    }

    /// Iterates over the values of present ports.
    pub fn iterate_values(&self) -> impl Iterator<Item = T>
    where
        T: Copy,
    {
        self.iterate_values_ref().copied()
    }

    /// Iterates over references to the values of present ports.
    pub fn iterate_values_ref(&self) -> impl Iterator<Item = &'a T> {
        self.iter().filter_map(Readable::value)
    }

    /// Iterates over the ports that are present, each with its channel.
    pub fn enumerate_set(&self) -> impl Iterator<Item = (usize, &'a Port<T>)> {
        self.iter().enumerate().filter(|(_, port)| port.is_present())
    }

    /// Iterates over the values of present ports, each with its channel.
    pub fn enumerate_values(&self) -> impl Iterator<Item = (usize, T)>
    where
        T: Copy,
    {
        self.enumerate_values_ref().map(|(channel, value)| (channel, *value))
    }

    /// Iterates over references to the values of present ports, each with its channel.
    pub fn enumerate_values_ref(&self) -> impl Iterator<Item = (usize, &'a T)> {
        self.iter().enumerate().filter_map(|(channel, port)| Some((channel, port.value()?)))
    }
}

impl<T> Index<usize> for Multiport<'_, T> {
    type Output = Port<T>;

    /// Returns the port of a channel.
    ///
    /// # Panics
    /// If there is no such channel.
    fn index(&self, channel: usize) -> &Port<T> {
        self.ports[channel]
    }
}

impl<'a, T> IntoIterator for &Multiport<'a, T> {
    type Item = &'a Port<T>;
    type IntoIter = Iter<'a, T>;

    fn into_iter(self) -> Iter<'a, T> {
        self.iter()
    }
}

impl<T: fmt::Debug> fmt::Debug for Multiport<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Multiport").field(&self.ports).finish()
    }
}

/// All ports of a [`Multiport`].
#[derive(Debug)]
pub struct Iter<'a, T>(slice::Iter<'a, &'a Port<T>>);

impl<'a, T> Iterator for Iter<'a, T> {
    type Item = &'a Port<T>;

    fn next(&mut self) -> Option<&'a Port<T>> {
        self.0.next().copied()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl<T> ExactSizeIterator for Iter<'_, T> {}

/// The channels of a multiport that a body writes, or the ports of the members of a bank, member by member.
pub struct MultiportMut<'a, 'p, T> {
    ports: &'a mut [&'p mut Port<T>],
}

impl<'a, 'p, T> MultiportMut<'a, 'p, T> {
    /// Returns a multiport of these ports.
    pub const fn new(ports: &'a mut [&'p mut Port<T>]) -> Self {
        Self { ports }
    }

    /// Returns the number of channels.
    pub const fn len(&self) -> usize {
        self.ports.len()
    }

    /// Returns whether there are no channels.
    pub const fn is_empty(&self) -> bool {
        self.ports.is_empty()
    }

    /// Returns one of the ports, to be set.
    pub fn get_mut(&mut self, channel: usize) -> Option<&mut Port<T>> {
        self.ports.get_mut(channel).map(|port| &mut **port)
    }

    /// Iterates over all ports, to be read.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Port<T>> {
        self.ports.iter().map(|port| &**port)
    }

    /// Iterates over all ports, to be set.
    pub fn iter_mut(&mut self) -> IterMut<'_, 'p, T> {
        IterMut(self.ports.iter_mut())
    }
}

impl<T> Index<usize> for MultiportMut<'_, '_, T> {
    type Output = Port<T>;

    /// Returns the port of a channel.
    ///
    /// # Panics
    /// If there is no such channel.
    fn index(&self, channel: usize) -> &Port<T> {
        self.ports[channel]
    }
}

impl<T> IndexMut<usize> for MultiportMut<'_, '_, T> {
    /// Returns the port of a channel.
    ///
    /// # Panics
    /// If there is no such channel.
    fn index_mut(&mut self, channel: usize) -> &mut Port<T> {
        self.ports[channel]
    }
}

impl<'a, 'p, T> IntoIterator for &'a mut MultiportMut<'_, 'p, T> {
    type Item = &'a mut Port<T>;
    type IntoIter = IterMut<'a, 'p, T>;

    fn into_iter(self) -> IterMut<'a, 'p, T> {
        self.iter_mut()
    }
}

impl<T: fmt::Debug> fmt::Debug for MultiportMut<'_, '_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("MultiportMut").field(&self.ports).finish()
    }
}

/// All ports of a [`MultiportMut`].
#[derive(Debug)]
pub struct IterMut<'a, 'p, T>(slice::IterMut<'a, &'p mut Port<T>>);

impl<'a, T> Iterator for IterMut<'a, '_, T> {
    type Item = &'a mut Port<T>;

    fn next(&mut self) -> Option<&'a mut Port<T>> {
        self.0.next().map(|port| &mut **port)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl<T> ExactSizeIterator for IterMut<'_, '_, T> {}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::{Multiport, MultiportMut};
    use crate::port::Port;
    use crate::tables::PortId;

    #[test]
    fn a_body_sees_channels_and_their_values_in_order() {
        let ports = [Some(3), None, Some(5)].map(|value| Port { id: PortId(0), value });
        let borrowed = ports.each_ref();
        let channels = Multiport::new(&borrowed);
        assert_eq!((channels.len(), channels.is_empty()), (3, false));
        assert_eq!(channels.iterate_values().collect::<Vec<_>>(), [3, 5]);
        assert_eq!(channels.enumerate_values().collect::<Vec<_>>(), [(0, 3), (2, 5)]);
        assert_eq!(channels.iterate_set().count(), 2);
        assert_eq!(channels.enumerate_set().map(|(channel, _)| channel).collect::<Vec<_>>(), [0, 2]);
        assert_eq!((channels[2].value, channels.get(3).is_none()), (Some(5), true));
        assert_eq!(channels.get(0).and_then(|port| port.value), Some(3));
        assert_eq!((&channels).into_iter().len(), 3);
        assert!(Multiport::<u32>::new(&[]).is_empty());
    }

    #[test]
    fn a_body_sets_channels_by_number_and_one_after_the_other() {
        let mut ports = [const { Port::new(PortId(0)) }; 3];
        let mut borrowed = ports.each_mut();
        let channels = &mut MultiportMut::new(&mut borrowed);
        assert_eq!((channels.len(), channels.is_empty(), channels.into_iter().len()), (3, false, 3));
        for (number, port) in channels.into_iter().enumerate() {
            port.value = Some(number);
        }
        channels[1].value = Some(7);
        if let Some(port) = channels.get_mut(2) {
            port.value = Some(9);
        }
        assert_eq!(channels.iter().map(|port| port.value).collect::<Vec<_>>(), [Some(0), Some(7), Some(9)]);
        assert!(MultiportMut::<u32>::new(&mut []).is_empty());
    }
}
