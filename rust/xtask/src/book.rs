// SPDX-License-Identifier: Apache-2.0
//! The guide as a site, in `target/guide`: mdBook makes the pages, and this module an index of them for language models
//! (<https://llmstxt.org>) and the proof that no link in the site leads nowhere.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;
use crate::report::Report;

/// Pages that repeat others, or that only a server shows.
const NOT_CHECKED: [&str; 3] = ["404.html", "print.html", "toc.html"];

/// Builds the site, if mdBook is there, and checks its links.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    if process::captured(Command::new("mdbook").arg("--version")).is_none() {
        report.skip("book", "mdbook is not installed: cargo install mdbook");
        return;
    }
    match make(repository) {
        Ok(broken) => {
            for link in &broken {
                eprintln!("error: {link}");
            }
            report.check("book", broken.is_empty());
        }
        Err(error) => report.fail("book", &error.to_string()),
    }
}

/// Builds the site and returns its broken links.
pub(crate) fn make(repository: &Path) -> io::Result<Vec<String>> {
    let (source, site) = (repository.join("docs/guide/src"), repository.join("target/guide"));
    let mut mdbook = Command::new("mdbook");
    mdbook.current_dir(repository).args(["build", "docs/guide", "--dest-dir"]).arg(&site);
    if !process::succeeds(&mut mdbook) {
        return Err(io::Error::other("mdbook does not make the site"));
    }
    let pages = sources(&source)?;
    for (name, text) in &pages {
        fs::write(site.join(name), text)?;
    }
    fs::write(site.join("llms.txt"), index(&pages))?;
    broken_links(&site)
}

/// Returns the texts of the guide's files, by their names.
fn sources(folder: &Path) -> io::Result<BTreeMap<String, String>> {
    let mut pages = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "md")
            && let Some(name) = path.file_name().and_then(|name| name.to_str())
        {
            pages.insert(name.to_owned(), fs::read_to_string(&path)?);
        }
    }
    Ok(pages)
}

/// Returns the list of chapters, each with the beginning of its text.
fn index(pages: &BTreeMap<String, String>) -> String {
    let about = pages.get("README.md").map(|text| beginning(text)).unwrap_or_default();
    let mut index = format!("# Lingua Franca for Zephyr, in Rust\n\n> {about}\n");
    for line in pages.get("SUMMARY.md").map(|text| text.lines()).into_iter().flatten().skip(1) {
        if let Some(part) = line.strip_prefix("# ") {
            let _ = writeln!(index, "\n## {part}\n");
            continue;
        }
        let Some((title, rest)) = line.split_once('[').and_then(|(_, rest)| rest.split_once("](")) else { continue };
        let Some(file) = rest.strip_suffix(')').filter(|file| *file != "README.md") else { continue };
        let text = pages.get(file).map(|text| beginning(text)).unwrap_or_default();
        let _ = writeln!(index, "- [{title}]({file}): {text}");
    }
    index
}

/// Returns the first sentence of a page: of its first paragraph that is neither a heading nor a block, as one line.
fn beginning(text: &str) -> String {
    let mut in_block = false;
    let mut words = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            in_block = !in_block;
        }
        let begins_block = line.starts_with("```") || line.starts_with(['#', '|', '-', '<', '!']);
        let is_prose = !in_block && !begins_block && !line.trim().is_empty();
        if is_prose {
            words.extend(line.split_whitespace());
        } else if !words.is_empty() {
            break;
        }
    }
    let text = words.join(" ");
    text.find(". ").map_or(text.clone(), |end| text[..=end].to_owned())
}

/// Returns the links in the pages of a site that lead to no file, or to no place in it.
fn broken_links(site: &Path) -> io::Result<Vec<String>> {
    let mut texts: BTreeMap<PathBuf, String> = BTreeMap::new();
    for entry in fs::read_dir(site)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "html") {
            texts.insert(path.clone(), fs::read_to_string(&path)?);
        }
    }
    let ids: BTreeMap<&PathBuf, BTreeSet<&str>> =
        texts.iter().map(|(path, text)| (path, values(text, "id").collect())).collect();
    let mut broken = Vec::new();
    for (page, text) in &texts {
        let name = page.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if NOT_CHECKED.contains(&name) {
            continue;
        }
        for link in values(text, "href").chain(values(text, "src")) {
            let is_outside =
                ["https:", "http:", "mailto:", "data:", "javascript:"].iter().any(|it| link.starts_with(it));
            if is_outside || link.is_empty() {
                continue;
            }
            let (file, place) = link.split_once('#').map_or((link, None), |(file, place)| (file, Some(place)));
            let target = if file.is_empty() { page.clone() } else { site.join(file) };
            let has_place = |place: &str| ids.get(&target).is_none_or(|ids| place.is_empty() || ids.contains(place));
            if !target.exists() || !place.is_none_or(has_place) {
                broken.push(format!("{name}: the link `{link}` leads nowhere"));
            }
        }
    }
    Ok(broken)
}

/// Returns the values of an attribute in HTML, as mdBook writes it.
fn values<'t>(text: &'t str, attribute: &str) -> impl Iterator<Item = &'t str> {
    let begin = format!(" {attribute}=\"");
    let mut rest = text;
    std::iter::from_fn(move || {
        let (_, value) = rest.split_once(&begin)?;
        let (value, after) = value.split_once('"')?;
        rest = after;
        Some(value)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::{broken_links, index};

    #[test]
    fn the_index_has_each_chapter_with_its_beginning() {
        let pages = [
            ("README.md", "# About\n\nThis guide is\nshort. Yes.\n\nMore.\n"),
            ("SUMMARY.md", "# Summary\n\n[About](README.md)\n\n# Programs\n\n- [First](a.md)\n"),
            ("a.md", "# First\n\n```sh\nlfz\n```\n\nThe first\nchapter.\n"),
        ];
        let pages: BTreeMap<String, String> = pages.map(|(name, text)| (name.to_owned(), text.to_owned())).into();
        let expected = "# Lingua Franca for Zephyr, in Rust\n\n> This guide is short.\n\n## Programs\n\n\
            - [First](a.md): The first chapter.\n";
        assert_eq!(index(&pages), expected);
    }

    #[test]
    fn links_to_missing_files_and_places_are_found() {
        let site = std::env::temp_dir().join(format!("lf-book-{}", std::process::id()));
        fs::create_dir_all(&site).expect("it can be made");
        let page = "<a href=\"b.html#here\"><a href=\"b.html#there\"><a href=\"c.html\"><a href=\"https://d\">\
            <p id=\"x\"><a href=\"#x\">";
        fs::write(site.join("a.html"), page).expect("it can be written");
        fs::write(site.join("b.html"), "<h1 id=\"here\">").expect("it can be written");
        let broken = broken_links(&site);
        fs::remove_dir_all(&site).expect("it is ours");
        let expected = ["a.html: the link `b.html#there` leads nowhere", "a.html: the link `c.html` leads nowhere"];
        assert_eq!(broken.expect("it can be read"), expected);
    }
}
