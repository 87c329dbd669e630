// SPDX-License-Identifier: Apache-2.0
//! Sizes of C types, which the target's compiler has put into an object.
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use object::{Object, ObjectSymbol};

/// Returns the sizes of the arrays `lf_size_N`, by the names of Rust constants.
pub(crate) fn read(object: &Path) -> BTreeMap<String, u64> {
    let bytes = fs::read(object).unwrap_or_else(|error| panic!("{} cannot be read: {error}", object.display()));
    let file =
        object::File::parse(&*bytes).unwrap_or_else(|error| panic!("{} is no object: {error}", object.display()));
    let sizes = file.symbols().filter_map(|symbol| {
        let number = symbol.name().ok()?.strip_prefix("lf_size_")?;
        Some((format!("LF_SIZE_{number}"), symbol.size()))
    });
    sizes.collect()
}
