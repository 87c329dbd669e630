// SPDX-License-Identifier: Apache-2.0
//! Flash and RAM of images for a small board, and whose they are.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use super::super::Applications;
use super::super::run::run;
use crate::{Result, Table};

const BOARD: &str = "qemu_cortex_m3";
/// Federates of the program whose RTI is measured alone.
const MANY: usize = 8;

/// Measures images, the same without a federate, and what of each is this project's.
///
/// # Errors
/// When an image cannot be built, or what the build leaves cannot be understood.
pub fn sizes(applications: &Applications) -> Result<()> {
    println!("\nImages for {BOARD} in KiB: as they are, with an empty main() instead, and this project's share by the");
    println!("linker's map. The buffers of connections are in .bss; stacks are the main thread's and the RTI's.");
    println!("Then the project's .text by the crates that it is from; what is inlined counts where it is inlined.");
    let mut table = Table::new(&[
        "",
        "flash",
        "RAM",
        "empty: flash",
        "empty: RAM",
        ".text",
        ".rodata",
        ".data",
        ".bss",
        "stacks",
        "our flash",
        "our RAM",
    ]);
    let mut parts = Table::new(&PARTS);
    let grid = applications.file("smart_grid/src/SmartGrid.lf");
    let joint = applications.file("smart_grid/deployment/topology3.yaml");
    let (many, alone) = many(applications)?;
    let message = applications.file("message_test/src/MessageTest.lf");
    let sender = deployment(applications, "sender.yaml", None, &["sender", "receiver"])?;
    for (name, file, deployment, participant) in [
        ("message test's sender".to_owned(), &message, &sender, "sender"),
        ("smart grid's unit B".to_owned(), &grid, &joint, "b"),
        ("joint RTI and unit A, 4 federates".to_owned(), &grid, &joint, "a"),
        (format!("RTI alone, {MANY} federates"), &many, &alone, "rti"),
    ] {
        let mut empty = None;
        for texts in [true, false] {
            let name = if texts { name.clone() } else { format!("{name}, without texts") };
            let (folder, flash, ram) = build(applications, file, deployment, participant, texts)?;
            let (empty_flash, empty_ram) = match empty {
                Some(sizes) => sizes,
                None => *empty.insert(build_empty(applications, &folder)?),
            };
            let map = fs::read_to_string(folder.join("zephyr/zephyr.map"))?;
            let ours = share(&map);
            let stacks = stacks(&fs::read_to_string(folder.join("zephyr/.config"))?);
            // The RTI's stack is in the application's own memory, and is told apart from it here.
            let bss = ours.bss.saturating_sub(stacks.rti);
            let both = stacks.main + stacks.rti;
            let numbers = [flash, ram, empty_flash, empty_ram, ours.text, ours.rodata, ours.data, bss, both];
            let sums = [ours.text + ours.rodata + ours.data, ours.data + bss + both];
            table.row([name.clone()].into_iter().chain(numbers.into_iter().chain(sums).map(kib)).collect());
            parts.row([name].into_iter().chain(text_by_part(&map).map(kib)).collect());
        }
    }
    println!("\n{table}\n{parts}");
    Ok(())
}

/// A program of many federates, and its deployment with the RTI as an image of its own.
fn many(applications: &Applications) -> Result<(PathBuf, PathBuf)> {
    let names: Vec<String> = (1..=MANY).map(|index| format!("node{index}")).collect();
    let mut text = "target Rust\nreactor Node {\n  input x: u32\n  output y: u32\n  timer t(0, 1 sec)\n\
                    \x20 reaction(t, x) -> y {= ctx.set(y, 1); =}\n}\nfederated reactor {\n"
        .to_owned();
    for name in &names {
        let _ = writeln!(text, "  {name} = new Node()");
    }
    for pair in names.windows(2) {
        let _ = writeln!(text, "  {}.y -> {}.x", pair[0], pair[1]);
    }
    text.push_str("}\n");
    let file = applications.variant("Many", &text)?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Ok((file, deployment(applications, "many.yaml", Some(BOARD), &names)?))
}

/// A deployment of these federates on boards, with the RTI on a board too, or on this computer.
fn deployment(applications: &Applications, name: &str, rti: Option<&str>, federates: &[&str]) -> Result<PathBuf> {
    let mut text = format!("rti: {{ platform: {}, ip: 10.0.0.1 }}\nfederates:\n", rti.unwrap_or("host"));
    for (index, federate) in federates.iter().enumerate() {
        let _ = writeln!(text, "  {federate}: {{ platform: {BOARD}, ip: 10.0.0.{} }}", index + 2);
    }
    let file = applications.folder().join(name);
    fs::create_dir_all(applications.folder())?;
    fs::write(&file, text)?;
    Ok(file)
}

/// Builds one image; gives its build folder, and its flash and RAM in bytes.
fn build(
    applications: &Applications,
    file: &Path,
    deployment: &Path,
    name: &str,
    texts: bool,
) -> Result<(PathBuf, u64, u64)> {
    let build = applications.build_folder(file).join(if texts { "sizes" } else { "sizes-codes" }).join(name);
    let mut command = applications.west_in("lf-fed-build", file, &build);
    command.arg("--deployment").arg(deployment).args(["-f", name]);
    if !texts {
        command.args(["--", "-DCONFIG_LF_TEXTS=n", "-DCONFIG_LF_PANIC_TEXTS=n"]);
    }
    run(&mut command)?;
    let folder = build.join("zephyr").join(file.file_stem().unwrap_or_default()).join(name);
    let log = fs::read_to_string(folder.with_extension("log"))?;
    // Where nothing had to be linked again the numbers are from the time when it was.
    let kept = folder.join("lf_sizes.txt");
    let (flash, ram) = match usage(&log) {
        Some(sizes) => {
            fs::write(&kept, &log)?;
            sizes
        }
        None => fs::read_to_string(&kept).ok().and_then(|log| usage(&log)).ok_or("the linker has told no sizes")?,
    };
    Ok((folder, flash, ram))
}

/// Builds the image of this folder with an empty `main()`; gives its flash and RAM in bytes.
fn build_empty(applications: &Applications, folder: &Path) -> Result<(u64, u64)> {
    let cache = fs::read_to_string(folder.join("CMakeCache.txt"))?;
    let mut command = Command::new("west");
    let base = env::var_os("ZEPHYR_BASE").unwrap_or_default();
    command.current_dir(base).args(["build", "--board", BOARD, "--pristine", "always", "--build-dir"]);
    command.arg(folder.with_extension("empty")).arg(applications.repository.join("rust/bench/programs/empty"));
    command.arg("--");
    for variable in ["EXTRA_CONF_FILE", "EXTRA_DTC_OVERLAY_FILE"] {
        let line = cache.lines().find(|line| line.starts_with(variable));
        let value = line.and_then(|line| line.split_once('=')).map_or("", |(_, value)| value);
        command.arg(format!("-D{variable}={value}"));
    }
    usage(&run(&mut command)?).ok_or_else(|| "the linker has told no sizes".into())
}

/// What the linker says of its memory: `FLASH:      124228 B       256 KB     47.39%`.
fn usage(log: &str) -> Option<(u64, u64)> {
    let region = |name: &str| {
        let line = log.lines().find(|line| line.trim_start().starts_with(name))?;
        let mut words = line.split_once(':')?.1.split_whitespace();
        let number: u64 = words.next()?.parse().ok()?;
        let unit = match words.next()? {
            "B" => 1,
            "KB" => 1024,
            _ => return None,
        };
        Some(number * unit)
    };
    Some((region("FLASH:")?, region("RAM:")?))
}

/// In bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Share {
    text: u64,
    rodata: u64,
    data: u64,
    bss: u64,
}

/// What of an image is of the Rust library, of the application and of this repository's Zephyr module.
fn share(map: &str) -> Share {
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
const PARTS: [&str; 10] =
    ["", "model", "wire", "coordination", "runtime", "embedded", "zephyr", "core", "other crates", "C"];
/// Crates whose code is told apart.
const CRATES: [&str; 7] = ["lf_model", "lf_wire", "lf_coordination", "lf_runtime", "lf_embedded", "lf_zephyr", "core"];

/// The code by [`CRATES`], that of others, and what is C.
fn text_by_part(map: &str) -> [u64; CRATES.len() + 2] {
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

#[derive(Debug, PartialEq, Eq)]
struct Stacks {
    main: u64,
    rti: u64,
}

/// The stacks that an image's configuration gives to our threads. The main thread is the RTI's where there is no
/// federate, and then there is no other.
fn stacks(config: &str) -> Stacks {
    let number = |name: &str| {
        let value = config.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        value.and_then(|value| value.parse().ok()).unwrap_or(0)
    };
    let is_joint = ["CONFIG_LF_RTI=y", "CONFIG_LF_FEDERATE=y"].iter().all(|line| config.lines().any(|l| l == *line));
    Stacks {
        main: number("CONFIG_MAIN_STACK_SIZE"),
        rti: if is_joint { number("CONFIG_LF_RTI_STACK_SIZE") } else { 0 },
    }
}

#[expect(clippy::cast_precision_loss, reason = "images are far below 2^53 bytes")]
fn kib(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1024.0)
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

    #[test]
    fn the_linker_tells_what_is_used() {
        let log = "Memory region         Used Size  Region Size  %age Used\n           FLASH:      124228 B       \
                   256 KB     47.39%\n             RAM:         30 KB        64 KB     46.28%\n";
        assert_eq!(usage(log), Some((124_228, 30 * 1024)));
        assert_eq!(usage("nothing was linked"), None);
    }

    #[test]
    fn an_rti_beside_a_federate_has_a_stack_of_its_own() {
        let config = "CONFIG_LF_RTI=y\nCONFIG_MAIN_STACK_SIZE=8192\nCONFIG_LF_RTI_STACK_SIZE=4096\n";
        assert_eq!(stacks(config), Stacks { main: 8192, rti: 0 });
        assert_eq!(stacks(&format!("{config}CONFIG_LF_FEDERATE=y\n")), Stacks { main: 8192, rti: 4096 });
    }
}
