// SPDX-License-Identifier: Apache-2.0
//! Lists whose positions have types of their own, so that no position can be used in another list.

use core::marker::PhantomData;
use core::ops::{Index, IndexMut};

/// A position in an [`Arena`].
pub(crate) trait ArenaId: Copy {
    /// Returns the id of a position.
    fn at(position: usize) -> Self;

    /// Returns the position.
    fn position(self) -> usize;
}

/// Declares types of positions.
macro_rules! arena_ids {
    ($($(#[$doc:meta])+ $visibility:vis $name:ident;)+) => {$(
        $(#[$doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        $visibility struct $name(usize);

        impl $crate::arena::ArenaId for $name {
            fn at(position: usize) -> Self {
                Self(position)
            }

            fn position(self) -> usize {
                self.0
            }
        }
    )+};
}
pub(crate) use arena_ids;

/// A list that is read by positions of one type.
#[derive(Clone, Debug)]
pub(crate) struct Arena<I, T> {
    list: Vec<T>,
    ids: PhantomData<fn() -> I>,
}

impl<I: ArenaId, T> Arena<I, T> {
    /// Returns a list of as many equal items as another list has.
    pub(crate) fn of<U>(other: &Arena<I, U>, item: T) -> Self
    where
        T: Clone,
    {
        vec![item; other.len()].into()
    }

    /// Adds an item.
    pub(crate) fn push(&mut self, item: T) -> I {
        self.list.push(item);
        I::at(self.list.len() - 1)
    }

    /// Returns the id of the item that is added next.
    pub(crate) fn next_id(&self) -> I {
        I::at(self.list.len())
    }

    /// Returns the number of items.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns the positions of all items.
    pub(crate) fn ids(&self) -> impl DoubleEndedIterator<Item = I> + use<I, T> {
        (0..self.list.len()).map(I::at)
    }

    /// Returns all items with their positions.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (I, &T)> {
        self.list.iter().enumerate().map(|(position, item)| (I::at(position), item))
    }

    /// Returns all items.
    pub(crate) fn values(&self) -> core::slice::Iter<'_, T> {
        self.list.iter()
    }

    /// Returns all items, to change them.
    pub(crate) fn values_mut(&mut self) -> core::slice::IterMut<'_, T> {
        self.list.iter_mut()
    }
}

impl<I, T> Default for Arena<I, T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<I, T> From<Vec<T>> for Arena<I, T> {
    fn from(list: Vec<T>) -> Self {
        Self { list, ids: PhantomData }
    }
}

impl<I: ArenaId, T> Extend<T> for Arena<I, T> {
    fn extend<A: IntoIterator<Item = T>>(&mut self, items: A) {
        self.list.extend(items);
    }
}

impl<I: ArenaId, T> FromIterator<T> for Arena<I, T> {
    fn from_iter<A: IntoIterator<Item = T>>(items: A) -> Self {
        Vec::from_iter(items).into()
    }
}

impl<I: ArenaId, T> Index<I> for Arena<I, T> {
    type Output = T;

    fn index(&self, id: I) -> &T {
        &self.list[id.position()]
    }
}

impl<I: ArenaId, T> IndexMut<I> for Arena<I, T> {
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.list[id.position()]
    }
}
