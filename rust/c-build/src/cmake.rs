// SPDX-License-Identifier: Apache-2.0
//! The project of CMake of a program with files for CMake: it configures them, compiles the sources that they add, and
//! builds the libraries of which they are the project. The answers come from CMake's file API.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::{env, fs, process};

use serde_json::Value;

use crate::compiler;

/// The name of the program in CMake, and of its folder.
const TARGET: &str = "lf_program";

/// The folder of files that are compiled as the program's own, and tell how.
const OWN: &str = "lf-own";

/// The files for CMake, and the surroundings that they find.
pub(crate) struct Project<'p> {
    pub(crate) files: &'p [PathBuf],
    /// The folders in which their files are searched.
    pub(crate) places: &'p [PathBuf],
    pub(crate) includes: &'p [PathBuf],
    pub(crate) flags: &'p [String],
    /// Whether the program's own files are C++, too.
    pub(crate) is_cpp: bool,
    pub(crate) out: &'p Path,
}

/// The answers of CMake about them.
pub(crate) struct Configured {
    folder: PathBuf,
    /// The targets whose objects are parts of the program: itself, and libraries of objects.
    parts: Vec<String>,
    /// The compiler's arguments for the program's own files in C, and in C++.
    pub(crate) arguments: [Vec<String>; 2],
    /// The linker's arguments.
    pub(crate) linked: Vec<String>,
    /// Whether any of it is C++.
    pub(crate) is_cpp: bool,
}

impl Project<'_> {
    /// Configures the project, and makes cargo run the build script again when one of its files changes.
    ///
    /// The build script ends with status 1 if that fails.
    pub(crate) fn configure(&self) -> Configured {
        let source = self.out.join("cmake");
        let folder = source.join("build");
        let query = folder.join(".cmake/api/v1/query");
        fs::create_dir_all(&query).expect("cargo's folder can be written to");
        for kind in ["codemodel-v2", "cmakeFiles-v1"] {
            fs::write(query.join(kind), "").expect("cargo's folder can be written to");
        }
        fs::write(source.join("CMakeLists.txt"), self.text()).expect("cargo's folder can be written to");
        let mut command = Command::new("cmake");
        command.arg("-S").arg(&source).arg("-B").arg(&folder);
        command.arg(format!("-DCMAKE_BUILD_TYPE={}", compiler::build_type()));
        for (variable, is_cpp) in [("CMAKE_C_COMPILER", false), ("CMAKE_CXX_COMPILER", true)] {
            let compiler = cc::Build::new().cpp(is_cpp).cargo_metadata(false).cargo_warnings(false).try_get_compiler();
            if let Ok(compiler) = compiler {
                command.arg(format!("-D{variable}={}", compiler.path().display()));
            }
        }
        if !folder.join("CMakeCache.txt").is_file() && runs("ninja") {
            command.args(["-G", "Ninja"]);
        }
        let output = output(&mut command);
        let said = as_compilers_say(&String::from_utf8_lossy(&output.stderr));
        eprint!("{said}");
        if !output.status.success() {
            if !said.contains(": error: ") {
                eprintln!("error: CMake cannot configure {}", list(self.files));
            }
            process::exit(1);
        }
        let reply = Reply::read(&folder);
        for file in reply.files() {
            println!("cargo::rerun-if-changed={}", file.display());
        }
        let targets = reply.targets();
        let target = targets.iter().find(|target| target["name"] == TARGET).cloned().unwrap_or_default();
        let needed = |id: &Value| target["dependencies"].as_array().into_iter().flatten().any(|one| one["id"] == *id);
        let libraries = targets.iter().filter(|one| one["type"] == "OBJECT_LIBRARY" && needed(&one["id"]));
        let libraries = libraries.filter_map(|library| library["name"].as_str());
        Configured {
            parts: libraries.chain([TARGET]).map(str::to_owned).collect(),
            arguments: ["C", "CXX"].map(|language| compiler_arguments(&target, language)),
            linked: linked(&target, &folder),
            is_cpp: target["link"]["language"] == "CXX",
            folder,
        }
    }

    /// Returns the `CMakeLists.txt`.
    fn text(&self) -> String {
        let each = |command: &str, list: &[String]| -> String {
            let lines = list.iter().map(|one| format!("{command}(${{LF_MAIN_TARGET}} PRIVATE [=[{one}]=])\n"));
            lines.collect::<Vec<_>>().concat()
        };
        let paths = |list: &[PathBuf]| -> Vec<String> {
            list.iter().map(|path| absolute(path).display().to_string()).collect()
        };
        let (includes, places) = (paths(self.includes), paths(self.places));
        let variables: String = self.flags.iter().filter_map(|flag| variable(flag)).collect();
        let files = paths(self.files).into_iter().map(|file| format!("include([=[{file}]=])\n"));
        let files = files.collect::<Vec<_>>().concat();
        let own_cpp = if self.is_cpp {
            format!(
                "file(WRITE ${{CMAKE_BINARY_DIR}}/{OWN}/own.cpp \"int lf_own_cpp;\")\n\
                 target_sources(${{LF_MAIN_TARGET}} PRIVATE ${{CMAKE_BINARY_DIR}}/{OWN}/own.cpp)\n"
            )
        } else {
            String::new()
        };
        // The program itself is not linked here, but by rustc: with the symbols that its sources miss until then.
        format!(
            "cmake_minimum_required(VERSION 3.20)\n\
             project({TARGET} LANGUAGES C)\n\
             include(CheckLanguage)\ncheck_language(CXX)\n\
             if(CMAKE_CXX_COMPILER)\n  enable_language(CXX)\nendif()\n\
             set(CMAKE_C_STANDARD 11)\nset(CMAKE_CXX_STANDARD 17)\nset(CMAKE_POSITION_INDEPENDENT_CODE ON)\n\
             set(CMAKE_EXPORT_COMPILE_COMMANDS ON)\nset(LF_MAIN_TARGET {TARGET})\n{variables}\
             file(WRITE ${{CMAKE_BINARY_DIR}}/{OWN}/own.c \"int lf_own;\")\n\
             add_executable(${{LF_MAIN_TARGET}} ${{CMAKE_BINARY_DIR}}/{OWN}/own.c)\n\
             {own_cpp}\
             set_property(TARGET ${{LF_MAIN_TARGET}} PROPERTY RULE_LAUNCH_LINK \"${{CMAKE_COMMAND}} -E true\")\n\
             find_package(Threads REQUIRED)\n\
             set_property(TARGET ${{LF_MAIN_TARGET}} PROPERTY LINK_LIBRARIES Threads::Threads)\n\
             {}{}{files}\
             include([=[{}/cmake/lf_program_files.cmake]=])\n\
             lf_find_program_files({TARGET} [=[{}]=])\n",
            each("target_include_directories", &includes),
            each("target_compile_options", self.flags),
            env!("CARGO_MANIFEST_DIR"),
            places.join("]=] [=["),
        )
    }
}

impl Configured {
    /// Builds all that the program is linked with; returns the objects of its sources, and what was printed.
    pub(crate) fn build(&self) -> (Vec<PathBuf>, Output) {
        let mut command = Command::new("cmake");
        command.arg("--build").arg(&self.folder).args(["--target", TARGET, "--parallel"]);
        let mut output = output(&mut command);
        // Ninja prints what compilers say to the standard output.
        output.stderr = [&output.stdout[..], &output.stderr].concat();
        (self.objects(), output)
    }

    /// Returns the objects of the sources that the files for CMake add.
    fn objects(&self) -> Vec<PathBuf> {
        let text = fs::read(self.folder.join("compile_commands.json")).unwrap_or_default();
        let commands: Value = serde_json::from_slice(&text).unwrap_or_default();
        let parts: Vec<_> = self.parts.iter().map(|part| format!("CMakeFiles/{part}.dir/")).collect();
        let entries = commands.as_array().into_iter().flatten();
        let outputs = entries.filter_map(|entry| {
            let words = words(entry["command"].as_str()?);
            let output = words.iter().skip_while(|word| *word != "-o").nth(1)?;
            let is_added = parts.iter().any(|part| output.contains(part)) && !output.contains(&format!("/{OWN}/"));
            is_added.then(|| self.folder.join(output))
        });
        outputs.collect()
    }
}

/// CMake's answers.
struct Reply {
    folder: PathBuf,
    index: Value,
}

impl Reply {
    fn read(build: &Path) -> Self {
        let folder = build.join(".cmake/api/v1/reply");
        let names = fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path());
        // The newest one is the last in the alphabet.
        let index = names.filter(|path| path.file_name().is_some_and(|name| is_index(&name.to_string_lossy()))).max();
        let index = index.map(|path| json(&path)).unwrap_or_default();
        Self { folder, index }
    }

    fn object(&self, kind: &str) -> Value {
        let file = self.index["reply"][kind]["jsonFile"].as_str();
        file.map(|file| json(&self.folder.join(file))).unwrap_or_default()
    }

    /// Returns the files of the configuration that are the program's, and the sources of its targets.
    fn files(&self) -> Vec<PathBuf> {
        let inputs = self.object("cmakeFiles-v1");
        let base = PathBuf::from(inputs["paths"]["source"].as_str().unwrap_or_default());
        let is_own = |input: &&Value| ["isCMake", "isGenerated"].iter().all(|is| input[*is] != Value::Bool(true));
        let inputs = inputs["inputs"].as_array().into_iter().flatten().filter(is_own);
        let mut files: Vec<_> = inputs.filter_map(|input| Some(base.join(input["path"].as_str()?))).collect();
        for target in self.targets() {
            let sources = target["sources"].as_array().into_iter().flatten().filter(is_own);
            files.extend(sources.filter_map(|source| Some(base.join(source["path"].as_str()?))));
        }
        // What CMake writes is newer than the build script's last run.
        files.retain(|file| !file.starts_with(&base));
        files
    }

    fn targets(&self) -> Vec<Value> {
        let model = self.object("codemodel-v2");
        let targets = model["configurations"][0]["targets"].as_array().into_iter().flatten();
        targets.filter_map(|target| Some(json(&self.folder.join(target["jsonFile"].as_str()?)))).collect()
    }
}

fn is_index(name: &str) -> bool {
    name.starts_with("index-")
}

fn json(path: &Path) -> Value {
    fs::read(path).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default()
}

/// Returns the arguments with which CMake compiles the program's own files in a language.
fn compiler_arguments(target: &Value, language: &str) -> Vec<String> {
    let own = if language == "C" { "/own.c" } else { "/own.cpp" };
    let mut sources = target["sources"].as_array().into_iter().flatten();
    let source =
        sources.find(|source| source["path"].as_str().is_some_and(|path| path.ends_with(&format!("{OWN}{own}"))));
    let Some(group) = source.and_then(|source| source["compileGroupIndex"].as_u64()) else { return Vec::new() };
    let group = &target["compileGroups"][usize::try_from(group).unwrap_or(usize::MAX)];
    let list = |name: &str| group[name].as_array().into_iter().flatten();
    let mut arguments = Vec::new();
    for fragment in list("compileCommandFragments").filter_map(|one| one["fragment"].as_str()) {
        arguments.extend(words(fragment));
    }
    arguments.extend(list("defines").filter_map(|one| Some(format!("-D{}", one["define"].as_str()?))));
    for include in list("includes") {
        let option = if include["isSystem"] == Value::Bool(true) { "-isystem" } else { "-I" };
        let path = include["path"].as_str().map(str::to_owned);
        arguments.extend(path.into_iter().flat_map(|path| [option.to_owned(), path]));
    }
    arguments
}

/// Returns the linker's arguments for the libraries of a target.
fn linked(target: &Value, folder: &Path) -> Vec<String> {
    let fragments = target["link"]["commandFragments"].as_array().into_iter().flatten();
    let libraries = fragments.filter(|fragment| fragment["role"] != "flags");
    let words = libraries.filter_map(|fragment| fragment["fragment"].as_str()).flat_map(words);
    let absolute = |word: String| {
        // The project's own libraries are named from the folder in which they are built.
        let is_relative = !word.starts_with(['-', '/']) && word.contains('.');
        if is_relative { folder.join(word).display().to_string() } else { word }
    };
    words.map(absolute).collect()
}

/// Returns CMake's messages as compilers write theirs: `FILE:LINE:1: error: …`, in one line.
fn as_compilers_say(text: &str) -> String {
    let mut said = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let place =
            [("CMake Error at ", "error"), ("CMake Warning at ", "warning")].into_iter().find_map(|(begin, level)| {
                let (file, rest) = line.strip_prefix(begin)?.rsplit_once(" (")?.0.rsplit_once(':')?;
                Some((level, format!("{file}:{rest}:1")))
            });
        let Some((level, place)) = place else {
            said = said + line + "\n";
            continue;
        };
        let mut message = Vec::new();
        while let Some(line) = lines.next_if(|line| line.is_empty() || line.starts_with(' ')) {
            message.extend(line.split_whitespace());
        }
        if lines.next_if(|line| line.starts_with("Call Stack")).is_some() {
            while lines.next_if(|line| line.is_empty() || line.starts_with(' ')).is_some() {}
        }
        said = format!("{said}{place}: {level}: CMake: {}\n", message.join(" "));
    }
    said
}

/// Returns the words of a part of a command line.
fn words(fragment: &str) -> Vec<String> {
    shlex::split(fragment).unwrap_or_else(|| vec![fragment.to_owned()])
}

/// Returns the variable that a program finds for one of its macros, as with LF's compiler.
fn variable(flag: &str) -> Option<String> {
    let definition = flag.strip_prefix("-D")?;
    let (name, value) = definition.split_once('=').unwrap_or((definition, "TRUE"));
    Some(format!("set({name} [=[{}]=] CACHE STRING \"\")\n", value.trim_matches('"')))
}

fn absolute(path: &Path) -> PathBuf {
    env::current_dir().map_or_else(|_| path.to_owned(), |current| current.join(path))
}

fn list(files: &[PathBuf]) -> String {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ")
}

fn runs(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn output(command: &mut Command) -> Output {
    command.output().unwrap_or_else(|error| {
        eprintln!("error: CMake, which a `cmake-include` needs, cannot be run: {error}");
        process::exit(1);
    })
}

#[cfg(test)]
mod tests {
    use super::as_compilers_say;

    #[test]
    fn messages_of_cmake_are_lines_at_their_places() {
        let text = "CMake Error at /a b/p.cmake:13 (target):\n  The keyword\n  is used.\n\n  Here:\n\n   \
                    * x (y)\n\nCall Stack (most recent call first):\n  CMakeLists.txt:35 (include)\n\n\nrest\n";
        let expected = "/a b/p.cmake:13:1: error: CMake: The keyword is used. Here: * x (y)\nrest\n";
        assert_eq!(as_compilers_say(text), expected);
    }
}
