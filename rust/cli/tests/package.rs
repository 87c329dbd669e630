// SPDX-License-Identifier: Apache-2.0
//! Packages of reactors: repositories of git that a project has at certain commits.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{folder, said, text, write};

fn git(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new("git");
    command.current_dir(folder).args(["-c", "user.name=a", "-c", "user.email=a@b", "-c", "init.defaultBranch=main"]);
    let output = said(command.args(arguments));
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout).trim().to_owned()
}

fn lfz(folder: &Path, arguments: &[&str]) -> Output {
    said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder).args(arguments))
}

#[test]
fn a_project_has_packages_at_their_commits() {
    let folder = folder(&[
        ("a b/filters/src/lib/Filter.lf", "target C\nreactor Filter { input in: int }\n"),
        ("a b/none/README.md", ""),
        ("project/src/Main.lf", "target C\nimport Filter from <filters>\nmain reactor { f = new Filter() }\n"),
    ]);
    let (project, filters) = (folder.path().join("project"), folder.path().join("a b/filters"));
    for package in [&filters, &folder.path().join("a b/none")] {
        git(package, &["init", "--quiet"]);
        git(package, &["add", "."]);
        git(package, &["commit", "--quiet", "-m", "first"]);
    }
    let first = git(&filters, &["rev-parse", "HEAD"]);
    let check = || lfz(&project, &["check", "src/Main.lf"]).status.code();
    assert_eq!(check(), Some(1));

    let added = lfz(&project, &["package", "add", "../a b/filters"]);
    assert_eq!(text(&added.stdout), format!("filters {first}\n"), "{}", text(&added.stderr));
    assert_eq!(check(), Some(0));

    // The package changes, but the project's does not.
    write(&filters, "src/lib/Filter.lf", "target C\nreactor Other { }\n");
    git(&filters, &["commit", "--quiet", "-am", "second"]);
    fs::remove_dir_all(project.join("lf-packages")).expect("it is there");
    assert_eq!(
        text(&lfz(&project, &["package", "list"]).stdout),
        format!("filters {first} ../a b/filters (not fetched)\n")
    );
    assert_eq!(lfz(&project, &["package", "fetch"]).status.code(), Some(0));
    assert_eq!(check(), Some(0));

    // A change in it is not lost.
    git(&project.join("lf-packages/filters"), &["checkout", "--quiet", "main"]);
    write(&project, "lf-packages/filters/src/lib/Filter.lf", "changed");
    let error = text(&lfz(&project, &["package", "fetch"]).stderr);
    assert_eq!(error, "error: lf-packages/filters has changes, so it stays as it is: commit them, or undo them\n");

    for (arguments, expected) in [
        (&["package", "add", "../a b/filters"][..], "error: there is a package filters already"),
        (&["package", "add", "../a b/none"], "error: ../a b/none is no package of LF: it has no folder src/lib"),
        (&["package", "add", "../nowhere"], "error: fatal: repository '../nowhere' does not exist"),
        (&["package", "add", "../a b/filters", "--name", "../x"], "error: `../x` is no name of a package"),
        (
            &["package", "add", "../a b/filters", "--name", "f", "--revision", "v7"],
            "error: fatal: invalid reference: v7",
        ),
    ] {
        let error = text(&lfz(&project, arguments).stderr);
        assert!(error.starts_with(expected), "{error}");
    }
    assert_eq!(fs::read_dir(project.join("lf-packages")).expect("it is there").count(), 1);
}
