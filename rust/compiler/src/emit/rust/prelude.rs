// SPDX-License-Identifier: Apache-2.0
//! The names that bodies in Rust see without an import.

/// Rust's types that have no path.
pub(super) const PRIMITIVES: [&str; 17] = [
    "bool", "char", "f32", "f64", "i128", "i16", "i32", "i64", "i8", "isize", "str", "u128", "u16", "u32", "u64", "u8",
    "usize",
];

/// The names of the standard library that Rust code sees without an import.
pub(super) const KNOWN_TYPES: [&str; 38] = [
    "AsMut",
    "AsRef",
    "AsyncFn",
    "AsyncFnMut",
    "AsyncFnOnce",
    "Box",
    "Clone",
    "Copy",
    "Debug",
    "Default",
    "DoubleEndedIterator",
    "Drop",
    "Eq",
    "Err",
    "ExactSizeIterator",
    "Extend",
    "Fn",
    "FnMut",
    "FnOnce",
    "From",
    "FromIterator",
    "Hash",
    "Into",
    "IntoIterator",
    "Iterator",
    "None",
    "Ok",
    "Option",
    "Ord",
    "PartialEq",
    "PartialOrd",
    "Result",
    "Send",
    "Some",
    "String",
    "Sync",
    "ToString",
    "Vec",
];

/// The names of this project that bodies see without an import, on any platform.
pub(super) const PRELUDE: [&str; 36] = [
    "After",
    "Asap",
    "Duration",
    "EventTag",
    "FixedPayload",
    "Instant",
    "LogicalAction",
    "Multiport",
    "MultiportMut",
    "Offset",
    "Payload",
    "PhysicalAction",
    "PhysicalActionRef",
    "PhysicalLink",
    "Port",
    "PhysicalTime",
    "ReactionContext",
    "SpawnPhysicalThread",
    "Timer",
    "Watchdog",
    "after",
    "assert_tag_is",
    "debug",
    "delay",
    "device",
    "error",
    "heapless",
    "info",
    "log",
    "log_enabled",
    "payload",
    "println",
    "reactor_rt",
    "tag",
    "trace",
    "warn",
];

#[cfg(test)]
mod tests {
    use super::PRELUDE;

    #[test]
    fn all_that_bodies_see_is_known() {
        let in_lib = |text: &'static str| {
            let items = &text[text.find("pub mod prelude {").expect("it has a prelude")..];
            &items[..items.find("\n}").expect("it ends")]
        };
        let preludes = [
            in_lib(include_str!("../../../../model/src/lib.rs")),
            in_lib(include_str!("../../../../linux/src/lib.rs")),
            include_str!("../../../../zephyr/src/prelude.rs"),
        ];
        for items in preludes {
            let uses = items.split(';').filter_map(|item| item.rsplit_once("pub use ").map(|(_, item)| item));
            let uses = uses.map(|item| item.rsplit(" as ").next().unwrap_or(item));
            let names = uses.flat_map(|item| {
                let listed = item.split_once('{').map(|(_, list)| list.trim_end_matches('}'));
                listed.unwrap_or_else(|| item.rsplit("::").next().unwrap_or(item)).split(',').map(str::trim)
            });
            for name in names.filter(|name| !["", "*", "self", "eprint", "eprintln", "print"].contains(name)) {
                assert!(PRELUDE.contains(&name), "{name}");
            }
        }
    }
}
