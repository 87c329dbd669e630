// SPDX-License-Identifier: Apache-2.0
//! `lfz keys`

use std::process::ExitCode;

use crate::args::{KeyFolder, KeysCommand};
use crate::compile::Program;
use crate::failure::Failure;
use crate::keys::{KeyStore, remove_copies};
use crate::terminal;

/// Makes, shows, trusts or distrusts keys.
pub(super) fn keys(command: &KeysCommand) -> Result<ExitCode, Failure> {
    match command {
        KeysCommand::New { of, names } => {
            let store = store(of)?;
            let made = store.create(names)?;
            let folder = store.folder.display();
            if made.is_empty() {
                terminal::report(format_args!("all keys are there already, in {folder}"));
            } else {
                terminal::report(format_args!("made keys for {} in {folder}", made.join(", ")));
            }
            show(&store)?;
        }
        KeysCommand::Show { of } => show(&store(of)?)?,
        KeysCommand::Trust { of, name, key } => {
            let part = store(of)?.trust(name, key)?;
            terminal::print(format_args!("{name} is trusted with {}", part.fingerprint()))?;
        }
        KeysCommand::Distrust { of, name } => distrust(of, name)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn store(of: &KeyFolder) -> Result<KeyStore, Failure> {
    let plan = Program::load(&of.file)?.plan;
    KeyStore::of(&of.file, &plan, of.folder.as_deref(), of.deployment.as_deref())
}

/// Prints a line for each participant.
fn show(store: &KeyStore) -> Result<(), Failure> {
    let entries = store.entries()?;
    let width = entries.iter().map(|entry| entry.name.chars().count()).max().unwrap_or(0);
    for entry in &entries {
        let name = entry.name;
        let line = match (&entry.public, entry.has_secret) {
            (None, _) => "no key: nobody trusts it".to_owned(),
            (Some(part), true) => format!("{}  its secret key is here", part.fingerprint()),
            (Some(part), false) => part.fingerprint(),
        };
        terminal::print(format_args!("{name:width$}  {line}"))?;
    }
    Ok(())
}

fn distrust(of: &KeyFolder, name: &str) -> Result<(), Failure> {
    let store = store(of)?;
    let Some(id) = store.distrust(name)? else {
        terminal::print(format_args!(
            "the RTI's key is gone; `lfz keys new` makes another one, which all federates have to get"
        ))?;
        return Ok(());
    };
    remove_copies(&of.file, &store.program, id)?;
    terminal::print(format_args!(
        "nobody here trusts {name} any more, and the RTI refuses it from its next start on.\n\
         Where the RTI or other programs run on other computers, remove {id}.pub and {id}.crt from their folders of \
         keys.\n\
         `lfz keys new` makes a key for its successor"
    ))?;
    Ok(())
}
