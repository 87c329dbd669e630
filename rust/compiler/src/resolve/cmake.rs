// SPDX-License-Identifier: Apache-2.0
//! The settings in a file for CMake, as far as they are visible without CMake.

use crate::plan::{CmakeFile, Location};

/// The variable by which LF's compiler names the program.
const TARGET: &str = "${LF_MAIN_TARGET}";

/// Conditions whose values on Linux are known.
const CONDITIONS: [(&str, bool); 6] =
    [("WIN32", false), ("MSVC", false), ("APPLE", false), ("CYGWIN", false), ("UNIX", true), ("LINUX", true)];

/// Reads the text of a file at a path.
pub(super) fn read(path: String, text: &str, at: Location) -> CmakeFile {
    let (sources, folders, definitions) = (Vec::new(), Vec::new(), Vec::new());
    let (options, libraries) = (Vec::new(), Vec::new());
    let mut file = CmakeFile { path, sources, folders, definitions, options, libraries, unread: None, at };
    // The values of the open conditions.
    let mut open: Vec<bool> = Vec::new();
    for (command, arguments) in commands(text) {
        let is_active = open.iter().all(|holds| *holds);
        let done = match command.as_str() {
            "if" => condition(&arguments).map(|holds| open.push(holds)),
            "else" => open.last_mut().map(|holds| *holds = !*holds),
            "endif" => open.pop().map(drop),
            _ if !is_active => Some(()),
            _ => apply(&command, &arguments, &mut file),
        };
        if done.is_none() {
            file.unread = Some(format!("`{command}({})`", arguments.join(" ")));
            break;
        }
    }
    file
}

/// CMake's variables for the folder of the file itself, or for that of the sources, into which LF's compiler copies it.
const FOLDERS: [&str; 4] =
    ["${CMAKE_CURRENT_LIST_DIR}", "${CMAKE_CURRENT_SOURCE_DIR}", "${CMAKE_SOURCE_DIR}", "${PROJECT_SOURCE_DIR}"];

/// Keywords that set the scope of the following arguments.
const KEYWORDS: [&str; 5] = ["PRIVATE", "PUBLIC", "INTERFACE", "BEFORE", "SYSTEM"];

/// Returns the value of a condition; `None` for one that only CMake knows.
fn condition(arguments: &[String]) -> Option<bool> {
    let words: Vec<&str> = arguments.iter().map(|word| word.trim_matches(['(', ')'])).collect();
    let (is_negated, name) = match &words[..] {
        ["NOT", name] => (true, name),
        [name] => (false, name),
        _ => return None,
    };
    let (_, holds) = CONDITIONS.iter().find(|(known, _)| known == name)?;
    Some(*holds != is_negated)
}

/// Applies a command; returns `None` if only CMake can.
fn apply(command: &str, arguments: &[String], file: &mut CmakeFile) -> Option<()> {
    let (arguments, is_of_target) = match arguments.split_first() {
        Some((target, rest)) if command.starts_with("target_") => (rest, target == TARGET),
        _ => (arguments, true),
    };
    let list = match command.strip_prefix("target_").unwrap_or(command) {
        "sources" => &mut file.sources,
        "include_directories" => &mut file.folders,
        "compile_definitions" | "add_compile_definitions" | "add_definitions" => &mut file.definitions,
        "compile_options" | "add_compile_options" => &mut file.options,
        "link_libraries" => &mut file.libraries,
        "message" | "cmake_minimum_required" => return Some(()),
        _ => return None,
    };
    let given = arguments.iter().filter(|argument| !KEYWORDS.contains(&argument.as_str()));
    // The caller searches files and folders beside the file anyway.
    let is_path = ["sources", "include_directories"].iter().any(|one| command.ends_with(one));
    let beside = |argument: &str| {
        let behind = FOLDERS.iter().filter(|_| is_path).find_map(|folder| argument.strip_prefix(folder));
        behind.map(|path| path.trim_start_matches('/')).map(|path| if path.is_empty() { "." } else { path }.to_owned())
    };
    let plain = |argument: &String| argument.trim_start_matches("-D").to_owned();
    let given: Vec<String> = given.map(|argument| beside(argument).unwrap_or_else(|| plain(argument))).collect();
    let is_known = is_of_target && !given.iter().any(|argument| argument.contains('$'));
    list.extend(given.into_iter().filter(|_| is_known));
    is_known.then_some(())
}

/// Returns the commands of a text in lower case, with their arguments.
fn commands(text: &str) -> Vec<(String, Vec<String>)> {
    let plain: String = text.lines().map(|line| uncommented(line).to_owned() + "\n").collect();
    let (mut commands, mut rest) = (Vec::new(), plain.as_str());
    while let Some((name, behind)) = rest.split_once('(') {
        let end = end_of_arguments(behind);
        commands.push((name.trim().to_ascii_lowercase(), arguments(&behind[..end])));
        rest = behind.get(end + 1..).unwrap_or_default();
    }
    // Text that is no command counts as an unknown one.
    let left = rest.trim();
    commands.extend((!left.is_empty()).then(|| (left.to_owned(), Vec::new())));
    commands
}

/// Returns a line without its comment.
fn uncommented(line: &str) -> &str {
    let mut quoted = false;
    let is_mark = |(_, character): &(usize, char)| {
        quoted ^= *character == '"';
        *character == '#' && !quoted
    };
    line.char_indices().find(is_mark).map_or(line, |(at, _)| &line[..at])
}

/// Returns the end of the arguments, where the open bracket closes.
fn end_of_arguments(text: &str) -> usize {
    let (mut depth, mut quoted) = (0_usize, false);
    for (at, character) in text.char_indices() {
        match character {
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted && depth == 0 => return at,
            ')' if !quoted => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// Returns words, and texts in quotes.
fn arguments(text: &str) -> Vec<String> {
    let mut arguments: Vec<String> = Vec::new();
    for (index, part) in text.split('"').enumerate() {
        if index % 2 == 1 {
            arguments.push(part.to_owned());
        } else {
            arguments.extend(
                part.split(|c: char| c.is_whitespace() || c == ';').filter(|it| !it.is_empty()).map(str::to_owned),
            );
        }
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::FileIndex;

    fn file(text: &str) -> CmakeFile {
        read("a.cmake".into(), text, Location { file: FileIndex(0), line: 1, column: 1 })
    }

    #[test]
    fn files_that_need_no_cmake_are_read() {
        let file = file(
            "add_compile_definitions(FOO=3.14 -DBAR) # and\n\
             IF (NOT WIN32)\n  target_link_libraries(${LF_MAIN_TARGET} PRIVATE m) # it\n\
             ELSE()\nfind_package(X)\nENDIF()\n\
             target_sources(${LF_MAIN_TARGET}\n  PRIVATE c/count.c \"c/a b.c\")\n\
             target_include_directories(${LF_MAIN_TARGET} PUBLIC include)\nadd_compile_options(-Wall)",
        );
        assert_eq!(file.definitions, ["FOO=3.14", "BAR"]);
        assert_eq!(file.libraries, ["m"]);
        assert_eq!(file.sources, ["c/count.c", "c/a b.c"]);
        assert_eq!(file.folders, ["include"]);
        assert_eq!(file.options, ["-Wall"]);
        assert_eq!(file.unread, None);
    }

    #[test]
    fn the_folder_of_the_file_is_where_its_files_are() {
        let file = file(
            "target_sources(${LF_MAIN_TARGET} PRIVATE\n  ${CMAKE_CURRENT_LIST_DIR}/a.c\n  \
             ${CMAKE_CURRENT_SOURCE_DIR}/c/b.c)\n\
             target_include_directories(${LF_MAIN_TARGET} PRIVATE \"${CMAKE_CURRENT_LIST_DIR}\" ${CMAKE_SOURCE_DIR}/h)",
        );
        assert_eq!(file.sources, ["a.c", "c/b.c"]);
        assert_eq!(file.folders, [".", "h"]);
        assert_eq!(file.unread, None);
    }

    #[test]
    fn commands_that_only_cmake_understands_are_named() {
        let unread = |text| file(text).unread;
        assert_eq!(unread("find_package(X REQUIRED)").as_deref(), Some("`find_package(X REQUIRED)`"));
        assert_eq!(unread("target_sources(other PRIVATE a.c)").as_deref(), Some("`target_sources(other PRIVATE a.c)`"));
        assert_eq!(
            unread("target_link_libraries(${LF_MAIN_TARGET} ${LIBS})").as_deref(),
            Some("`target_link_libraries(${LF_MAIN_TARGET} ${LIBS})`")
        );
        assert!(unread("if(X)\nendif()").is_some());
        assert!(unread("endif()").is_some());
        assert!(unread("no command").is_some());
    }
}
