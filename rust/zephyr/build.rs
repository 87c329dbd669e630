// SPDX-License-Identifier: Apache-2.0
//! Makes the Rust bindings of Zephyr, the constants that come from Kconfig, and the C header of this crate.
//!
//! It needs the variables that `zephyr/cmake/lf_cargo_build.cmake` sets; the ones that zephyr-lang-rust has too have
//! its names.

use std::env;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The bound functions: sockets, waiting, threads and their locks, the cycle counter, the console and the log.
const FUNCTIONS: &[&str] = &[
    "zsock_(socket|close|connect|bind|listen|accept|send|sendto|recv|recvfrom|shutdown)",
    "zsock_(getsockname|getsockopt|setsockopt|poll)",
    "zsock_fcntl_impl",
    "zvfs_eventfd(_read|_write)?",
    "k_thread_(create|join|name_set)",
    "k_mutex_(init|lock|unlock)",
    "k_condvar_(init|wait|signal|broadcast)",
    "k_cycle_get_(32|64)",
    "k_(sleep|usleep|msleep|busy_wait|yield|str_out|is_in_isr)",
    "lf_.*",
];

/// Constants, and enumerations of which Rust needs the names.
const ITEMS: &[&str] = &[
    "lf_network_error",
    "lf_console_lock",
    "ZSOCK_(POLL|SHUT).*",
    "ZVFS_(F_SETFL|O_NONBLOCK|EFD_NONBLOCK)",
    "(zvfs_pollfd|sockaddr_in6?|net_sock_type|net_ip_protocol)",
    "(lf_edge|lf_device_problem|sensor_channel)",
    "LF_(I2C_MESSAGES|SPI_PARTS)",
    "AF_INET6?",
    "IPV6_V6ONLY",
    "TCP_NODELAY",
    "SOL_SOCKET",
    "SO_(ERROR|KEEPALIVE|REUSEADDR)",
    "LOG_LEVEL_(ERR|WRN|INF|DBG)",
];

/// The Kconfig symbols that become constants of the module `kconfig`, all of them numbers.
const NUMBERS: &[&str] = &[
    "LF_SOCKETS",
    "LF_RECEIVE_BUFFER_SIZE",
    "LF_SEND_BUFFER_SIZE",
    "LF_USER_THREADS",
    "LF_USER_THREAD_CLOSURE_SIZE",
    "LF_INTERRUPTS",
    "LF_RTI_FEDERATES",
    "LF_RTI_UPSTREAM",
    "LF_RTI_CONNECTIONS",
    "LF_RTI_IN_TRANSIT",
    "LF_RTI_TRANSIENTS",
    "LF_RTI_BUFFER_SIZE",
    "LF_SECURITY_RECORD_SIZE",
    "LF_LINE_SIZE",
    "LF_TOKEN_SIZE",
    "LF_TRACE_RECORDS",
    "LF_LOG_LEVEL",
    "SYS_CLOCK_TICKS_PER_SEC",
];

/// The switches of Kconfig that Rust code is conditional on.
const SWITCHES: &[&str] = &[
    "TIMER_HAS_64BIT_CYCLE_COUNTER",
    "LOG",
    "NET_UDP",
    "LF_NETWORK",
    "LF_FEDERATE",
    "LF_RTI",
    "LF_SECURITY",
    "LF_INTERRUPTS",
    "GPIO",
    "PWM",
    "ADC",
    "I2C",
    "SPI",
    "SERIAL",
    "SENSOR",
    "LF_OSCILLOSCOPE",
    "LF_TRACE_VALUES",
];

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let output = PathBuf::from(variable("OUT_DIR")?);
    let arguments = clang_arguments()?;
    // For crates that bind headers of their own; `FLOATS` says whether Rust and C pass such numbers alike.
    let mut of_programs = arguments.clone();
    // The image's compiler makes enumerations as small as their values allow. Those that this crate has are passed in
    // registers, whatever their size.
    if variable("LF_C_SHORT_ENUMS")? == "1" {
        of_programs.push("-fshort-enums".to_owned());
    }
    println!("cargo::metadata=CLANG_ARGUMENTS={}", of_programs.join("\t"));
    println!("cargo::metadata=FLOATS={}", !Kconfig::read()?.is_set("ARCH_POSIX"));
    write_bindings(&output.join("bindings.rs"), arguments)?;
    write_kconfig(&output.join("kconfig.rs"))?;
    write_devices(&output.join("devices.rs"))?;
    write_header()
}

/// Returns a variable of the Zephyr build; cargo rebuilds the crate when it changes.
fn variable(name: &str) -> Outcome<String> {
    println!("cargo::rerun-if-env-changed={name}");
    env::var(name).map_err(|_| {
        format!("{name} is not set: lf-zephyr is built by CMake, by lf_federate() of zephyr/cmake/lf_federate.cmake")
            .into()
    })
}

fn write_bindings(to: &Path, clang_arguments: Vec<String>) -> Outcome<()> {
    let wrapper = variable("WRAPPER_FILE")?;
    // Without the file the image cannot be linked, even if nothing else has changed.
    println!("cargo::rerun-if-changed={wrapper}");
    // The wrapper includes the header by the name that is given here, from another folder.
    let header = format!("{}/wrapper.h", variable("CARGO_MANIFEST_DIR")?);
    let mut builder = bindgen::Builder::default()
        .header(header)
        .use_core()
        .wrap_static_fns(true)
        .wrap_static_fns_path(&wrapper)
        .derive_default(true)
        .default_enum_style(bindgen::EnumVariation::ModuleConsts)
        .layout_tests(false)
        .generate_comments(false)
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()))
        .clang_args(clang_arguments);
    for functions in FUNCTIONS {
        builder = builder.allowlist_function(functions);
    }
    for items in ITEMS {
        builder = builder.allowlist_item(items);
    }
    builder.generate()?.write_to_file(to)?;
    Ok(())
}

fn clang_arguments() -> Outcome<Vec<String>> {
    let target = variable("TARGET")?;
    let before = format!("{}/before.h", variable("CARGO_MANIFEST_DIR")?);
    println!("cargo::rerun-if-changed={before}");
    let mut arguments = ["-DLF_BINDGEN", "-include", &before].map(str::to_owned).to_vec();
    for (prefix, name) in [("-I", "INCLUDE_DIRS"), ("-D", "INCLUDE_DEFINES")] {
        let values = variable(name)?;
        let values = values.split([' ', ';']).filter(|value| !value.is_empty());
        arguments.extend(values.map(|value| format!("{prefix}{value}")));
    }
    if Kconfig::read()?.is_set("ARCH_POSIX") {
        // native_sim is compiled with the headers of the build computer's C library, which clang finds by itself.
        arguments.push(format!("--target={}", variable("HOST")?));
        return Ok(arguments);
    }
    // clang's names for some targets differ from Rust's, but not the layout of types.
    let clang_target = match target.split('-').next() {
        Some(cpu) if cpu.starts_with("riscv32") => "riscv32-unknown-none-elf",
        Some(cpu) if cpu.starts_with("riscv64") => "riscv64-unknown-none-elf",
        _ => &target,
    };
    arguments.push(format!("--target={clang_target}"));
    // clang has no C library for a bare target. The types that are bound here do not depend on which one it is.
    arguments.push(format!("-I{}/lib/libc/minimal/include", variable("ZEPHYR_BASE")?));
    let resources = variable("LF_CLANG_RESOURCE_DIR")?;
    let arm_intrinsics = Path::new(&resources).join("include/arm_acle.h");
    if target.starts_with("thumb") && arm_intrinsics.exists() {
        // CMSIS includes <arm_acle.h>. gcc's folder may come first on the include path, and clang cannot read gcc's:
        // so clang's is read before, and gcc's is kept out by its include guard.
        arguments.extend(["-D_GCC_ARM_ACLE_H".to_owned(), "-include".to_owned()]);
        arguments.push(arm_intrinsics.display().to_string());
    }
    Ok(arguments)
}

/// The image's configuration.
struct Kconfig(String);

impl Kconfig {
    fn read() -> Outcome<Self> {
        let path = variable("DOTCONFIG")?;
        println!("cargo::rerun-if-changed={path}");
        Ok(Self(fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?))
    }

    fn value_of(&self, symbol: &str) -> Option<&str> {
        self.0.lines().find_map(|line| line.strip_prefix("CONFIG_")?.strip_prefix(symbol)?.strip_prefix('='))
    }

    /// Returns whether it is on, or a number other than 0.
    fn is_set(&self, symbol: &str) -> bool {
        self.value_of(symbol).is_some_and(|value| value != "0")
    }
}

fn write_kconfig(to: &Path) -> Outcome<()> {
    let kconfig = Kconfig::read()?;
    let mut source = String::new();
    for symbol in NUMBERS {
        // A symbol that is not set depends on one that is off, as the log level does on the log.
        let value = kconfig.value_of(symbol).unwrap_or("0");
        let value: u64 = value.parse().map_err(|error| format!("CONFIG_{symbol}: {error}"))?;
        writeln!(source, "/// `CONFIG_{symbol}`.\npub const {symbol}: usize = {value};")?;
    }
    fs::write(to, source)?;
    for symbol in SWITCHES {
        println!("cargo::rustc-check-cfg=cfg(CONFIG_{symbol})");
        if kconfig.is_set(symbol) {
            println!("cargo::rustc-cfg=CONFIG_{symbol}");
        }
    }
    Ok(())
}

/// Writes the devices for `device!`, in Rust and in a C file that the image is linked with.
fn write_devices(to: &Path) -> Outcome<()> {
    let c_file = variable("LF_DEVICES_FILE")?;
    // As with the bindings, the image cannot be linked without it.
    println!("cargo::rerun-if-changed={c_file}");
    let header = format!("{}/devicetree_generated.h", variable("BINARY_DIR_INCLUDE_GENERATED")?);
    println!("cargo::rerun-if-changed={header}");
    let header = fs::read_to_string(&header).map_err(|error| format!("{header}: {error}"))?;
    let tree = lf_devicetree::Devicetree::read(&header);
    let kconfig = Kconfig::read()?;
    fs::write(&c_file, tree.c_source(|option| kconfig.is_set(option)))?;
    fs::write(to, tree.rust_source(|option| kconfig.is_set(option)))?;
    Ok(())
}

fn write_header() -> Outcome<()> {
    let header = variable("LF_HEADER_FILE")?;
    println!("cargo::rerun-if-changed={header}");
    println!("cargo::rerun-if-changed=src/c_api.rs");
    println!("cargo::rerun-if-changed=build.rs");
    let mut config = cbindgen::Config::default();
    for symbol in ["CONFIG_LF_FEDERATE", "CONFIG_LF_RTI"] {
        config.defines.insert(symbol.to_owned(), symbol.to_owned());
    }
    config.defines.insert("feature = traces".to_owned(), "CONFIG_LF_TRACE".to_owned());
    cbindgen::Builder::new()
        .with_config(config)
        .with_src("src/c_api.rs")
        .with_language(cbindgen::Language::C)
        .with_style(cbindgen::Style::Tag)
        .with_cpp_compat(true)
        .with_include_guard("LF_LF_H_")
        .with_header(
            "/* SPDX-License-Identifier: Apache-2.0 */\n\
             /* The C API of a federate, as the crate lf-zephyr offers it. */",
        )
        .generate()?
        .write_to_file(header);
    Ok(())
}
