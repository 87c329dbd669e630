// SPDX-License-Identifier: Apache-2.0
//! What a linker's map says of an image.

/// In bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Share {
    pub(super) text: u64,
    pub(super) rodata: u64,
    pub(super) data: u64,
    pub(super) bss: u64,
}

/// What of an image is of the Rust library, of the application and of this repository's Zephyr module.
pub(super) fn share(map: &str) -> Share {
    let mut share = Share::default();
    for_each_of_ours(map, |section, size, _| {
        let kind = section.trim_start_matches('.').split('.').next().unwrap_or_default();
        match kind {
            "text" => share.text += size,
            "rodata" => share.rodata += size,
            "data" => share.data += size,
            "bss" | "noinit" | "COMMON" => share.bss += size,
            _ => {}
        }
    });
    share
}

/// The columns of a table of [`text_by_part`].
pub(super) const PARTS: [&str; 10] =
    ["", "model", "wire", "coordination", "runtime", "embedded", "zephyr", "core", "other crates", "C"];
/// Crates whose code is told apart.
const CRATES: [&str; 7] = ["lf_model", "lf_wire", "lf_coordination", "lf_runtime", "lf_embedded", "lf_zephyr", "core"];

/// The code by [`CRATES`], that of others, and what is C.
pub(super) fn text_by_part(map: &str) -> [u64; CRATES.len() + 2] {
    let mut parts = [0; CRATES.len() + 2];
    for_each_of_ours(map, |section, size, is_rust| {
        if let Some(symbol) = section.strip_prefix(".text.") {
            let of = crate_of(symbol);
            let place = CRATES.iter().position(|name| of == Some(name)).unwrap_or(CRATES.len());
            let place = if is_rust { place } else { CRATES.len() + 1 };
            parts[place] += size;
        }
    });
    parts
}

/// The first crate that a symbol names, and `core` only if there is no other. In symbols a crate's name stands after a
/// number, with its length before it: `Cs1a2B3c_13lf_coordination`.
fn crate_of(symbol: &str) -> Option<&str> {
    let name = |part: &'_ str| -> Option<&str> {
        let part = &symbol[symbol.len() - part.len()..];
        let (number, rest) = part.split_once('_')?;
        let digits = rest.len() - rest.trim_start_matches(|sign: char| sign.is_ascii_digit()).len();
        let length: usize = rest[..digits].parse().ok()?;
        number.bytes().all(|byte| byte.is_ascii_alphanumeric()).then(|| rest.get(digits..digits + length))?
    };
    let names = || symbol.match_indices("Cs").filter_map(|(at, _)| name(&symbol[at + 2..]));
    names().find(|name| *name != "core").or_else(|| names().next())
}

/// Hands on each section of what is ours: its name, its bytes, and whether it is of the Rust library.
fn for_each_of_ours(map: &str, mut each: impl FnMut(&str, u64, bool)) {
    let Some((_, map)) = map.split_once("Linker script and memory map") else { return };
    let mut section = "";
    for line in map.lines() {
        let mut words = line.split_whitespace().peekable();
        // Sections begin after one blank, what is continued in the next line after many.
        if line.starts_with(" .") || line.starts_with(" COMMON") {
            section = words.next().unwrap_or_default();
        } else if !line.starts_with("   ") {
            section = "";
        }
        let (Some(address), Some(size), Some(file)) = (words.next(), words.next(), words.next()) else { continue };
        let (Some(address), Some(size)) = (hexadecimal(address), hexadecimal(size)) else { continue };
        let is_ours =
            ["librustapp.a(", "app/libapp.a(", "modules/lf-zephyr-rs/"].iter().any(|part| file.contains(part));
        // What is at 0 is not in the image.
        if !is_ours || address == 0 {
            continue;
        }
        each(section, size, file.contains("librustapp.a("));
        section = "";
    }
}

fn hexadecimal(word: &str) -> Option<u64> {
    u64::from_str_radix(word.strip_prefix("0x")?, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: &str = "\
Discarded input sections

 .text.gone     0x0000000000000000       0x10 /b/lf/librustapp.a(rustapp.o)

Linker script and memory map

 .text.lf_main  0x0000000000001000       0x20 /b/lf/librustapp.a(rustapp.o)
 .text._RNvMNtNtCsxQLjlM4FvJ_15lf_coordination8federate7running
                0x0000000000001020      0x100 /b/lf/librustapp.a(rustapp.o)
 .text.tcp_recv
                0x0000000000002000      0x200 zephyr/subsys/net/ip/libsubsys__net__ip.a(tcp.c.obj)
 .rodata.main.str1.1
                0x0000000000003000       0x30 app/libapp.a(main.c.obj)
                                         0x38 (size before relaxing)
 .bss.lost      0x0000000020000000       0x08 modules/lf-zephyr-rs/lib..__zephyr.a(fatal.c.obj)
 .debug_info    0x0000000000000000     0x1000 app/libapp.a(main.c.obj)
 *fill*         0x0000000020000008        0x4
";

    #[test]
    fn only_what_is_ours_and_in_the_image_counts() {
        assert_eq!(share(MAP), Share { text: 0x120, rodata: 0x30, data: 0, bss: 8 });
        assert_eq!(text_by_part(MAP), [0, 0, 0x100, 0, 0, 0, 0, 0x20, 0]);
    }
}
