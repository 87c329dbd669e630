// SPDX-License-Identifier: Apache-2.0
//! The documents name existing files, are linked, and stay readable.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::finding::Finding;
use super::tree::{File, Tree};

/// The documents at the top level that describe the repository as it is.
const DOCUMENTS: &[&str] = &["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md", "MEASUREMENTS.md"];
/// The folder of all others.
const FOLDER: &str = "docs/";
/// The table of contents of the guide.
const SUMMARY: &str = "docs/guide/src/SUMMARY.md";
/// The maximum numbers of lines: a newcomer reads one in one go, and the other is a page.
const LINES_MAX: [(&str, usize); 2] = [("ARCHITECTURE.md", 200), ("MEASUREMENTS.md", 80)];
/// In characters.
const LINE_LENGTH_MAX: usize = 120;

/// Checks every path in backquotes that begins with a folder of the repository, and every relative link, with the
/// heading that it leads to.
pub(super) fn paths_exist(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for name in DOCUMENTS.iter().filter(|name| !tree.files.iter().any(|file| file.path == **name)) {
        findings.push(Finding { place: (*name).to_owned(), what: "is missing".to_owned() });
    }
    for (document, number, line) in lines(tree) {
        let quoted = quoted(line).filter(|path| names_a_file(tree, path)).map(PathBuf::from);
        let linked = links(line).map(|(file, _)| linked_file(document, file));
        let lost = links(line).filter(|(file, heading)| !has_heading(tree, &linked_file(document, file), heading));
        findings.extend(lost.map(|(file, heading)| Finding {
            place: format!("{}:{number}", document.path),
            what: format!("leads to `{file}#{heading}`, where no heading is called so"),
        }));
        for path in quoted.chain(linked).filter(|path| !tree.root.join(path).exists()) {
            let place = format!("{}:{number}", document.path);
            findings.push(Finding { place, what: format!("names `{}`, which does not exist", path.display()) });
        }
    }
    findings
}

/// Checks that every page in the folder of documents is linked from another one, and each chapter of the guide in its
/// contents.
pub(super) fn pages_linked(tree: &Tree) -> Vec<Finding> {
    let mut linked = BTreeSet::new();
    for (document, _, line) in lines(tree) {
        let is_chapter = |path: &Path| document.path == SUMMARY || !path.starts_with("docs/guide");
        let others =
            links(line).map(|(file, _)| linked_file(document, file)).filter(|path| *path != Path::new(&document.path));
        linked.extend(others.filter(|path| is_chapter(path)));
    }
    let pages = tree.files.iter().filter(|file| is_document(file) && file.path.starts_with(FOLDER));
    let lonely = pages.filter(|file| file.path != SUMMARY && !linked.contains(Path::new(&file.path)));
    let what = |file: &File| {
        let is_chapter = file.path.starts_with("docs/guide/");
        if is_chapter { format!("is not in {SUMMARY}") } else { "is linked from no other document".to_owned() }
    };
    lonely.map(|file| Finding { place: file.path.clone(), what: what(file) }).collect()
}

/// Checks that documents have short lines, and some of them few of these.
pub(super) fn sizes(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (document, number, line) in lines(tree) {
        let length = line.chars().count();
        // Neither a row of a table nor an address can be broken.
        if length > LINE_LENGTH_MAX && !line.starts_with('|') && !line.contains("https://") {
            let what = format!("{length} characters, more than {LINE_LENGTH_MAX}");
            findings.push(Finding { place: format!("{}:{number}", document.path), what });
        }
        if let Some((_, max)) = LINES_MAX.iter().find(|(path, max)| document.path == *path && number == max + 1) {
            let what = format!("more than {max} lines; move depth into docs/internals");
            findings.push(Finding { place: document.path.clone(), what });
        }
    }
    findings
}

fn is_document(file: &File) -> bool {
    DOCUMENTS.contains(&file.path.as_str()) || file.path.starts_with(FOLDER) && file.kind() == "md"
}

/// Returns all lines of the documents with their numbers.
fn lines(tree: &Tree) -> impl Iterator<Item = (&File, usize, &str)> {
    tree.files.iter().filter(|file| is_document(file)).flat_map(|file| {
        let text = file.text.as_deref().unwrap_or_default();
        text.lines().enumerate().map(move |(index, line)| (file, index + 1, line))
    })
}

/// Returns the texts in backquotes.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// Returns the Markdown links that stay in the repository: the file, empty for the document itself, and the text behind
/// `#`.
fn links(line: &str) -> impl Iterator<Item = (&str, &str)> {
    let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.contains("://")).map(|target| target.split_once('#').unwrap_or((target, "")))
}

/// Returns whether a document has a heading with this name in links; true without a name, and for other files.
fn has_heading(tree: &Tree, path: &Path, name: &str) -> bool {
    let document = tree.files.iter().find(|file| Path::new(&file.path) == path);
    let Some(text) = document.and_then(|file| file.text.as_deref()).filter(|_| !name.is_empty()) else { return true };
    let is_kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    let in_links = |heading: &str| heading.trim().to_lowercase().chars().filter(is_kept).collect::<String>();
    let mut headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#'));
    headings.any(|heading| in_links(heading).replace(' ', "-") == name)
}

/// Returns the file that a link in a document leads to, relative to the repository.
fn linked_file(document: &File, link: &str) -> PathBuf {
    let mut path = PathBuf::from(&document.path);
    if link.is_empty() {
        return path;
    }
    path.pop();
    for part in Path::new(link).components() {
        match part {
            Component::ParentDir => _ = path.pop(),
            other => path.push(other),
        }
    }
    path
}

/// Returns whether a text is meant as a path here: it begins with a folder of the top level, or is a file name of it.
fn names_a_file(tree: &Tree, text: &str) -> bool {
    if text.is_empty() || text.contains(|c: char| c.is_whitespace() || "<>{}*…$".contains(c)) {
        return false;
    }
    let Some((top, rest)) = text.split_once('/') else {
        // A single name is a file of the top level when it looks like one of those.
        return matches!(text.rsplit_once('.'), Some((_, "md" | "toml" | "yml")));
    };
    // Files below a build folder do not exist before a build.
    let is_built = top == "build" || top == "target" || rest.split('/').any(|part| part == "build");
    !is_built && tree.files.iter().any(|file| file.path.split('/').next() == Some(top))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(files: &[(&str, &str)]) -> Tree {
        let file =
            |(path, text): &(&str, &str)| File { path: (*path).to_owned(), size: 0, text: Some((*text).to_owned()) };
        Tree { root: PathBuf::from(env!("CARGO_MANIFEST_DIR")), files: files.iter().map(file).collect() }
    }

    #[test]
    fn paths_are_found_in_text() {
        assert_eq!(quoted("a `b/c` d `e`").collect::<Vec<_>>(), ["b/c", "e"]);
        let line = "see [x](docs/y.md#z), [above](#a) and [w](https://example.org)";
        assert_eq!(links(line).collect::<Vec<_>>(), [("docs/y.md", "z"), ("", "a")]);
        let page = &tree(&[("docs/guide/src/a.md", "")]).files[0];
        assert_eq!(linked_file(page, "../../b.md"), Path::new("docs/b.md"));
    }

    #[test]
    fn a_path_that_does_not_exist_is_found() {
        let readme = "`src/main.rs`, `src/nothing.rs`, `other/x`, `src/*.rs`";
        let others = [("ARCHITECTURE.md", ""), ("CONTRIBUTING.md", ""), ("MEASUREMENTS.md", ""), ("src/main.rs", "")];
        let page = ("docs/page.md", "[there](../src/main.rs) [not](src/main.rs)");
        let tree = tree(&[&others[..], &[("README.md", readme), page]].concat());
        let findings = paths_exist(&tree);
        assert_eq!(findings.len(), 2, "{findings:?}");
        assert!(findings[0].what.contains("src/nothing.rs") && findings[1].what.contains("docs/src/main.rs"));
        assert!(!names_a_file(&tree, "src/build/x"));
    }

    #[test]
    fn a_link_to_no_heading_is_found() {
        let page = ("docs/page.md", "# One `page`\n[above](#one-page) [there](../src/main.rs) [not](#two)");
        let findings = paths_exist(&tree(&[page]));
        let lost: Vec<&str> = findings.iter().map(|one| one.what.as_str()).filter(|what| what.contains('#')).collect();
        assert_eq!(lost, ["leads to `#two`, where no heading is called so"]);
    }

    #[test]
    fn a_page_that_nobody_links_is_found() {
        let chapters = [(SUMMARY, "[a](a.md)"), ("docs/guide/src/a.md", "[b](b.md)"), ("docs/guide/src/b.md", "")];
        let pages = [("docs/internals/c.md", "[itself](c.md)"), ("docs/internals/d.md", "")];
        let findings =
            pages_linked(&tree(&[&chapters[..], &pages, &[("README.md", "[d](docs/internals/d.md)")]].concat()));
        let places: Vec<&str> = findings.iter().map(|finding| finding.place.as_str()).collect();
        assert_eq!(places, ["docs/guide/src/b.md", "docs/internals/c.md"]);
    }

    #[test]
    fn long_lines_and_a_long_architecture_are_found() {
        let long = "x".repeat(121);
        assert_eq!(sizes(&tree(&[("docs/a.md", &long), ("CHANGELOG.md", &long)])).len(), 1);
        assert_eq!(sizes(&tree(&[("docs/a.md", &format!("| {long} |\nhttps://{long}"))])), []);
        assert_eq!(sizes(&tree(&[("ARCHITECTURE.md", &"x\n".repeat(200))])), []);
        assert_eq!(sizes(&tree(&[("ARCHITECTURE.md", &"x\n".repeat(300))])).len(), 1);
        assert_eq!(sizes(&tree(&[("MEASUREMENTS.md", &"x\n".repeat(100))])).len(), 1);
    }
}
