// SPDX-License-Identifier: Apache-2.0
//! The folders of builds, in trees of folders and symbolic links that are made for each test.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use proptest::prelude::*;

use super::{Folders, application, resolved};
use crate::args::{Places, Platform};
use crate::compile::source::Files;

#[test]
fn crates_are_generated_beside_the_source_folder() {
    let folders =
        Folders::new(Path::new("/a/b/src/P.lf"), "P", Platform::Host, &Places::default()).expect("home is there");
    assert_eq!(folders.out, Path::new("/a/b/build/lfz/P/host"));
    assert_eq!(application(Path::new("/a/b/P.lf")).expect("nothing to resolve"), Path::new("/a/b"));
}

#[test]
fn a_missing_home_is_named() {
    let places = Places { home: Some(PathBuf::from("/nowhere")), ..Places::default() };
    let error = Folders::new(Path::new("P.lf"), "P", Platform::Host, &places).expect_err("it is not there");
    assert!(error.to_string().contains("/nowhere") && error.to_string().contains("LFZ_HOME"), "{error}");
}

#[test]
fn a_folder_that_cargo_cannot_work_in_is_refused_with_the_option_that_names_another() {
    for (places, option) in [
        (Places { out: Some(PathBuf::from("/a:b")), ..Places::default() }, "--out"),
        (Places { target_dir: Some(PathBuf::from("/a:b")), ..Places::default() }, "--target-dir"),
    ] {
        let error = Folders::new(Path::new("P.lf"), "P", Platform::Host, &places).expect_err(option);
        assert!(error.to_string().contains("/a:b") && error.to_string().ends_with(option), "{error}");
    }
}

/// A step from one folder to another, in the form of a path.
#[derive(Clone, Debug)]
enum Step {
    Into(usize),
    Out,
    Stay,
    /// Through a symbolic link to any folder.
    Link(usize),
}

const NAMES: [&str; 9] = ["src", "lib", "a b", "é", "a#b", "a%20", "-o", "a'\"b", "a\nb"];

/// The first of these, which can stand in a text of LF.
const NAMES_IN_TEXTS: usize = 7;

fn steps() -> impl Strategy<Value = Vec<Step>> {
    steps_through(NAMES.len())
}

fn steps_through(names: usize) -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        3 => (0..names).prop_map(Step::Into),
        2 => Just(Step::Out),
        1 => Just(Step::Stay),
        2 => (0..names).prop_map(Step::Link),
    ];
    proptest::collection::vec(step, 0..8)
}

/// Writes a path with these steps, in folders that are made for it; links lead to folders elsewhere in the tree.
fn written(root: &Path, steps: &[Step]) -> PathBuf {
    let real = |path: &Path| fs::canonicalize(path).expect("it is there");
    let mut path = root.join("begin");
    fs::create_dir_all(&path).expect("it can be made");
    for (number, step) in steps.iter().enumerate() {
        match step {
            Step::Into(name) => path.push(NAMES[*name]),
            Step::Stay => path.push("."),
            // The path must not leave the tree of the test.
            Step::Out if real(&path) == real(root) => path.push("."),
            Step::Out => path.push(".."),
            Step::Link(name) => {
                let target = root.join("elsewhere").join(number.to_string()).join(NAMES[*name]);
                fs::create_dir_all(&target).expect("it can be made");
                path.push(format!("link{number}"));
                let _ = symlink(target, &path);
            }
        }
        fs::create_dir_all(&path).expect("it can be made");
    }
    path
}

proptest! {
    /// However a user names a folder, files in it are where the system puts them, and one folder has one name.
    #[test]
    fn a_folder_has_one_name_whatever_the_user_calls_it(steps in steps(), rest in "[a-z]{1,3}(/[a-z]{1,3}){0,2}") {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let root = fs::canonicalize(folder.path()).expect("it is there");
        let path = written(&root, &steps);
        let real = fs::canonicalize(&path).expect("it is there");
        prop_assert_eq!(&resolved(&path).expect("it is there"), &real);
        // The name is the same before and after the folder is made, because the version of packages depends on it.
        let (new, around) = (path.join(&rest), path.join("none/..").join(&rest));
        prop_assert_eq!(resolved(&around).expect("it can be made"), real.join(&rest));
        let before = resolved(&new).expect("it can be made");
        fs::create_dir_all(&before).expect("it can be made");
        prop_assert_eq!(&before, &fs::canonicalize(&new).expect("it has been made"));
        prop_assert_eq!(&before, &resolved(&new).expect("it is there"));
    }

    /// The application is the folder around `src`, however the file in it is named.
    #[test]
    fn the_application_is_found_from_every_folder(steps in steps(), below in 0_usize..3) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let root = fs::canonicalize(folder.path()).expect("it is there");
        let path = written(&root, &steps);
        let source = path.join("app/src");
        let from = ["sub", "sub/sub"].iter().take(below).fold(source.clone(), |from, _| from.join("sub"));
        fs::create_dir_all(&from).expect("it can be made");
        let file = (0..below).fold(from, |from, _| from.join("..")).join("P.lf");
        let expected = fs::canonicalize(path.join("app")).expect("it is there");
        prop_assert_eq!(resolved(&application(&file).expect("it is there")).expect("it is there"), expected);
    }
}

/// Returns the names of a program's files, as the compiler sees them, and its messages.
fn compiled(main: &Path) -> (Vec<String>, String) {
    let diagnostics = lf_compiler::compile(main.to_str().expect("it is a text"), &Files).diagnostics;
    let files = diagnostics.sources().iter().map(|(_, file)| file.path().to_owned()).collect();
    (files, diagnostics.render(lf_compiler::Style::Plain))
}

proptest! {
    /// An import opens the file that the system finds at its path, and a file is one file by all its names: a reactor
    /// that is imported by two of them is no second one. Messages show the first of its names.
    #[test]
    fn imports_lead_where_the_system_says(
        steps in steps_through(NAMES_IN_TEXTS),
        further in steps_through(NAMES_IN_TEXTS),
    ) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let root = fs::canonicalize(folder.path()).expect("it is there");
        let library = written(&root.join("one"), &steps);
        let behind = written(&library, &further).join("Behind.lf");
        let inside = behind.strip_prefix(&library).expect("it begins there").display().to_string();
        let library = library.join("Library.lf");
        let relative = library.strip_prefix(&root).expect("it begins there").display().to_string();
        let real = fs::canonicalize(&behind).unwrap_or_else(|_| {
            fs::write(&behind, "target Rust\nreactor Behind {}\n").expect("it can be written");
            fs::canonicalize(&behind).expect("it is there")
        });
        let text = format!("target Rust\nimport Behind from \"{inside}\"\nreactor Library {{ b = new Behind() }}\n");
        fs::write(&library, text).expect("it can be written");
        let main = root.join("Main.lf");
        let text = format!(
            "target Rust\nimport Library from \"{relative}\"\nimport Behind from \"{}\"\nmain reactor {{ a = new \
             Library(); b = new Behind() }}\n",
            real.display()
        );
        fs::write(&main, text).expect("it can be written");
        let (files, said) = compiled(&main);
        prop_assert_eq!(&said, "");
        prop_assert_eq!(files.len(), 3);
        prop_assert_eq!(fs::canonicalize(&files[2]).expect("it is there"), real);
        // The name contains only the user's folders.
        let shown = files[2].strip_prefix(root.to_str().expect("it is a text")).expect("it begins there");
        let written = format!("/{relative}/../{inside}");
        let mut parts = written.split('/').filter(|part| *part != ".");
        prop_assert!(shown.split('/').all(|part| parts.any(|written| written == part)), "{} {}", shown, written);
    }
}
