// SPDX-License-Identifier: Apache-2.0
//! `lfz new`

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;

use crate::args::{NewArgs, NewLanguage};
use crate::failure::Failure;
use crate::terminal;

/// The reactor that the program is about, in its own file, so that others can import it and a test can name it.
const MEAN: [&str; 2] = [include_str!("mean.rust.lf"), include_str!("mean.c.lf")];
/// The program, in which `MAIN` is the word for its main reactor.
const PROGRAM: [&str; 2] = [include_str!("program.rust.lf"), include_str!("program.c.lf")];
const TEST: &str = include_str!("mean.test.txt");
/// The image for Zephyr's own tools, and their expectations of it.
const IMAGE: &str = include_str!("image.cmake.txt");
const SAMPLE: &str = include_str!("sample.txt");
/// The tests at each push, where the program is hosted.
const WORKFLOW: &str = include_str!("workflow.txt");
/// The end of a sample: what the image prints, or, for one that waits for others, that it can be built.
const PRINTS: &str = "    timeout: 600\n    harness: console\n    harness_config:\n      type: multi_line\n      \
                      ordered: true\n      regex:\n        - \"0 ms: 5\"\n        - \"1000 ms: 45\"\n";
const IS_BUILT: &str = "    build_only: true\n    extra_args: LF_FEDERATE=sensor LF_DEPLOYMENT=deployment.yaml\n";

/// Makes the folder of a program that runs.
pub(super) fn new(arguments: &NewArgs) -> Result<ExitCode, Failure> {
    let folder = &arguments.folder;
    let name = name_of(folder)?;
    if let Some(board) = arguments.board.as_deref().filter(|board| !is_board(board)) {
        return Err(Failure::message(format!("\"{board}\" is no name of a board, such as native_sim/native/64")));
    }
    fs::create_dir(folder).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => Failure::message(format!("{} exists already", folder.display())),
        _ => Failure::message(format!("{} cannot be made: {error}", folder.display())),
    })?;
    let language = usize::from(arguments.target == NewLanguage::C);
    let main = if arguments.federated { "federated" } else { "main" };
    let mut files = vec![
        (format!("src/{name}.lf"), PROGRAM[language].replace("MAIN", main)),
        ("src/lib/Mean.lf".to_owned(), MEAN[language].to_owned()),
        ("test/mean.test.yaml".to_owned(), TEST.to_owned()),
        (".gitignore".to_owned(), "build/\n".to_owned()),
        ("README.md".to_owned(), readme(&name, arguments)),
    ];
    let mut checked_with = "";
    if let Some(board) = &arguments.board {
        let expected = if arguments.federated { IS_BUILT } else { PRINTS };
        let sample = SAMPLE.replace("PROGRAM", &name).replace("BOARD", board) + expected;
        files.push(("CMakeLists.txt".to_owned(), IMAGE.replace("PROGRAM", &name)));
        files.push(("sample.yaml".to_owned(), sample));
        if arguments.federated {
            files.push(("deployment.yaml".to_owned(), deployment(board)));
            checked_with = " --deployment deployment.yaml";
        }
    }
    let workflow = WORKFLOW.replace("PROGRAM", &name).replace("DEPLOYMENT", checked_with);
    files.push((".github/workflows/test.yml".to_owned(), workflow));
    for (path, text) in &files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        fs::write(path, text)?;
    }
    let shown = folder.display();
    terminal::print(format_args!("{shown} is there. Try:\n\n    cd {shown}\n    lfz run src/{name}.lf\n    lfz test"))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the name of the program: that of the folder, as reactors are called.
fn name_of(folder: &Path) -> Result<String, Failure> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name: String = words.map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) && folder.to_string_lossy().is_ascii() {
        return Ok(name);
    }
    let shown = folder.display();
    Err(Failure::message(format!("a program cannot be named after {shown}: choose a name of letters and digits")))
}

/// Returns whether a text is as names of boards are, with what may follow them, such as a revision.
fn is_board(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "_/@.-".contains(c))
}

/// Returns a deployment with the sensor on a board, and the rest on this computer.
fn deployment(board: &str) -> String {
    format!(
        "# The sensor is on a board; the others, and the RTI, run on this computer.\n\
         rti: {{ platform: host, ip: 10.0.0.1 }}\nfederates:\n  sensor: {{ platform: {board:?}, ip: 10.0.0.2 }}\n"
    )
}

fn readme(name: &str, arguments: &NewArgs) -> String {
    let run = "lfz run";
    let image = match (&arguments.board, arguments.federated) {
        (None, _) => String::new(),
        (Some(board), false) => {
            format!(
                "\nAn image for {board}, in a Zephyr workspace:\n\n```sh\n\
                 lfz west lf-build src/{name}.lf -w \"-b {board}\"\nwest twister -T . -p {board}\n```\n"
            )
        }
        (Some(_), true) => format!(
            "\n`deployment.yaml` says what runs where. All of it, in a Zephyr workspace:\n\n```sh\n\
             lfz west lf-fed-build src/{name}.lf\nlfz west lf-fed-run src/{name}.lf\n```\n"
        ),
    };
    format!(
        "# {name}\n\nA sensor counts, and the mean of its last two values is printed.\n\n```sh\n\
         {run} src/{name}.lf\nlfz test\n```\n{image}"
    )
}
