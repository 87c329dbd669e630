// SPDX-License-Identifier: Apache-2.0
//! The places of instances, ports and triggers in the struct that owns them: fields, or elements of fields.
//!
//! What the members of a bank have, and the channels of a multiport, are elements of an array: `self.workers[3]`,
//! `self.workers_out[3][0]`. Then one arm of `Program` serves all members, which is quicker to compile, and to run: a
//! processor's cache has no room for the code of each member of a large bank. Where Rust cannot see that two elements
//! differ, they are fields.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use proc_macro2::{Ident, TokenStream};
use quote::quote;

/// A field, or an element of one.
#[derive(Clone)]
pub(in crate::emit) struct PlaceExpression {
    field: Ident,
    /// The member's position, and the channel's.
    indices: Vec<usize>,
}

impl PlaceExpression {
    pub(super) fn field(field: Ident) -> Self {
        Self { field, indices: Vec::new() }
    }

    /// Returns the field, if this is all of it or its first element.
    pub(super) fn begun_field(&self) -> Option<&Ident> {
        self.indices.iter().all(|index| *index == 0).then_some(&self.field)
    }

    /// Returns the expression of the array of which it is an element.
    pub(super) fn around(&self) -> String {
        let indices = self.indices.split_last().map_or(&[][..], |(_, others)| others);
        Self { field: self.field.clone(), indices: indices.to_vec() }.to_string()
    }
}

impl fmt::Display for PlaceExpression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "self.{}", self.field)?;
        self.indices.iter().try_for_each(|index| write!(f, "[{index}]"))
    }
}

/// Parts with one path but for the indices of members and channels, in the order of these.
pub(in crate::emit) struct Group {
    /// Their path without indices.
    path: String,
    pub(super) parts: Vec<usize>,
    /// The number of channels of each member, if members have several.
    pub(super) width: Option<usize>,
}

impl Group {
    /// Returns those that can be arrays: with several parts, which `are_alike`.
    pub(super) fn of<'a>(paths: impl Iterator<Item = &'a str>, are_alike: impl Fn(usize, usize) -> bool) -> Vec<Self> {
        let mut groups: BTreeMap<String, Vec<(usize, Option<usize>)>> = BTreeMap::new();
        for (part, path) in paths.enumerate() {
            let (without, channel) = split(path);
            groups.entry(without).or_default().push((part, channel));
        }
        let group = |(path, parts): (String, Vec<(usize, Option<usize>)>)| {
            let channels: Vec<_> = parts.iter().map(|(_, channel)| channel.unwrap_or(0)).collect();
            let width = channels.iter().skip(1).position(|channel| *channel == 0).map_or(channels.len(), |end| end + 1);
            let is_even = parts.len() % width == 0 && channels.iter().enumerate().all(|(at, one)| at % width == *one);
            let parts: Vec<_> = parts.into_iter().map(|(part, _)| part).collect();
            let fits = path.contains('[') && parts.len() > 1 && is_even;
            let width = (width > 1 && width < parts.len()).then_some(width);
            let fits = fits && parts.iter().all(|part| are_alike(parts[0], *part));
            fits.then_some(Self { path, parts, width })
        };
        groups.into_iter().filter_map(group).collect()
    }

    /// Returns the name that its field should have.
    pub(super) fn name(&self) -> String {
        self.path.replace("[]", "")
    }

    /// Returns the place of each part in this field.
    pub(super) fn places(&self, field: &Ident) -> impl Iterator<Item = (usize, PlaceExpression)> {
        self.parts.iter().enumerate().map(|(position, part)| {
            let indices = match self.width {
                Some(width) => vec![position / width, position % width],
                None => vec![position],
            };
            (*part, PlaceExpression { field: field.clone(), indices })
        })
    }

    /// Returns the type of the array, of elements of a type.
    pub(super) fn array_type(&self, element: &str) -> String {
        match self.width {
            Some(width) => format!("[[{element}; {width}]; {}]", self.parts.len() / width),
            None => format!("[{element}; {}]", self.parts.len()),
        }
    }

    /// Returns the array of these elements, in the order of the parts.
    pub(super) fn array(&self, elements: &[TokenStream]) -> TokenStream {
        let Some(width) = self.width else { return quote!([#(#elements),*]) };
        let rows = elements.chunks(width).map(|row| quote!([#(#row),*]));
        quote!([#(#rows),*])
    }

    /// Returns whether these parts are the whole array, or the whole element of a member.
    pub(super) fn is_whole(&self, parts: &[usize]) -> bool {
        let mut rows = self.parts.chunks(self.width.unwrap_or(self.parts.len()));
        rows.any(|row| row == parts)
    }
}

/// Returns a path without indices, and the index at its end: a channel's or, in the path of an instance, a member's.
fn split(path: &str) -> (String, Option<usize>) {
    let (mut without, mut last, mut rest) = (String::new(), None, path);
    while let Some((before, indexed)) = rest.split_once('[') {
        let (index, after) = indexed.split_once(']').unwrap_or((indexed, ""));
        without = without + before + "[]";
        (last, rest) = (index.parse().ok().filter(|_| after.is_empty()), after);
    }
    (without + rest, last)
}

/// The parts of arrays that one reaction uses.
#[derive(Default)]
pub(super) struct ArrayUses {
    /// The group of each used part, and whether the use changes it.
    all: Vec<(usize, bool)>,
}

impl ArrayUses {
    /// Adds the use of parts by one parameter, each with its group if it has one. Those of a whole array that are
    /// changed count once.
    pub(super) fn add(&mut self, groups: &[Group], of: &BTreeMap<usize, usize>, parts: &[usize], changes: bool) {
        let found = parts.iter().filter_map(|part| of.get(part));
        let uses: Vec<_> = found.map(|group| (*group, changes)).collect();
        match uses.first() {
            Some((group, true)) if groups[*group].is_whole(parts) => self.all.push((*group, true)),
            _ => self.all.extend(uses),
        }
    }

    /// Returns the groups of which Rust cannot see that the uses do not overlap.
    pub(super) fn clashes(&self) -> BTreeSet<usize> {
        let clashes = |group: &usize| {
            let uses = || self.all.iter().filter(|(of, _)| of == group);
            uses().count() > 1 && uses().any(|(_, changes)| *changes)
        };
        self.all.iter().map(|(group, _)| *group).filter(clashes).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_banks_and_multiports_are_grouped_in_rows() {
        let paths =
            ["a", "m[0]", "m[1]", "w[0].out[0]", "w[0].out[1]", "w[1].out[0]", "w[1].out[1]", "w[0].x", "w[1].x"];
        let uneven = ["v[0].y[0]", "v[0].y[1]", "v[1].y[0]", "one[0]"];
        let groups = Group::of(paths.into_iter().chain(uneven), |_, _| true);
        let found: Vec<_> = groups.iter().map(|group| (group.name(), group.parts.clone(), group.width)).collect();
        let expected = [("m", vec![1, 2], None), ("w.out", vec![3, 4, 5, 6], Some(2)), ("w.x", vec![7, 8], None)];
        assert_eq!(found, expected.map(|(name, parts, width)| (name.to_owned(), parts, width)));
        let field = Ident::new("w_out", proc_macro2::Span::call_site());
        let places: Vec<_> = groups[1].places(&field).map(|(part, place)| (part, place.to_string())).collect();
        assert_eq!(places[2], (5, "self.w_out[1][0]".to_owned()));
        assert!(groups[1].is_whole(&[5, 6]) && !groups[1].is_whole(&[4, 5]) && groups[0].is_whole(&[1, 2]));
    }

    #[test]
    fn a_changed_part_beside_others_of_its_array_is_a_clash() {
        let groups = Group::of(["m[0]", "m[1]", "n[0]", "n[1]"].into_iter(), |_, _| true);
        let of = BTreeMap::from([(0, 0), (1, 0), (2, 1), (3, 1)]);
        let clashes = |uses: &[(&[usize], bool)]| {
            let mut all = ArrayUses::default();
            for (parts, changes) in uses {
                all.add(&groups, &of, parts, *changes);
            }
            all.clashes().into_iter().collect::<Vec<_>>()
        };
        assert_eq!(clashes(&[(&[0], false), (&[1], false), (&[2], true)]), [] as [usize; 0]);
        assert_eq!(clashes(&[(&[0, 1], true), (&[2, 3], false)]), [] as [usize; 0]);
        assert_eq!(clashes(&[(&[1, 0], true)]), [0]);
        assert_eq!(clashes(&[(&[0], true), (&[1], false), (&[2], false), (&[3], true)]), [0, 1]);
    }
}
