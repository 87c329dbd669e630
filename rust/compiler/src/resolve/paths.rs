// SPDX-License-Identifier: Apache-2.0
//! Paths of the files of a program, which begin in the folder of the file that names them.
//!
//! They keep the user's spelling, and are resolved as the system does: `..` behind a link is not removed from a path as
//! text.

use std::path::PathBuf;

use super::sources::SourceProvider;

/// The folders of packages, relative to the project's folder.
pub(super) const PACKAGE_FOLDERS: [&str; 2] = ["build/lfc_include", "lf-packages"];

/// Returns the possible paths of a package's file: in the project, which is the folder that contains the importing
/// file's `src`, first by the name that the user gives it, then by that without links; and in the user's shared ones.
pub(super) fn in_package(sources: &dyn SourceProvider, importing: &str, file: &str) -> Vec<String> {
    let (package, file) = file.split_once('/').unwrap_or((file, ""));
    let real = sources.real_path(importing).and_then(|path| path.to_str().map(str::to_owned));
    let names = [Some(importing.to_owned()), real].into_iter().flatten();
    let in_project = |importing: String| {
        let to_src = match importing.rfind("src/").filter(|at| *at == 0 || importing[..*at].ends_with('/')) {
            Some(at) => importing[at..].matches('/').count(),
            None => 1,
        };
        let up = "../".repeat(to_src);
        let path = |folder| join(sources, &importing, &format!("{up}{folder}/{package}/src/lib/{file}"));
        PACKAGE_FOLDERS.map(path)
    };
    let shared = sources.package_folders().into_iter();
    let shared = shared.map(|folder| normalize(sources, &format!("{folder}/{package}/src/lib/{file}")));
    names.flat_map(in_project).chain(shared).collect()
}

/// Returns the path of an import: relative to the folder of the importing file.
pub(super) fn join(sources: &dyn SourceProvider, importing: &str, relative: &str) -> String {
    if relative.starts_with('/') {
        return normalize(sources, relative);
    }
    let folder = importing.rsplit_once('/').map(|(folder, _)| folder);
    match folder {
        Some(folder) => normalize(sources, &format!("{folder}/{relative}")),
        None => normalize(sources, relative),
    }
}

/// Returns the path of a file that is not LF, from the file that names it. Cargo and CMake remove every `..` from a
/// path as text, so none is left in it behind another part; the file has the name that the user gives it.
pub(super) fn beside(sources: &dyn SourceProvider, naming: &str, relative: &str) -> String {
    let path = join(sources, naming, relative);
    let is_plain = path.split('/').skip_while(|part| *part == "..").all(|part| part != "..");
    if is_plain {
        return path;
    }
    let real = |path: &str| sources.real_path(path).and_then(|real| real.to_str().map(str::to_owned));
    let found = match path.rsplit_once('/') {
        Some((folder, name)) if name != ".." => real(folder).map(|folder| format!("{folder}/{name}")),
        _ => real(&path),
    };
    found.unwrap_or(path)
}

/// Returns the identity of a file, which does not depend on its name.
pub(super) fn identity(sources: &dyn SourceProvider, path: &str) -> PathBuf {
    sources.real_path(path).unwrap_or_else(|| PathBuf::from(path))
}

/// Removes `.` from a path, and `..` if it leads back to the previous folder.
pub(super) fn normalize(sources: &dyn SourceProvider, path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for (index, part) in path.split('/').enumerate() {
        match part {
            "." => {}
            "" if index > 0 => {}
            ".." if leads_back(sources, &parts) => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    match &parts[..] {
        [] if !path.is_empty() => ".".to_owned(),
        [""] => "/".to_owned(),
        parts => parts.join("/"),
    }
}

/// Returns whether `..` behind these parts is the folder that contains their last one.
fn leads_back(sources: &dyn SourceProvider, parts: &[&str]) -> bool {
    let Some((last, before)) = parts.split_last().filter(|(last, _)| !matches!(**last, ".." | "")) else {
        return false;
    };
    let around = match before {
        [] => ".".to_owned(),
        [""] => "/".to_owned(),
        before => before.join("/"),
    };
    let behind = sources.real_path(&format!("{around}/{last}/.."));
    behind.is_none_or(|behind| Some(behind) == sources.real_path(&around))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::PathBuf;

    use super::{SourceProvider, beside, in_package, join, normalize};

    fn none() -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    /// A system in which `link` leads to `/deep/library`.
    struct Linked;

    impl SourceProvider for Linked {
        fn read(&self, _: &str) -> Result<String, String> {
            Ok(String::new())
        }

        fn real_path(&self, path: &str) -> Option<PathBuf> {
            let mut parts = vec!["here"];
            for part in path.split('/') {
                match part {
                    "link" => parts = vec!["deep", "library"],
                    ".." => _ = parts.pop(),
                    "" | "." => {}
                    part => parts.push(part),
                }
            }
            Some(PathBuf::from(format!("/{}", parts.join("/"))))
        }
    }

    #[test]
    fn parts_behind_a_link_lead_where_the_system_says() {
        let imports = ["link/../B.lf", "link/a/../B.lf", "a/../link/B.lf", "link/a/../../B.lf", "../here/B.lf"];
        let joined = imports.map(|import| join(&Linked, "A.lf", import));
        assert_eq!(joined, ["link/../B.lf", "link/B.lf", "link/B.lf", "link/../B.lf", "../here/B.lf"]);
        assert_eq!(join(&Linked, "link/A.lf", "../B.lf"), "link/../B.lf");
        let for_tools = imports.map(|import| beside(&Linked, "A.lf", import));
        assert_eq!(for_tools, ["/deep/B.lf", "link/B.lf", "link/B.lf", "/deep/B.lf", "../here/B.lf"]);
    }

    #[test]
    fn packages_are_beside_the_folder_of_sources() {
        let first = |importing| in_package(&none(), importing, "lib/a/B.lf").swap_remove(0);
        assert_eq!(first("src/Main.lf"), "build/lfc_include/lib/src/lib/a/B.lf");
        assert_eq!(first("/p/src/deep/Main.lf"), "/p/build/lfc_include/lib/src/lib/a/B.lf");
        assert_eq!(first("Main.lf"), "../build/lfc_include/lib/src/lib/a/B.lf");
    }

    #[test]
    fn imports_are_relative_to_the_importing_file() {
        assert_eq!(join(&none(), "src/Main.lf", "lib/A.lf"), "src/lib/A.lf");
        assert_eq!(join(&none(), "Main.lf", "./A.lf"), "A.lf");
        assert_eq!(join(&none(), "src/lib/A.lf", "../B.lf"), "src/B.lf");
        assert_eq!(join(&none(), "A.lf", "../B.lf"), "../B.lf");
        assert_eq!(join(&none(), "/a/A.lf", "../../../B.lf"), "/../../B.lf");
        assert_eq!(join(&none(), "a/A.lf", "/b//B.lf"), "/b/B.lf");
        assert_eq!([".", "a/..", "/", "/a/.."].map(|folder| normalize(&none(), folder)), [".", ".", "/", "/"]);
    }
}
