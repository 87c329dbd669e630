// SPDX-License-Identifier: Apache-2.0
//! `lfz build`

use std::io;
use std::path::Path;
use std::process::ExitCode;

use lf_compiler::emit::Artifact;
use lf_compiler::emit::deployment::Place;
use serde_json::{Value, json};

use crate::args::BuildArgs;
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::terminal;

/// Generates and compiles, and says where the results are.
pub(super) fn build(arguments: &BuildArgs) -> Result<ExitCode, Failure> {
    let request = Request {
        file: &arguments.file,
        platform: arguments.platform,
        board: &arguments.board,
        federates: &arguments.federates,
        deployment: arguments.deployment.as_deref(),
        places: &arguments.places,
    };
    let built = request.build()?;
    if arguments.json {
        terminal::print(format_args!("{:#}", description(&built)))?;
    } else {
        print_for_people(&built)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn print_for_people(built: &Built) -> io::Result<()> {
    let width = built.participants.iter().map(|participant| participant.name.chars().count()).max().unwrap_or(0);
    for participant in &built.participants {
        let name = &participant.name;
        match (&participant.artifact, built.programs.get(name)) {
            (Artifact::Zephyr { board, .. }, _) => {
                let folder = built.out.join(&participant.folder);
                terminal::print(format_args!("{name:width$}  crate for {board}: {}", folder.display()))?;
            }
            (Artifact::Host, Some(program)) => {
                terminal::print(format_args!("{name:width$}  {}", program.display()))?;
            }
            (Artifact::Host, None) => {}
        }
    }
    Ok(())
}

/// The same for other programs, such as the west commands. Paths are absolute.
fn description(built: &Built) -> Value {
    let target = &built.plan.target;
    let rti = built.plan.rti.as_ref().map(|rti| {
        json!({ "host": built.rti.ip.map_or_else(|| rti.host.clone(), |ip| ip.to_string()),
            "port": built.rti.port.unwrap_or(rti.port), "federation_id": rti.federation_id,
            "federates": built.plan.federates.len(), "clock_sync": target.clock_sync,
            "clock_sync_trials": target.clock_sync_trials })
    });
    let participants: Vec<Value> = built
        .participants
        .iter()
        .map(|participant| {
            let mut value = json!({ "id": participant.id, "name": participant.name, "package": participant.package,
                "crate": path(&built.out.join(&participant.folder)) });
            match &participant.artifact {
                Artifact::Host => {
                    value["platform"] = json!("host");
                    value["program"] = json!(built.programs.get(&participant.name).map(|program| path(program)));
                }
                Artifact::Zephyr { board, kconfig, overlay, place } => {
                    value["platform"] = json!("zephyr");
                    value["board"] = json!(board);
                    value["kconfig"] = json!(path(&built.out.join(kconfig)));
                    value["overlay"] = json!(path(&built.out.join(overlay)));
                    add_place(&mut value, place);
                }
            }
            value
        })
        .collect();
    json!({ "program": built.plan.name, "out": path(&built.out), "rti": rti, "participants": participants })
}

fn add_place(value: &mut Value, place: &Place) {
    value["ip"] = json!(place.network.map(|network| network.ip.to_string()));
    value["mac"] = json!(place.mac.map(|mac| mac.to_string()));
    value["runner"] = json!(place.runner);
    value["probe"] = json!(place.probe);
}

fn path(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
