// SPDX-License-Identifier: Apache-2.0
//! Compiles the C part of a generated program, in that program's build script: bodies, whose types it measures, or C
//! files beside bodies in Rust, for which it can bind headers.
//!
//! ```no_run
//! lf_c_build::program().define("LOG_LEVEL", "3").source("../src/helpers.c").build();
//! lf_c_build::beside().include("../src").source("../src/fan.c").header("../src/fan.h").build();
//! lf_c_build::program().cmake_file("../src/sensors.cmake").cmake_place("../src").build();
//! ```
//!
//! The C files of the program are those of the folder `c` beside its manifest, those that end with `.cpp` in C++;
//! `c/sizes.c`, or `.cpp`, has one array `char lf_size_N[sizeof(T)]` for each size that the tables need, and is not
//! linked. In a build for Zephyr, which compiles C itself, `LF_C_SIZES` names its object, and nothing is compiled here.
#![forbid(unsafe_code)]

#[cfg(feature = "cmake")]
mod cmake;
mod compiler;
#[cfg(feature = "headers")]
mod floats;
#[cfg(feature = "headers")]
mod headers;
mod protobuf;
mod sizes;

use std::path::{Path, PathBuf};
use std::{env, fs};

use compiler::Compiler;

/// The description of a program in C.
#[must_use = "nothing is compiled before `build`"]
#[derive(Debug, Default)]
pub struct Program {
    /// Whether its bodies are C, which call the runtime for C.
    of_bodies: bool,
    folder: PathBuf,
    includes: Vec<PathBuf>,
    flags: Vec<String>,
    sources: Vec<PathBuf>,
    headers: Vec<PathBuf>,
    place: String,
    link_arguments: Vec<String>,
    first_libraries: Vec<String>,
    libraries: Vec<String>,
    protobufs: Vec<PathBuf>,
    cmake_files: Vec<PathBuf>,
    cmake_places: Vec<PathBuf>,
}

/// The additions of the program's files for CMake.
#[derive(Default)]
struct OfCmake {
    objects: Vec<PathBuf>,
    linked: Vec<String>,
    is_cpp: bool,
}

/// Returns the program in the folder `c`.
pub fn program() -> Program {
    Program { of_bodies: true, folder: "c".into(), ..Program::default() }
}

/// Returns the C files beside a program in Rust.
pub fn beside() -> Program {
    Program::default()
}

impl Program {
    /// Sets the folder with the program's own files, instead of `c`.
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = folder.into();
        self
    }

    /// Adds a folder with headers; relative paths are those from the manifest.
    pub fn include(mut self, folder: impl Into<PathBuf>) -> Self {
        self.includes.push(folder.into());
        self
    }

    /// Adds a macro; the value may be empty.
    pub fn define(mut self, name: &str, value: &str) -> Self {
        self.flags.push(if value.is_empty() { format!("-D{name}") } else { format!("-D{name}={value}") });
        self
    }

    /// Adds an argument of the compiler.
    pub fn flag(mut self, flag: impl Into<String>) -> Self {
        self.flags.push(flag.into());
        self
    }

    /// Adds a C or C++ file to the program.
    pub fn source(mut self, file: impl Into<PathBuf>) -> Self {
        self.sources.push(file.into());
        self
    }

    /// Adds a file with messages of Protocol Buffers, whose types bodies find in `NAME.pb-c.h`.
    pub fn protobuf(mut self, file: impl Into<PathBuf>) -> Self {
        self.protobufs.push(file.into());
        self
    }

    /// Adds a header to bind: the bindings are the file `c.rs` in `OUT_DIR`. It takes the feature `headers`.
    pub fn header(mut self, file: impl Into<PathBuf>) -> Self {
        self.headers.push(file.into());
        self
    }

    /// Sets where the program names headers, `P.lf:3:16`, for errors about their bindings.
    pub fn named_at(mut self, place: &str) -> Self {
        place.clone_into(&mut self.place);
        self
    }

    /// Adds an argument of the linker, in the compiler's form: `-L/opt/lib`, an archive's path.
    pub fn link_argument(mut self, argument: impl Into<String>) -> Self {
        self.link_arguments.push(argument.into());
        self
    }

    /// Adds a library that is linked before all others, because it replaces functions of theirs.
    pub fn first_library(mut self, name: impl Into<String>) -> Self {
        self.first_libraries.push(name.into());
        self
    }

    /// Adds a library, by its name, by its path, or as an argument of the linker: `m` is always linked.
    pub fn library(mut self, name: impl Into<String>) -> Self {
        self.libraries.push(name.into());
        self
    }

    /// Adds a file for CMake, in which `${LF_MAIN_TARGET}` is the program. It takes the feature `cmake`.
    pub fn cmake_file(mut self, file: impl Into<PathBuf>) -> Self {
        self.cmake_files.push(file.into());
        self
    }

    /// Adds a folder that has files which those for CMake name by relative paths.
    pub fn cmake_place(mut self, folder: impl Into<PathBuf>) -> Self {
        self.cmake_places.push(folder.into());
        self
    }

    /// Compiles the program, tells cargo to link it, and writes its Rust part into `OUT_DIR`: of bodies `sizes.rs`,
    /// with a constant `LF_SIZE_N` per size, and of headers `c.rs`.
    ///
    /// The compiler's output goes to standard error; if it has found errors, the build script ends with status 1.
    ///
    /// # Panics
    /// Outside of a build script, and where files cannot be read or written.
    pub fn build(self) {
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo says where build scripts write"));
        let wrapper = self.bind(&out);
        if self.of_bodies {
            self.build_bodies(&out);
        } else if !is_image() {
            let mut compiler = Compiler::new(self.includes.clone(), self.flags.clone(), &out);
            let added = self.build_cmake(&mut compiler, &self.includes, &out);
            let files: Vec<_> = self.sources.iter().cloned().chain(wrapper).collect();
            let objects = compiler.compile(&files);
            compiler.finish();
            self.link(&files, &objects, &added);
        }
    }

    /// Binds the headers; returns a C file that the bindings need.
    #[cfg(feature = "headers")]
    fn bind(&self, out: &Path) -> Option<PathBuf> {
        (!self.headers.is_empty()).then(|| headers::bind(&self.headers, &self.includes, &self.flags, &self.place, out))
    }

    #[cfg(not(feature = "headers"))]
    fn bind(&self, _out: &Path) -> Option<PathBuf> {
        assert!(self.headers.is_empty(), "headers are bound by the feature `headers`");
        None
    }

    fn build_bodies(mut self, out: &Path) {
        let code = &self.folder;
        if is_image() {
            let object = env::var_os("LF_C_SIZES").unwrap_or_default();
            println!("cargo::rerun-if-changed={}", Path::new(&object).display());
            write_sizes(out, (!object.is_empty()).then_some(Path::new(&object)));
            return;
        }
        let messages = out.join("protobuf");
        let generated = protobuf::generate(&self.protobufs, &messages);
        if !generated.is_empty() {
            self.includes.push(messages);
            self.sources.extend(generated);
            self.libraries.push(protobuf::LIBRARY.to_owned());
        }
        // The crate lf-c lies beside this one.
        let runtime = Path::new(env!("CARGO_MANIFEST_DIR")).join("../c");
        let includes: Vec<_> =
            [runtime.join("include"), runtime.clone(), code.clone()].iter().chain(&self.includes).cloned().collect();
        let mut flags = self.flags.clone();
        // `lfz` puts the programs of all federates into the folder `bin` there.
        if let Some(around) = env::current_dir().ok().as_deref().and_then(Path::parent) {
            flags.push(format!("-DLF_FED_PACKAGE_DIRECTORY={:?}", around.display().to_string()));
        }
        let mut compiler = Compiler::new(includes.clone(), flags, out);
        let added = self.build_cmake(&mut compiler, &includes, out);

        let (types, own): (Vec<_>, Vec<_>) =
            files_in(code).into_iter().partition(|file| file.file_stem().is_some_and(|stem| stem == "sizes"));
        let support = files_in(&runtime.join("src")).into_iter().filter(|file| !file.ends_with("zephyr.c"));
        let files: Vec<_> = own.into_iter().chain(self.sources.iter().cloned()).chain(support).collect();
        let objects = compiler.compile(&files);
        // The sizes of symbols have to be in the object.
        let types = compiler.with_flag("-fno-lto").compile(&types);
        compiler.finish();

        write_sizes(out, types.first().map(PathBuf::as_path));
        println!("cargo::rerun-if-changed={}", code.display());
        println!("cargo::rerun-if-changed={}", runtime.display());
        self.link(&files, &objects, &added);
    }

    /// Builds what the files for CMake add, and has the compiler compile the program's own files as they say.
    #[cfg(feature = "cmake")]
    fn build_cmake(&self, compiler: &mut Compiler, includes: &[PathBuf], out: &Path) -> OfCmake {
        if self.cmake_files.is_empty() {
            return OfCmake::default();
        }
        let (files, places, flags) = (&self.cmake_files, &self.cmake_places, &self.flags);
        let is_cpp = self.of_bodies && files_in(&self.folder).iter().any(|file| compiler::is_cpp(file));
        let configured = cmake::Project { files, places, includes, flags, is_cpp, out }.configure();
        let (objects, said) = configured.build();
        compiler.report(&said);
        compiler.finish();
        compiler.compile_as(configured.arguments);
        OfCmake { objects, linked: configured.linked, is_cpp: configured.is_cpp }
    }

    #[cfg(not(feature = "cmake"))]
    fn build_cmake(&self, _compiler: &mut Compiler, _includes: &[PathBuf], _out: &Path) -> OfCmake {
        assert!(self.cmake_files.is_empty(), "files for CMake are read by the feature `cmake`");
        OfCmake::default()
    }

    /// Makes cargo link the objects of files, and the program's libraries.
    fn link(&self, files: &[PathBuf], objects: &[PathBuf], of_cmake: &OfCmake) {
        for library in &self.first_libraries {
            println!("cargo::rustc-link-lib=dylib={library}");
        }
        // As objects they take part in the program wherever they stand among its libraries: Rust calls C, C calls Rust.
        for object in objects.iter().chain(&of_cmake.objects) {
            println!("cargo::rustc-link-arg={}", object.display());
        }
        for argument in &self.link_arguments {
            println!("cargo::rustc-link-arg={argument}");
            // An archive that has changed is linked anew.
            if Path::new(argument).is_file() {
                println!("cargo::rerun-if-changed={argument}");
            }
        }
        for argument in &of_cmake.linked {
            println!("cargo::rustc-link-arg={argument}");
        }
        let of_cpp = of_cmake.is_cpp || files.iter().any(|file| compiler::is_cpp(file));
        let of_cpp = of_cpp.then_some("stdc++");
        for library in self.libraries.iter().map(String::as_str).chain(of_cpp).chain(["m"]) {
            let is_argument = library.starts_with('-') || library.contains('/');
            println!("cargo::rustc-link-arg={}{library}", if is_argument { "" } else { "-l" });
        }
    }
}

/// Returns whether this is a build for Zephyr, which compiles C itself.
fn is_image() -> bool {
    println!("cargo::rerun-if-env-changed=LF_C_SIZES");
    env::var_os("LF_C_SIZES").is_some()
}

/// Returns the C and C++ files of a folder, in order.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.map(|entry| entry.expect("the folder can be read").path());
    let mut files: Vec<_> = paths.filter(|path| compiler::is_source(path)).collect();
    files.sort();
    files
}

fn write_sizes(out: &Path, object: Option<&Path>) {
    let sizes = object.map(sizes::read).unwrap_or_default();
    let lines: Vec<_> = sizes.iter().map(|(name, size)| format!("pub const {name}: usize = {size};\n")).collect();
    fs::write(out.join("sizes.rs"), lines.concat()).expect("cargo's folder can be written to");
}
