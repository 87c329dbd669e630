// SPDX-License-Identifier: Apache-2.0
//! Where the generated crates, the compiled programs and the runtime crates lie.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io;
use std::path::{Path, PathBuf, absolute};

use crate::args::{Places, Platform};

/// Every folder that a build uses, as absolute paths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Folders {
    /// The generated crates, which form a workspace.
    pub(crate) out: PathBuf,
    /// Cargo's intermediate results, shared by all programs.
    pub(crate) shared: PathBuf,
    /// The repository with the runtime crates.
    pub(crate) home: PathBuf,
}

impl Folders {
    /// The folders for a program; `name` is the program's name.
    ///
    /// # Errors
    /// When there is no current folder, or the runtime crates are not where they should be.
    pub(crate) fn new(file: &Path, name: &str, platform: Platform, places: &Places) -> io::Result<Self> {
        let home = home(places)?;
        let out = match &places.out {
            Some(out) => absolute(out)?,
            None => application(&absolute(file)?).join("build/lfz").join(name).join(platform_folder(platform)),
        };
        let shared = match (&places.target_dir, std::env::var_os("CARGO_TARGET_DIR")) {
            (Some(folder), _) => absolute(folder)?,
            (None, Some(folder)) => absolute(folder)?.join("lf"),
            (None, None) => home.join("target/lf"),
        };
        Ok(Self { out, shared, home })
    }

    /// The compiled programs of this program alone.
    pub(crate) fn target(&self) -> PathBuf {
        self.out.join("target")
    }

    /// The version of the generated packages, which says where they lie: cargo itself looks only at their names and
    /// at where they are within their workspace, and would take one program for another of the same name.
    pub(crate) fn version(&self) -> String {
        let mut hasher = DefaultHasher::new();
        self.out.hash(&mut hasher);
        format!("0.0.0+{:016x}", hasher.finish())
    }
}

/// The folder of the application: that around `src`, or that of the file when it is not in a `src` folder.
fn application(file: &Path) -> &Path {
    let folder = file.parent().unwrap_or(file);
    match (folder.file_name(), folder.parent()) {
        (Some(name), Some(application)) if name == "src" => application,
        _ => folder,
    }
}

fn platform_folder(platform: Platform) -> &'static str {
    match platform {
        Platform::Host => "host",
        Platform::Zephyr => "zephyr",
    }
}

/// The repository from which this program was built, unless told otherwise.
fn home(places: &Places) -> io::Result<PathBuf> {
    let home = match &places.home {
        Some(home) => absolute(home)?,
        None => Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("/")).to_path_buf(),
    };
    if home.join("rust/linux/Cargo.toml").is_file() {
        return Ok(home);
    }
    let place = home.display();
    Err(io::Error::other(format!(
        "the runtime crates are not in {place}; name the lf-zephyr-rs repository with --home or in LFZ_HOME"
    )))
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::{Folders, application};
    use crate::args::{Places, Platform};

    #[test]
    fn crates_are_generated_beside_the_source_folder() {
        let folders =
            Folders::new(Path::new("/a/b/src/P.lf"), "P", Platform::Host, &Places::default()).expect("home is there");
        assert_eq!(folders.out, Path::new("/a/b/build/lfz/P/host"));
        assert_eq!(application(Path::new("/a/b/P.lf")), Path::new("/a/b"));
    }

    #[test]
    fn a_given_folder_is_taken_as_it_is() {
        let places =
            Places { out: Some(PathBuf::from("/x")), target_dir: Some(PathBuf::from("/y")), ..Places::default() };
        let folders = Folders::new(Path::new("P.lf"), "P", Platform::Zephyr, &places).expect("home is there");
        assert_eq!((folders.out.as_path(), folders.shared.as_path()), (Path::new("/x"), Path::new("/y")));
    }

    #[test]
    fn a_missing_home_is_named() {
        let places = Places { home: Some(PathBuf::from("/nowhere")), ..Places::default() };
        let error = Folders::new(Path::new("P.lf"), "P", Platform::Host, &places).expect_err("it is not there");
        assert!(error.to_string().contains("/nowhere") && error.to_string().contains("LFZ_HOME"), "{error}");
    }
}
