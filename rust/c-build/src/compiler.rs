// SPDX-License-Identifier: Apache-2.0
//! The compilers of this computer for C and C++, several files at a time.
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, process, thread};

/// The compiler, and its output so far.
pub(crate) struct Compiler {
    includes: Vec<PathBuf>,
    flags: Vec<String>,
    /// The arguments that CMake has for files of C and of C++, which take the place of these folders and flags.
    of_cmake: Option<[Vec<String>; 2]>,
    /// The flags about mistakes for compilers of C, and of C++.
    mistakes: [Vec<&'static str>; 2],
    out: PathBuf,
    /// The number of compiled files, which makes the names of their objects differ.
    count: usize,
    has_failed: bool,
}

/// Returns whether a file is compiled.
pub(crate) fn is_source(file: &Path) -> bool {
    is_cpp(file) || file.extension() == Some(OsStr::new("c"))
}

/// Returns whether it is compiled as C++.
pub(crate) fn is_cpp(file: &Path) -> bool {
    file.extension().is_some_and(|extension| ["cc", "cpp", "cxx"].map(OsStr::new).contains(&extension))
}

/// Returns CMake's name of cargo's profile.
pub(crate) fn build_type() -> &'static str {
    match env::var("OPT_LEVEL").expect("cargo tells build scripts the profile").as_str() {
        "0" => "Debug",
        "s" | "z" => "MinSizeRel",
        _ => "Release",
    }
}

impl Compiler {
    pub(crate) fn new(includes: Vec<PathBuf>, flags: Vec<String>, out: &Path) -> Self {
        let mistakes = [false, true].map(|is_cpp| about_mistakes(is_cpp, &out.join("c")));
        Self { includes, flags, of_cmake: None, mistakes, out: out.join("c"), count: 0, has_failed: false }
    }

    /// Adds an argument.
    pub(crate) fn with_flag(&mut self, flag: &str) -> &mut Self {
        self.flags.push(flag.to_owned());
        for arguments in self.of_cmake.iter_mut().flatten() {
            arguments.push(flag.to_owned());
        }
        self
    }

    /// Sets the arguments for files of C and of C++ that CMake has found, instead of folders and flags.
    #[cfg(feature = "cmake")]
    pub(crate) fn compile_as(&mut self, arguments: [Vec<String>; 2]) {
        self.of_cmake = Some(arguments);
    }

    /// Compiles files to objects. Prints the compiler's output, in the order of the files.
    pub(crate) fn compile(&mut self, files: &[PathBuf]) -> Vec<PathBuf> {
        fs::create_dir_all(&self.out).expect("cargo's folder can be written to");
        let jobs: Vec<_> = files.iter().map(|file| self.job(file)).collect();
        let (next, said) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        thread::scope(|scope| {
            for _ in 0..thread::available_parallelism().map_or(1, usize::from).min(jobs.len()) {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some((command, _)) = jobs.get(index) else { break };
                        said.lock().expect("no thread panics with it").push((index, run(command)));
                    }
                });
            }
        });
        let mut said = said.into_inner().expect("no thread has panicked with it");
        said.sort_by_key(|(index, _)| *index);
        for (_, output) in said {
            self.report(&output);
        }
        for (_, object) in &jobs {
            watch_headers(&object.with_extension("d"));
        }
        jobs.into_iter().map(|(_, object)| object).collect()
    }

    /// Ends the build script if there were errors.
    pub(crate) fn finish(&self) {
        if self.has_failed {
            process::exit(1);
        }
    }

    /// Returns the command that compiles a file, and its object.
    fn job(&mut self, file: &Path) -> (Vec<std::ffi::OsString>, PathBuf) {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let object = self.out.join(format!("{}-{stem}.o", self.count));
        self.count += 1;
        println!("cargo::rerun-if-changed={}", file.display());
        let mut build = cc::Build::new();
        build.cpp(is_cpp(file)).cargo_metadata(false).cargo_warnings(false).warnings(false);
        // The code of a program, as CMake compiles it: nothing in it can be replaced, and debuggers need no frame
        // pointers. The library would compile it for a shared object.
        let tool = build.pic(false).force_frame_pointer(false).get_compiler();
        let mut command: Vec<_> = vec![tool.path().into()];
        // Only the compiler's default warnings: bodies need not use all of their parameters. The library would suppress
        // all warnings.
        command.extend(tool.args().iter().filter(|argument| *argument != "-w").cloned());
        let given = [&self.mistakes[usize::from(is_cpp(file))]];
        command.extend(given.into_iter().flatten().map(Into::into));
        command.extend(["-fPIE", "-D_GNU_SOURCE", "-fdiagnostics-color=never", "-MMD"].map(Into::into));
        if is_cpp(file) {
            // LF's `string` is a `char *`, and ports have values of types of which the standard does not promise that
            // `offsetof` works.
            command.extend(["-Wno-write-strings", "-Wno-invalid-offsetof"].map(Into::into));
        }
        if let Some(arguments) = &self.of_cmake {
            command.extend(arguments[usize::from(is_cpp(file))].iter().map(Into::into));
        } else {
            for folder in &self.includes {
                command.extend(["-I".into(), folder.into()]);
            }
            if build_type() != "Debug" {
                // CMake sets it, too.
                command.push("-DNDEBUG".into());
            }
            command.extend(self.flags.iter().map(Into::into));
        }
        command.extend(["-c".into(), file.into(), "-o".into(), object.clone().into()]);
        (command, object)
    }

    /// Prints the compiler's output: errors unchanged, warnings also as cargo's, which shows them.
    pub(crate) fn report(&mut self, output: &Output) {
        let said = String::from_utf8_lossy(&output.stderr);
        eprint!("{said}");
        if !output.status.success() {
            self.has_failed = true;
            return;
        }
        for line in said.lines().filter(|line| [": warning: ", ": note: "].iter().any(|level| line.contains(level))) {
            println!("cargo::warning={line}");
        }
    }
}

/// Returns the flags by which every compiler refuses what newer ones refuse, and reports a mistake in an argument of a
/// macro where the macro is used. `zephyr/cmake/lf_federate.cmake` has the same for images.
fn about_mistakes(is_cpp: bool, out: &Path) -> Vec<&'static str> {
    const REFUSED: [&str; 5] = [
        "-Werror=implicit-function-declaration",
        "-Werror=implicit-int",
        "-Werror=incompatible-pointer-types",
        "-Werror=int-conversion",
        "-Werror=return-mismatch",
    ];
    let refused: &[&str] = if is_cpp { &[] } else { &REFUSED };
    let mut build = cc::Build::new();
    build.cpp(is_cpp).cargo_metadata(false).cargo_warnings(false).warnings(false).out_dir(out);
    // A compiler that cannot be run is named when there is something to compile.
    let is_known = |flag: &&str| build.is_flag_supported(flag).unwrap_or(false);
    ["-ftrack-macro-expansion=0"].iter().chain(refused).copied().filter(is_known).collect()
}

/// Makes cargo run the build script again when an included header changes, unless it is one of the system's. The
/// compiler lists them in make's format.
fn watch_headers(list: &Path) {
    let text = fs::read_to_string(list).unwrap_or_default();
    // A backslash precedes spaces in names.
    let names = text.replace("\\\n", " ").replace("\\ ", "\0");
    for name in names.split_ascii_whitespace().skip(2) {
        println!("cargo::rerun-if-changed={}", name.replace('\0', " "));
    }
}

fn run(command: &[std::ffi::OsString]) -> Output {
    let [program, arguments @ ..] = command else { unreachable!("a command begins with its program") };
    let output = Command::new(program).args(arguments).output();
    output.unwrap_or_else(|error| {
        let is_cpp = arguments.iter().any(|argument| is_cpp(Path::new(argument)));
        let (language, variable) = if is_cpp { ("C++", "CXX") } else { ("C", "CC") };
        let named = if env::var_os(variable).is_some() { format!(" (which {variable} names)") } else { String::new() };
        eprintln!("error: the {language} compiler {}{named} cannot be run: {error}", program.display());
        process::exit(1);
    })
}
