// SPDX-License-Identifier: Apache-2.0
//! Flash and RAM of images for a small board, and whose they are.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use super::super::Applications;
use super::super::run::run;
use super::map::{PARTS, Share, share, text_by_part};
use crate::Result;
use crate::results::{Axis, Cell, Figure, Finding, Plot, Table};

const BOARD: &str = "qemu_cortex_m3";
/// Federates of the program whose RTI is measured alone.
const MANY: usize = 8;

/// What was measured of one image, in bytes.
struct Image {
    name: String,
    flash: u64,
    ram: u64,
    empty: (u64, u64),
    ours: Share,
    /// The stacks of the main thread and of the RTI.
    stacks: u64,
    /// Our code by [`PARTS`].
    code: Vec<u64>,
}

/// Measures images, the same without a federate, and what of each is this project's.
///
/// # Errors
/// When an image cannot be built, or what the build leaves cannot be understood.
pub fn sizes(applications: &Applications) -> Result<Finding> {
    let grid = applications.file("smart_grid/src/SmartGrid.lf");
    let joint = applications.file("smart_grid/deployment/topology3.yaml");
    let (many, alone) = many(applications)?;
    let message = applications.file("message_test/src/MessageTest.lf");
    let sender = deployment(applications, "sender.yaml", None, &["sender", "receiver"])?;
    let all = [
        ("message test's sender".to_owned(), &message, &sender, "sender"),
        ("smart grid's unit B".to_owned(), &grid, &joint, "b"),
        ("joint RTI and unit A, 4 federates".to_owned(), &grid, &joint, "a"),
        (format!("RTI alone, {MANY} federates"), &many, &alone, "rti"),
    ];
    // A quick run leaves out those without texts, and all but the first one.
    let (count, variants): (_, &[bool]) = if applications.quick { (1, &[true]) } else { (all.len(), &[true, false]) };
    let mut images = Vec::new();
    for (name, file, deployment, participant) in &all[..count] {
        let mut empty = None;
        for &texts in variants {
            let name = if texts { name.clone() } else { format!("{name}, without texts") };
            let (folder, flash, ram) = build(applications, file, deployment, participant, texts)?;
            let empty = match empty {
                Some(sizes) => sizes,
                None => *empty.insert(build_empty(applications, &folder)?),
            };
            let map = fs::read_to_string(folder.join("zephyr/zephyr.map"))?;
            let mut ours = share(&map);
            let stacks = stacks(&fs::read_to_string(folder.join("zephyr/.config"))?);
            // The RTI's stack is in the application's own memory, and is told apart from it here.
            ours.bss = ours.bss.saturating_sub(stacks.rti);
            let code = text_by_part(&map).to_vec();
            images.push(Image { name, flash, ram, empty, ours, stacks: stacks.main + stacks.rti, code });
        }
    }
    Ok(finding(&images))
}

fn finding(images: &[Image]) -> Finding {
    let headings = [
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
    ];
    let mut table = Table::new("The images in KiB", headings);
    let mut parts = Table::new("The project's code by crates in KiB", PARTS);
    let (mut flash_bars, mut code_bars) = (Vec::new(), Vec::new());
    for Image { name, flash, ram, empty: (empty_flash, empty_ram), ours, stacks, code } in images {
        let (our_flash, our_ram) = (ours.text + ours.rodata + ours.data, ours.data + ours.bss + stacks);
        let Share { text, rodata, data, bss } = *ours;
        let numbers = [*flash, *ram, *empty_flash, *empty_ram, text, rodata, data, bss, *stacks, our_flash, our_ram];
        let cells = |numbers: &[u64]| numbers.iter().map(|bytes| Cell::number(kib(*bytes), 1)).collect::<Vec<_>>();
        table.row([vec![name.as_str().into()], cells(&numbers)].concat());
        parts.row([vec![name.as_str().into()], cells(code)].concat());
        // What is neither ours nor in the empty image is what of Zephyr only the program calls.
        let called = flash.saturating_sub(*empty_flash).saturating_sub(our_flash);
        flash_bars.push((name.clone(), [*empty_flash, called, text, rodata, data].map(kib).to_vec()));
        code_bars.push((name.clone(), code.iter().copied().map(kib).collect()));
    }
    let names = ["Zephyr, empty main()", "Zephyr, called", "our code", "our constants", "our data"];
    let figure = |title: &str, caption: &str, parts: &[&str], bars| Figure {
        title: title.to_owned(),
        thesis: String::new(),
        caption: caption.to_owned(),
        plot: Plot::Stacked { axis: Axis::linear("KiB"), parts: parts.iter().map(ToString::to_string).collect(), bars },
    };
    Finding {
        title: format!("Images for {BOARD}"),
        question: "How large are images for a small board, and what of them is this project's?".to_owned(),
        method: [
            "In KiB: as they are, with an empty main() instead, and this project's share by the linker's map.",
            "The buffers of connections are in .bss; stacks are the main thread's and the RTI's.",
            "The project's .text by the crates that it is from; what is inlined counts where it is inlined.",
        ]
        .map(str::to_owned)
        .to_vec(),
        tables: vec![table, parts],
        figures: vec![
            figure("Flash", "All of an image; without texts, errors are codes.", &names, flash_bars),
            figure("Our code by crates", "The .text of the image that is this project's.", &PARTS[1..], code_bars),
        ],
        limits: vec!["The thesis does not tell sizes of its images.".to_owned()],
        ..Finding::default()
    }
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
fn kib(bytes: u64) -> f64 {
    bytes as f64 / 1024.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_bar_are_the_whole_image() {
        let image = Image {
            name: "sender".to_owned(),
            flash: 100 * 1024,
            ram: 30 * 1024,
            empty: (60 * 1024, 28 * 1024),
            ours: Share { text: 24 * 1024, rodata: 8 * 1024, data: 1024, bss: 512 },
            stacks: 8192,
            code: vec![1024; PARTS.len() - 1],
        };
        let finding = finding(&[image]);
        let cells: Vec<_> = finding.tables[0].rows[0].iter().map(Cell::to_string).collect();
        assert_eq!(
            cells,
            ["sender", "100.0", "30.0", "60.0", "28.0", "24.0", "8.0", "1.0", "0.5", "8.0", "33.0", "9.5"]
        );
        let Plot::Stacked { bars, parts, .. } = &finding.figures[0].plot else { panic!("bars are stacked") };
        assert_eq!(bars[0].1, [60.0, 7.0, 24.0, 8.0, 1.0]);
        assert_eq!(parts.len(), bars[0].1.len());
        let Plot::Stacked { bars, parts, .. } = &finding.figures[1].plot else { panic!("bars are stacked") };
        assert_eq!(parts.len(), bars[0].1.len());
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
