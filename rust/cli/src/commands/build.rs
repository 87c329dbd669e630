// SPDX-License-Identifier: Apache-2.0
//! `lfz build`

use std::io;
use std::path::Path;
use std::process::ExitCode;

use lf_compiler::deployment::{Place, RtiHome};
use lf_compiler::emit::{Artifact, Role, rti_name};
use serde_json::{Value, json};

use super::rti::options_for;
use crate::args::BuildArgs;
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::keys::{HandedOut, KeySource};
use crate::terminal;

/// Generates and compiles, and prints the paths of the results.
pub(super) fn build(arguments: &BuildArgs) -> Result<ExitCode, Failure> {
    let request = Request {
        platform: arguments.platform,
        board: arguments.board.as_deref(),
        federates: &arguments.federates,
        deployment: arguments.deployment.as_deref(),
        ..Request::new(&arguments.file, &arguments.places)
    };
    let built = request.build()?;
    let keys = keys(&built, arguments)?;
    if arguments.json {
        terminal::print(format_args!("{:#}", description(&built, keys.as_ref())?))?;
    } else {
        print_for_people(&built)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Hands out the keys of a federation that asks for encryption. Programs of this computer can be built before there are
/// keys.
fn keys(built: &Built, arguments: &BuildArgs) -> Result<Option<HandedOut>, Failure> {
    let (file, deployment) = (&*arguments.file, arguments.deployment.as_deref());
    let source = KeySource { file, given: arguments.keys.as_deref(), deployment };
    let has_images = built.participants.iter().any(|participant| participant.artifact != Artifact::Host);
    if !has_images && source.is_missing(&built.plan)? {
        let name = &built.plan.name;
        terminal::report(format_args!("{name} asks for encryption and has no keys yet: make them with `lfz keys new`"));
        return Ok(None);
    }
    let rti = rti_name(&built.plan);
    let mut names: Vec<&str> = built.participants.iter().map(|participant| participant.name.as_str()).collect();
    if !names.contains(&rti.as_str()) {
        names.push(&rti);
    }
    let keys = source.hand_out(&built.plan, &built.out, &names, false)?;
    if let Some(keys) = &keys {
        for image in built.participants.iter().filter(|participant| participant.artifact != Artifact::Host) {
            let (federate, has_rti) = match image.role {
                Role::Rti => (None, true),
                Role::Federate { joint_rti, .. } => (Some(image.name.as_str()), joint_rti),
            };
            keys.write_header(&image.name, federate, has_rti.then_some(&rti))?;
        }
    }
    if let Some(HandedOut { strangers, .. }) = &keys
        && !strangers.is_empty()
    {
        terminal::report(format_args!("warning: nobody trusts {}, which has no key", strangers.join(", ")));
    }
    Ok(keys)
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

/// Returns a description of the results for other programs, such as the west commands. Paths are absolute.
///
/// # Errors
/// When there are no options for the keys.
fn description(built: &Built, keys: Option<&HandedOut>) -> Result<Value, Failure> {
    let options = |name: &str| keys.map_or_else(|| Ok(Vec::new()), |keys| keys.options(name, true));
    let options = |name: &str| -> Result<Vec<String>, Failure> {
        Ok(options(name)?.iter().map(|word| word.to_string_lossy().into_owned()).collect())
    };
    let mut rti_options = match built.rti.home {
        RtiHome::Program => options(&rti_name(&built.plan))?,
        RtiHome::Image(_) | RtiHome::Joint(_) => Vec::new(),
    };
    rti_options.extend(options_for(&built.plan, true));
    let rti = built.plan.rti.as_ref().map(|rti| {
        json!({ "host": built.rti.ip.map_or_else(|| rti.host.clone(), |ip| ip.to_string()),
            "port": built.rti.port.unwrap_or(rti.port), "federation_id": rti.federation_id,
            "federates": built.plan.federates.len(), "options": rti_options })
    });
    let participants: Vec<Value> = built
        .participants
        .iter()
        .map(|participant| -> Result<Value, Failure> {
            let mut value = json!({ "name": participant.name, "package": participant.package,
                "crate": path(&built.out.join(&participant.folder)) });
            match participant.role {
                Role::Rti => value["role"] = json!("rti"),
                Role::Federate { id, joint_rti } => {
                    value["role"] = json!("federate");
                    value["id"] = json!(id);
                    value["joint_rti"] = json!(joint_rti);
                    let planned = built.plan.federates.get(usize::from(id));
                    value["transient"] = json!(planned.is_some_and(|federate| federate.transient));
                    value["restarts"] = json!(built.restarting.contains(&participant.name));
                }
            }
            match &participant.artifact {
                Artifact::Host => {
                    value["platform"] = json!("host");
                    value["program"] = json!(built.programs.get(&participant.name).map(|program| path(program)));
                    value["options"] = json!(options(&participant.name)?);
                }
                Artifact::Zephyr { board, kconfig, overlay, place, spare } => {
                    value["platform"] = json!("zephyr");
                    value["board"] = json!(board);
                    value["kconfig"] = json!(path(&built.out.join(kconfig)));
                    value["overlay"] = json!(path(&built.out.join(overlay)));
                    add_place(&mut value, place);
                    value["spare"] = json!(spare.as_ref().zip(place.spare.as_deref()).map(|(files, place)| {
                        json!({ "kconfig": path(&built.out.join(&files.kconfig)),
                            "overlay": path(&built.out.join(&files.overlay)), "network": network(place),
                            "probe": place.probe })
                    }));
                }
            }
            Ok(value)
        })
        .collect::<Result<_, _>>()?;
    Ok(json!({ "program": built.plan.name, "out": path(&built.out), "rti": rti, "participants": participants }))
}

fn add_place(value: &mut Value, place: &Place) {
    value["network"] = network(place);
    value["runner"] = json!(place.runner);
    value["probe"] = json!(place.probe);
}

fn network(place: &Place) -> Value {
    json!(place.network.map(|network| {
        json!({ "ip": network.ip.to_string(), "prefix": network.prefix_bits,
            "gateway": network.gateway.map(|gateway| gateway.to_string()),
            "mac": place.mac.map(|mac| mac.to_string()) })
    }))
}

fn path(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use serde_json::{Value, json};

    use super::description;
    use crate::args::{Places, Platform};
    use crate::compile::Request;

    const TEXT: &str = "\
target Rust {
  clock-sync: init,
  clock-sync-options: { trials: 7 },
  auth: true
}
reactor Silent {
}
federated reactor at example.com:4242 {
  first = new Silent()
  second = new Silent()
}
";

    /// Writes the description of a program for a board, in a folder.
    fn described(folder: &Path, text: &str, deployment: Option<&Path>) -> Value {
        described_for(folder, text, Some("some_board"), deployment)
    }

    fn described_for(folder: &Path, text: &str, board: Option<&str>, deployment: Option<&Path>) -> Value {
        let file = folder.join("Pair.lf");
        fs::write(&file, text).expect("it can be written");
        let places = Places { out: Some(folder.join("out")), ..Places::default() };
        let platform = Some(Platform::Zephyr);
        let request = Request { platform, board, deployment, ..Request::new(&file, &places) };
        let built = request.build().expect("crates for Zephyr are generated and not compiled");
        description(&built, None).expect("there are no keys")
    }

    /// The west commands refuse a description without the parts that they read.
    #[test]
    fn the_west_commands_find_what_they_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let value = described(folder.path(), TEXT, None);
        let out = folder.path().join("out");
        assert_eq!(value["program"], "Pair");
        assert_eq!(value["out"], json!(out));
        assert_eq!(
            value["rti"],
            json!({ "host": "example.com", "port": 4242, "federation_id": "Pair",
                "federates": 2, "options": ["--number_of_federates", "2", "--auth",
                    "--clock_sync", "init", "exchanges-per-interval", "7"] })
        );
        let first = &value["participants"][0];
        assert_eq!((&first["id"], &first["name"]), (&json!(0), &json!("first")));
        assert_eq!((&first["role"], &first["joint_rti"]), (&json!("federate"), &json!(false)));
        assert_eq!((&first["platform"], &first["board"]), (&json!("zephyr"), &json!("some_board")));
        assert_eq!(first["crate"], json!(out.join("first")));
        for file in ["kconfig", "overlay"] {
            let path = first[file].as_str().expect("it is a path");
            assert!(Path::new(path).is_file(), "{path}");
        }
        assert!(out.join("first/Cargo.toml").is_file());
        assert_eq!(value["participants"][1]["name"], "second");
    }

    #[test]
    fn the_rti_is_told_what_the_program_asks_of_it() {
        let options_of = |target: &str| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let text = TEXT.replace("clock-sync: init,", target).replace("  auth: true\n", "");
            let options = described(folder.path(), &text, None)["rti"]["options"].take();
            options
                .as_array()
                .expect("a list")
                .iter()
                .skip(2)
                .map(|word| word.as_str().expect("words").to_owned())
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(options_of("clock-sync: off,"), "--clock_sync off");
        let on = "--clock_sync on period 5000000 exchanges-per-interval 7";
        assert_eq!(options_of("clock-sync: on,"), on);
        let dnet = options_of("clock-sync: on, DNET: false,");
        assert_eq!(dnet, format!("--dnet_disabled {on}"));
        let waits = options_of("clock-sync: on, coordination-options: { log-waits: 500 ms },");
        assert_eq!(waits, format!("--log-waits 500000000 ns {on}"));
    }

    /// The images of a federate and of its spare board differ in their addresses only.
    #[test]
    fn a_spare_board_has_settings_of_its_own() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let deployment = folder.path().join("deployment.yaml");
        let places = "rti: { ip: 10.0.0.1 }\nfederates:\n  \
            first: { platform: qemu_cortex_m3, ip: 10.0.0.2, spare: { ip: 10.0.0.12, probe: B2 } }\n  \
            second: { platform: qemu_cortex_m3, ip: 10.0.0.3 }\n";
        fs::write(&deployment, places).expect("it can be written");
        let text = TEXT.replace("  first =", "  @transient\n  first =");
        let value = described_for(folder.path(), &text, None, Some(&deployment));
        let participants = &value["participants"];
        assert_eq!(participants[1]["spare"], json!(null));
        let (first, spare) = (&participants[0], &participants[0]["spare"]);
        assert_eq!(
            spare["network"],
            json!({ "ip": "10.0.0.12", "prefix": 24, "gateway": null,
            "mac": "02:00:0a:00:00:0c" })
        );
        assert_eq!((&first["probe"], &spare["probe"]), (&json!(null), &json!("B2")));
        let lines = |value: &Value| {
            let text = fs::read_to_string(value["kconfig"].as_str().expect("it is a path")).expect("it is there");
            text.lines().map(str::to_owned).collect::<Vec<_>>()
        };
        let differing: Vec<String> = lines(spare).into_iter().filter(|line| !lines(first).contains(line)).collect();
        assert_eq!(differing, ["CONFIG_NET_CONFIG_MY_IPV4_ADDR=\"10.0.0.12\""]);
    }

    /// The command line takes precedence, then the program, then the board that every computer can build for.
    #[test]
    fn the_program_may_name_its_board() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let named =
            TEXT.replace("clock-sync: init,", "clock-sync: init, platform: { name: \"Zephyr\", board: \"plank\" },");
        let board_of = |text: &str, board: Option<&str>| {
            described_for(folder.path(), text, board, None)["participants"][0]["board"].take()
        };
        assert_eq!(board_of(&named, Some("beam")), json!("beam"));
        assert_eq!(board_of(&named, None), json!("plank"));
        assert_eq!(board_of(TEXT, None), json!("native_sim/native/64"));
    }

    #[test]
    fn a_deployment_decides_where_the_rti_is() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let deployment = folder.path().join("deployment.yaml");
        let text = "rti: { ip: 10.0.0.1, port: 15099 }\n\
                    federates:\n  first: { platform: some_board, ip: 10.0.0.2, runner: pyocd, probe: a1 }\n";
        fs::write(&deployment, text).expect("it can be written");
        let value = described(folder.path(), TEXT, Some(&deployment));
        assert_eq!((&value["rti"]["host"], &value["rti"]["port"]), (&json!("10.0.0.1"), &json!(15099)));
        let participants = value["participants"].as_array().expect("it is a list");
        assert_eq!(participants.len(), 1, "the other federate is for this computer");
        let network = json!({ "ip": "10.0.0.2", "prefix": 24, "gateway": null, "mac": null });
        assert_eq!(participants[0]["network"], network);
        assert_eq!((&participants[0]["runner"], &participants[0]["probe"]), (&json!("pyocd"), &json!("a1")));
    }

    #[test]
    fn an_rti_in_an_image_is_a_participant_or_part_of_one() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let deployment = folder.path().join("deployment.yaml");
        let participants_of = |text: &str| {
            fs::write(&deployment, text).expect("it can be written");
            let value = described(folder.path(), TEXT, Some(&deployment));
            (value["participants"].as_array().expect("it is a list").clone(), value["rti"]["host"].clone())
        };
        let (alone, host) = participants_of("rti: { platform: some_board, ip: 10.0.0.9, probe: a1 }\n");
        assert_eq!((alone.len(), host), (1, json!("10.0.0.9")));
        let rti = &alone[0];
        assert_eq!((&rti["role"], &rti["name"], &rti["id"]), (&json!("rti"), &json!("rti"), &Value::Null));
        assert_eq!((&rti["network"]["ip"], &rti["probe"]), (&json!("10.0.0.9"), &json!("a1")));
        assert!(folder.path().join("out/rti/src/rti.rs").is_file());
        let (joint, host) =
            participants_of("federates:\n  second: { platform: some_board, ip: 10.0.0.2, joint-rti: true }\n");
        assert_eq!((joint.len(), host), (1, json!("10.0.0.2")));
        assert_eq!((&joint[0]["name"], &joint[0]["joint_rti"]), (&json!("second"), &json!(true)));
    }

    #[test]
    fn a_program_without_federates_has_no_rti() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let value = described(folder.path(), "target Rust\nmain reactor {\n}\n", None);
        assert_eq!(value["rti"], Value::Null);
        assert_eq!(value["participants"][0]["name"], "Pair");
    }
}
