// SPDX-License-Identifier: Apache-2.0
//! The pipeline from a program to executables: reading it, choosing folders, writing files, running cargo, and
//! converting rustc's messages.

mod cargo;
mod clean;
mod console;
mod files;
mod hints;
mod linker;
mod lock;
mod messages;
mod native;
mod origin;
mod places;
mod progress;
mod readable;
mod resolution;
mod runtime;
mod rustc;
mod scopes;
mod source;
mod store;
mod stored;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use lf_compiler::deployment::{Deployment, Place, Platform as PlacePlatform, RtiHome, RtiPlace};
use lf_compiler::emit::{Artifact, Emitted, Participant, Settings, emit, rti_name};
use lf_compiler::plan::Plan;

pub(crate) use cargo::cargo_program;
pub(crate) use clean::{clean_all, clean_program};
pub(crate) use console::Console;
pub(crate) use places::{application, home};
pub(crate) use readable::ReadableCode;
pub(crate) use source::{Files, Program, STANDARD_INPUT, compile, compile_input, count, read_text, standard_input};
pub(crate) use store::Freed;
pub(crate) use stored::{explain, name_lf_lines};

use crate::args::{Places, Platform};
use crate::debug_info::{self, Generated};
use crate::failure::Failure;
use crate::terminal;
use cargo::Job;
use lock::Lock;
use origin::LfOrigin;
use places::{Folders, current, named_by, text_of};
use progress::Progress;
use runtime::Runtime;

/// The board of federates without a named one: a Linux program, which every computer can build.
const BOARD_DEFAULT: &str = "native_sim/native/64";

/// The folder of keys: of a federation beside the program's `src`, and of its participants in a build folder.
pub(crate) const KEYS: &str = "keys";

/// The program to build, and the options.
pub(crate) struct Request<'a> {
    /// The main file.
    pub(crate) file: &'a Path,
    /// The only platform to build for, if not all.
    pub(crate) platform: Option<Platform>,
    /// The board of all federates without a deployment; `None` leaves it to the program, and to [`BOARD_DEFAULT`].
    pub(crate) board: Option<&'a str>,
    /// The federates, and an RTI that is an image of its own; all when it is empty.
    pub(crate) federates: &'a [String],
    /// The deployment file.
    pub(crate) deployment: Option<&'a Path>,
    /// Folders and profile.
    pub(crate) places: &'a Places,
    /// Whether rustc only checks the programs for this computer.
    pub(crate) checks_only: bool,
    /// Whether a program runs meanwhile, whose output a moving line would disturb.
    pub(crate) is_beside_run: bool,
}

/// The results of a build.
#[derive(Debug)]
pub(crate) struct Built {
    /// The plan of the whole program.
    pub(crate) plan: Plan,
    /// The place of the RTI in the deployment.
    pub(crate) rti: RtiPlace,
    /// The folder with the generated files.
    pub(crate) out: PathBuf,
    /// The requested participants: an RTI that is an image of its own, then federates in order of id.
    pub(crate) participants: Vec<Participant>,
    /// The executables of those for this computer, by federate.
    pub(crate) programs: BTreeMap<String, PathBuf>,
    /// The programs for this computer that are started again when they have failed.
    pub(crate) restarting: BTreeSet<String>,
    /// The number of errors and warnings that the compiler had for the program, rustc's not included.
    pub(crate) counts: (usize, usize),
}

impl<'a> Request<'a> {
    /// Returns a request for all participants, with the program's settings.
    pub(crate) fn new(file: &'a Path, places: &'a Places) -> Self {
        Self {
            file,
            platform: None,
            board: None,
            federates: &[],
            deployment: None,
            places,
            checks_only: false,
            is_beside_run: false,
        }
    }

    /// Generates the requested participants and compiles those for this computer.
    ///
    /// # Errors
    /// When the program, the deployment or the generated code is wrong.
    pub(crate) fn build(&self) -> Result<Built, Failure> {
        let program = Program::load(self.file)?;
        let deployment = self.deployment(&program.plan)?;
        let wanted = self.wanted(&program.plan, &deployment)?;
        let is_image = |name: &&String| !is_on_host(name, &program.plan, &deployment);
        if program.plan.target.security.is_tls()
            && let Some(name) = wanted.iter().find(is_image)
        {
            return Err(Failure::message(format!(
                "{name} is on a board, which has no TLS: write `security: noise` instead of `comm-type: TLS`, for \
                 programs of Linux, too"
            )));
        }
        let platform = if wanted.iter().all(|name| is_on_host(name, &program.plan, &deployment)) {
            Platform::Host
        } else {
            Platform::Zephyr
        };
        let folders = Folders::new(self.file, &program.plan.name, platform, self.places)?;
        let emitted = generate(self.file, &program, &deployment, &folders)?;
        let participants: Vec<Participant> =
            emitted.participants.iter().filter(|participant| wanted.contains(&participant.name)).cloned().collect();
        let programs = self.compile(&program, &emitted, &participants, &folders)?;
        crate::trace::write_names(&program.plan, &folders.out)?;
        let counts = program.diagnostics.counts();
        let restarts = |name: &&String| is_on_host(name, &program.plan, &deployment) && deployment.place(name).restarts;
        let restarting = deployment.federates.keys().filter(restarts).cloned().collect();
        let (rti, out) = (deployment.rti, folders.out);
        Ok(Built { counts, plan: program.plan, rti, out, participants, programs, restarting })
    }

    /// Returns the places of the federates.
    fn deployment(&self, plan: &Plan) -> Result<Deployment, Failure> {
        let mut deployment = match self.deployment {
            None => Deployment::default(),
            Some(path) => read_deployment(path, plan)?,
        };
        if self.platform == Some(Platform::Zephyr) && self.deployment.is_none() {
            let board = self.board.or(plan.target.board.as_deref()).unwrap_or(BOARD_DEFAULT);
            for federate in &plan.federates {
                let platform = PlacePlatform::Zephyr(board.to_owned());
                deployment.federates.insert(federate.name.clone(), Place { platform, ..Place::default() });
            }
        }
        Ok(deployment)
    }

    /// Returns the names of the requested participants.
    fn wanted(&self, plan: &Plan, deployment: &Deployment) -> Result<Vec<String>, Failure> {
        let image = plan.rti.is_some() && matches!(deployment.rti.home, RtiHome::Image(_));
        let rti = image.then(|| rti_name(plan));
        let all = || rti.iter().cloned().chain(plan.federates.iter().map(|federate| federate.name.clone()));
        if let Some(unknown) = self.federates.iter().find(|name| !all().any(|known| known == **name)) {
            let known = all().collect::<Vec<_>>().join(", ");
            return Err(Failure::message(format!("there is no federate `{unknown}`; {} has {known}", plan.name)));
        }
        let is_wanted = |name: &String| {
            let is_host = is_on_host(name, plan, deployment);
            (self.federates.is_empty() || self.federates.contains(name))
                && self.platform.is_none_or(|platform| is_host == (platform == Platform::Host))
        };
        let wanted: Vec<String> = all().filter(is_wanted).collect();
        if wanted.is_empty() {
            return Err(Failure::message(
                "the deployment has no federate on this platform, so there is nothing to build",
            ));
        }
        Ok(wanted)
    }

    /// Returns the profile of programs for this computer: the program's, unless optimization is requested and that one
    /// does not optimize.
    fn profile(&self, plan: &Plan) -> &'static str {
        let build_type = plan.target.cargo.build_type;
        if self.places.release && !build_type.is_optimized() { "release" } else { build_type.profile() }
    }

    /// Compiles the participants for this computer.
    fn compile(
        &self,
        program: &Program,
        emitted: &Emitted,
        participants: &[Participant],
        folders: &Folders,
    ) -> Result<BTreeMap<String, PathBuf>, Failure> {
        let on_host: Vec<&Participant> =
            participants.iter().filter(|participant| participant.artifact == Artifact::Host).collect();
        if on_host.is_empty() {
            return Ok(BTreeMap::new());
        }
        let lock = Lock::of(self.file, &program.plan);
        lock.give(&folders.home.join("Cargo.lock"), &folders.out)?;
        let packages: Vec<String> = on_host.iter().map(|participant| participant.package.clone()).collect();
        let coloured = terminal::coloured();
        let build = folders.store.program(&folders.out)?;
        let job = Job {
            workspace: &folders.out,
            current: &folders.out,
            packages: &packages,
            target: &folders.target(),
            build: &build.folder,
            profile: self.profile(&program.plan),
            checks_only: self.checks_only,
            coloured,
        };
        let begun = if self.checks_only { ["Checking", "Checked"] } else { ["Compiling", "Compiled"] };
        let progress = Progress::begin(begun, &what(&program.plan, on_host.len()), !self.is_beside_run);
        let runtime = Runtime::of(&folders.out, &folders.home, &on_host)?;
        let compiled = folders.store.runtime(&runtime.needs())?;
        runtime.prepare(&folders.home, &compiled, &job, &progress)?;
        drop(compiled);
        let mut outcome = job.run(&progress)?;
        progress.end(outcome.success);
        outcome.diagnostics = linker::with_places(outcome.diagnostics, &program.plan);
        let origin = LfOrigin::new(program, emitted, &folders.out);
        if !outcome.success && !outcome.diagnostics.iter().any(rustc::Diagnostic::is_error) {
            outcome.diagnostics.extend(resolution::diagnostic(&outcome.log, &program.plan));
        }
        let shown = rustc::render_all(&outcome.diagnostics, &origin, coloured);
        terminal::report(&shown.text);
        if !outcome.success {
            let file = self.file.display();
            if shown.errors > 0 {
                terminal::report(format_args!("{file}: {}", count(shown.errors, shown.warnings)));
            } else {
                terminal::report(&outcome.log);
                terminal::report(format_args!("{file}: cargo has not been able to compile the generated code"));
                terminal::report(hint_of_folder(&folders.out));
            }
            return Err(Failure::Reported);
        }
        lock.keep(&folders.out, true);
        if self.checks_only {
            return Ok(BTreeMap::new());
        }
        let mut programs = BTreeMap::new();
        for participant in on_host {
            let executable = outcome.executables.get(&participant.package).ok_or_else(|| {
                Failure::message(format!("cargo has not said where the program of {} is", participant.name))
            })?;
            let generated = Generated { folder: &folders.out, map: &emitted.source_map, current: &origin.current };
            debug_info::name_lf_lines(executable, &generated)?;
            programs.insert(participant.name.clone(), executable.clone());
        }
        if program.plan.transients() > 0 {
            let links = programs.iter().map(|(name, executable)| (format!("federate__{name}"), executable.as_path()));
            files::link_all(&folders.out.join("bin"), links).map_err(|error| named_by("--out", &error))?;
        }
        Ok(programs)
    }
}

/// Returns the places of a program's federates that a file says.
///
/// # Errors
/// When the file cannot be read, or is wrong; the user has seen each error in it.
pub(crate) fn read_deployment(path: &Path, plan: &Plan) -> Result<Deployment, Failure> {
    let text = read_text(path).map_err(|error| Failure::message(format!("cannot read {}: {error}", path.display())))?;
    Deployment::parse(&path.display().to_string(), &text, plan).map_err(|errors| report(&errors))
}

/// Returns whether a federate is a program of this computer; a participant that is no federate is the image of the RTI.
fn is_on_host(name: &str, plan: &Plan, deployment: &Deployment) -> bool {
    let is_federate = plan.federates.iter().any(|federate| federate.name == name);
    is_federate && deployment.place(name).platform == PlacePlatform::Host
}

/// Generates the crates of all participants, for their folder.
fn emitted(plan: &Plan, deployment: &Deployment, folders: &Folders) -> Result<Emitted, Failure> {
    let crates = folders.home.join("rust");
    let crates = text_of(&crates)?;
    // Without a current folder, no path of the program begins there.
    let (version, current) = (folders.version(), current().unwrap_or_else(|_| PathBuf::from("/")));
    let current = text_of(&current)?;
    let keys = folders.out.join(KEYS);
    let keys = text_of(&keys)?;
    let settings = Settings { crates, version: &version, current, deployment, keys };
    emit(plan, &settings).map_err(|errors| report(&errors))
}

/// Writes the generated files; Zephyr's build compiles its crates itself, so their source maps and the
/// compiler's name lie beside them.
fn generate(file: &Path, program: &Program, deployment: &Deployment, folders: &Folders) -> Result<Emitted, Failure> {
    let emitted = emitted(&program.plan, deployment, folders)?;
    let images = || emitted.participants.iter().filter(|participant| participant.artifact != Artifact::Host);
    let maps = images().map(|participant| stored::file(program, &emitted, &participant.folder));
    let mut beside = maps.collect::<Result<Vec<_>, _>>()?;
    beside.extend(images().map(|participant| stored::compiler_file(&participant.folder)));
    let sources = emitted.files.iter().map(|file| (file.path.as_str(), file.text.as_str()));
    let all = sources.chain(beside.iter().map(|(path, text)| (path.as_str(), text.as_str())));
    files::write(&folders.out, all).map_err(|error| named_by("--out", &error))?;
    // Zephyr's build lets cargo complete these, so the next build sees the chosen versions.
    let lock = Lock::of(file, &program.plan);
    for participant in images() {
        let folder = folders.out.join(&participant.folder);
        lock.keep(&folder, false);
        lock.give_image(&folders.home.join("rust/zephyr/Cargo.lock"), &folder)?;
    }
    Ok(emitted)
}

/// Returns advice if cargo does not accept the folder's name.
fn hint_of_folder(out: &Path) -> String {
    // Cargo takes the paths of the packages in a workspace for patterns.
    let is_pattern = out.to_string_lossy().contains(['*', '?', '[']);
    let shown = out.display();
    let hint = format!("  hint: cargo may take the folder's name for a pattern, in {shown}; name another with --out");
    if is_pattern { hint } else { String::new() }
}

fn report(errors: &[impl std::fmt::Display]) -> Failure {
    for error in errors {
        terminal::report(error);
    }
    Failure::Reported
}

fn what(plan: &Plan, count: usize) -> String {
    match (plan.is_federated(), count) {
        (false, _) => plan.name.clone(),
        (true, 1) => format!("1 federate of {}", plan.name),
        (true, _) => format!("{count} federates of {}", plan.name),
    }
}
