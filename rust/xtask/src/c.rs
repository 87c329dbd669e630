// SPDX-License-Identifier: Apache-2.0
//! The checks of the sources in C.

use std::path::Path;
use std::process::Command;

use crate::process;
use crate::report::Report;
use crate::tidy::tree::Tree;

/// Checks the formatting, and looks for mistakes that the compilers do not report.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    let tree = match Tree::read(repository) {
        Ok(tree) => tree,
        Err(error) => {
            report.fail("c", &format!("cannot read the tree: {error}"));
            return;
        }
    };
    let of =
        |kinds: &'static [&str]| tree.files.iter().filter(|file| kinds.contains(&file.kind())).map(|file| &file.path);
    let check = |report: &mut Report, program: &str, package: &str, arguments: &mut dyn FnMut(&mut Command)| {
        if process::find_program(program).is_none() {
            report.skip(program, &format!("not installed: {package}"));
            return;
        }
        let mut command = Command::new(program);
        arguments(command.current_dir(repository));
        let passed = process::succeeds(&mut command);
        report.check(program, passed);
    };
    check(report, "clang-format", "pip install clang-format==18.1.8", &mut |command| {
        command.args(["--dry-run", "--Werror"]).args(of(&["c", "h", "cpp"]));
    });
    check(report, "cppcheck", "the package of your distribution", &mut |command| {
        // Zephyr's headers and macros are not looked into.
        let options = ["--quiet", "--std=c11", "--enable=warning,portability", "--error-exitcode=1"];
        let suppressions = ["--suppress=missingInclude", "--suppress=unknownMacro"];
        command.args(options).args(suppressions).args(["-I", "rust/c/include", "-I", "zephyr/include"]);
        command.args(of(&["c"]));
    });
}
