# SPDX-License-Identifier: Apache-2.0
"""Building a program: the compiler first, then west for every image."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lf_west import compiler, description, messages, west_arguments
from lf_west.application import Application
from lf_west.description import Description, Participant
from lf_west.errors import LfError
from lf_west.image import Image, plan_image
from lf_west.jobs import Job, Jobs, Screen
from lf_west.memory import measure
from lf_west.summary import Row
from lf_west.west_arguments import WestArguments
from lf_west.workspace import REPOSITORY, Workspace


@dataclass(frozen=True)
class Surroundings:
    """The input of a build beside its arguments."""

    environment: Mapping[str, str]
    # West's configuration build.board.
    configured_board: str | None
    say: Callable[[str], None]


@dataclass(frozen=True)
class Request:
    """The user's choice of what to build."""

    application: Application
    west: WestArguments
    conf_overlays: Sequence[Path]
    cmake_arguments: Sequence[str]
    lfc: str | None
    generate: bool = True
    deployment: Path | None = None
    federates: Sequence[str] = ()

    def board(self, surroundings: Surroundings) -> str | None:
        """The board for all images: a deployment yields to -b only."""
        if self.deployment is not None:
            return self.west.board
        return west_arguments.chosen_board(self.west, surroundings.environment, surroundings.configured_board)


def generate(request: Request, surroundings: Surroundings) -> Description:
    """Let the compiler make the crates, or take those that it made before; the boards are those to build for."""
    application, file = request.application, request.application.description
    board = request.board(surroundings)
    if not request.generate:
        described = description.load(file)
        return described.with_board(request.west.board) if request.west.board else described
    lfz = compiler.find(request.lfc, surroundings.environment, surroundings.say)
    if request.deployment is None and board is None:
        board = lfz.planned_board(application.file)
        if board is None:
            raise LfError(f"there is no board to build {application.program} for.", *_board_advice(application))
    described = lfz.build(
        application.file,
        application.generated,
        deployment=request.deployment,
        board=board,
        federates=request.federates,
    )
    if board is not None:
        described = described.with_board(board)
    older = _built_before(file, surroundings) if request.federates else None
    kept = described if older is None else described.merged_over(older)
    kept.save(file)
    return described


def _built_before(file: Path, surroundings: Surroundings) -> Description | None:
    """Return the description of the federates that are not built this time. One by another version is out of date,
    as its images are."""
    if not file.is_file():
        return None
    try:
        return description.load(file)
    except LfError:
        surroundings.say(f"{file} is out of date: build the other federates, too, before all are run")
        return None


def images(request: Request, participants: Sequence[Participant], federated: bool, target: Path) -> list[Image]:
    """Return the builds of the images among the participants."""
    return [
        plan_image(
            request.application,
            participant,
            federated=federated,
            west=request.west,
            conf_overlays=request.conf_overlays,
            cmake_arguments=request.cmake_arguments,
            cargo_folder=target,
        )
        for participant in participants
        if participant.is_image
    ]


def report_messages(request: Request, planned: Sequence[Image], surroundings: Surroundings) -> None:
    """Show what rustc has said about the LF program when the images were built."""
    messages.report(planned, lambda: compiler.find(request.lfc, surroundings.environment, surroundings.say))


def cargo_folder(environment: Mapping[str, str]) -> Path:
    """Return cargo's folder for the common crates of all images, which it compiles once."""
    outer = environment.get("CARGO_TARGET_DIR")
    return (Path(outer).absolute() if outer else REPOSITORY / "target") / "lf-zephyr"


def environment(application: Application, workspace: Workspace, surroundings: Surroundings) -> dict[str, str]:
    """The environment in which images are built.

    It lets ccache, with which Zephyr compiles where it is installed, know all images of a board as the same: then what
    they have in common is compiled once. A user who has set it up already knows better.
    """
    variables = workspace.environment(surroundings.environment)
    if "CCACHE_BASEDIR" not in variables:
        variables |= {"CCACHE_BASEDIR": str(application.images), "CCACHE_NOHASHDIR": "true"}
    return variables


def build_images(
    planned: Sequence[Image],
    request: Request,
    workspace: Workspace,
    surroundings: Surroundings,
    parallel: int,
) -> None:
    """Build images at once; rustc's errors are shown, else an `LfError` has the end of the log of what failed."""
    application, jobs = request.application, []
    for image in planned:
        jobs.append(Job(image.name, image.command(), application.log(image.name), workspace.topdir))
        image.forget()
    variables = environment(application, workspace, surroundings)
    status = Jobs(variables, parallel, Screen(surroundings.say)).run(jobs)
    for image, job in zip(planned, jobs, strict=True):
        if job.status == 0:
            image.remember()
    failed = [(image, job) for image, job in zip(planned, jobs, strict=True) if job.status]
    if status != 0 and not failed:
        raise LfError("the build was interrupted.", status=status)
    report_messages(request, planned, surroundings)
    if status == 0:
        return
    # The messages of rustc have been shown already, and the log says less.
    logs = [job for image, job in failed if not messages.has_rust_errors(image)]
    tails = [line for job in logs for line in (f"---- end of {job.log}", *job.tail, "----")]
    raise LfError(
        "\n".join([*tails, f"{', '.join(job.name for _, job in failed)} could not be built."]),
        *(["Correct what rustc reports above."] if len(logs) < len(failed) else []),
        *(f"Read the whole log: {job.log}" for _, job in failed),
        *(['Make the build folder anew, if its settings are out of date: -w "-p always"'] if logs else []),
        *([f"Build one federate alone: -f {failed[0][1].name}"] if len(jobs) > 1 else []),
        status=status,
    )


def rows(participants: Sequence[Participant], planned: Sequence[Image]) -> list[Row]:
    """Return the results for the summary."""
    by_name = {image.name: image for image in planned}
    result = []
    for participant in participants:
        image = by_name.get(participant.name)
        if image is None:
            result.append(Row(participant.name, "host", None, participant.program))
        else:
            file = image.executable()
            result.append(Row(image.name, image.board, measure(image.folder), file if file.is_file() else None))
    return result


def _board_advice(application: Application) -> list[str]:
    again = ["Build again what was generated before: --no-lfc"] if application.description.is_file() else []
    return [
        *(f"Take a deployment of the application: --deployment {file}" for file in application.deployments()),
        *again,
        'Name a board for all images: -w "-b native_sim/native/64"',
        "Set BOARD in the environment, or `west config build.board BOARD`.",
        'Name it in the program: `target Rust { platform: {name: "Zephyr", board: "BOARD"} }`',
    ]
