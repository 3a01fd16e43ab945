"""`farhand setup`: all steps in order; what an earlier run has done is kept where the person agrees."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from common.cameras.camera import Camera
from common.cameras.settings import CameraSettings, given
from common.cameras.shown_source import shown_source
from common.config.loading import load_config
from common.errors import CameraError, InterruptionError, ModelError
from farhand.deployment.schemas import add_schema
from farhand.doctor.findings import Severity, as_text, worst
from farhand.outputs import make_folder, write_result
from farhand.setup.board_page import BOARD, PAPERS, RULER_MM, board_page
from farhand.setup.calibrating import BarMaker, calibrate
from farhand.setup.camera_modes import ListModes, choose_settings
from farhand.setup.configuration import configuration, has_sides, offered_methods
from farhand.setup.conversation import SetupPerson, ask_number, choose, confirm
from farhand.setup.finding_cameras import OpenCamera, choose_cameras, try_cameras
from farhand.setup.notes import NAMES, SetupAnswers, SetupFolder
from farhand.setup.pdf import pdf_of
from farhand.setup.trial import TrackerTrial, judge_trial, run_trial
from farhand.tracking.track_run import prepare_tracker
from local_site.acquisition.pairing import PairingConfig
from local_site.calibration.rig_file import load_rig
from local_site.config import LocalConfig
from local_site.tracking.choice import make_tracker
from local_site.tracking.registry import tracker_kind
from local_site.tracking.tracker import Views

TRIAL_S = 10.0
ARMS = {"right": "the right arm", "left": "the left arm"}
ViewsFor = Callable[[Sequence[Camera], PairingConfig, float], Iterator[Views]]  # cameras, pairing, seconds


@dataclass(frozen=True, slots=True)
class Tools:
    """The access of a setup to cameras: their sources, the modes of one, one opened, the views of several; its bar."""

    find: Callable[[], Sequence[str]]
    modes: ListModes
    open: OpenCamera
    views: ViewsFor
    progress: BarMaker


def set_up(path: Path, person: SetupPerson, tools: Tools) -> None:
    """Lead a person through all steps, with everything in a folder; InterruptionError when left, with all kept."""
    make_folder("--out", path)
    folder = SetupFolder(path)
    try:
        for step in (_cameras, _modes, _board, _calibration, _tracker):
            folder.keep(step(folder, folder.answers(), person, tools))
        _write_configuration(folder, person)
        _trial(folder, person, tools)
    except KeyboardInterrupt as error:
        raise InterruptionError(f"stopped; go on with: farhand setup --out {path}") from error
    person.tell(f"the setup is done; check the configuration with: farhand doctor --config {folder.configuration}")
    person.tell(f"start the local site with: farhand local --config {folder.configuration}")


def _keeps(person: SetupPerson, what: str) -> bool:
    return confirm(person, f"Keep {what}?", True)


def _cameras(folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, tools: Tools) -> SetupAnswers:
    kept = ", ".join(f"{name} {shown_source(source)}" for name, source in answers.sources.items())
    if kept and _keeps(person, f"the cameras, {kept}"):
        return answers
    pictures = try_cameras(tools.find(), tools.open, person)
    left, right = choose_cameras(pictures, folder.thumbnails, person)
    return replace(answers, left=left, right=right, cameras=None)


def _modes(_folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, tools: Tools) -> SetupAnswers:
    settings = answers.cameras
    if settings is not None and _keeps(person, f"the pictures, {_describe(settings)}"):
        return answers
    return replace(answers, cameras=choose_settings(answers.sources, tools.modes, tools.open, person))


def _describe(settings: CameraSettings) -> str:
    return ", ".join(f"{key} {value}" for key, value in given(settings).items())


def _board(folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, _tools: Tools) -> SetupAnswers:
    if answers.square_mm is not None and _keeps(person, f"the printed board with squares of {answers.square_mm:g} mm"):
        return answers
    paper = choose(person, "Which paper?", dict.fromkeys(PAPERS, "landscape"), next(iter(PAPERS)))
    write_result(folder.board, pdf_of(board_page(BOARD, PAPERS[paper])))
    person.tell(f"print {folder.board} at 100 % (not fitted to the page), and glue it on something flat and stiff")
    ruler = ask_number(person, "How long is its ruler of 100 mm on the print, in mm?", RULER_MM, 50, 200)
    return replace(answers, square_mm=1000 * BOARD.square * ruler / RULER_MM)


def _calibration(folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, tools: Tools) -> SetupAnswers:
    if folder.rig.exists() and answers.rig_by != answers.rig_needs:
        person.tell(f"{folder.rig} was made with other cameras, another size or another board: calibrate again")
    elif folder.rig.exists() and _keeps(person, f"the calibration {folder.rig}"):
        return answers
    return calibrate(folder, answers, person, tools.open, tools.progress)


def _tracker(_folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, _tools: Tools) -> SetupAnswers:
    if answers.method is not None and _keeps(person, f"the tracker {answers.method}"):
        return answers
    offered = offered_methods()
    method = choose(person, "How is the arm tracked?", offered, next(iter(offered)))
    right_arm = not has_sides(method) or choose(person, "Which arm?", ARMS, "right") == "right"
    return replace(answers, method=method, right_arm=right_arm)


def _write_configuration(folder: SetupFolder, person: SetupPerson) -> None:
    """Write the configuration; one that says something else, as after an edit, is kept or put aside as asked."""
    path = folder.configuration
    text = configuration(folder.answers(), folder.rig, path).encode()
    if path.exists() and path.read_bytes() != text:
        if confirm(
            person, f"{path} differs from these answers. Keep it (else it is put aside as local.toml.old)?", False
        ):
            return
        folder.put_configuration_aside()
    folder.configure(text)
    add_schema(LocalConfig, path)
    person.tell(f"the configuration is in {path}")


def _trial(folder: SetupFolder, person: SetupPerson, tools: Tools) -> None:
    """Try what the configuration says, as the local site would, until the person is content."""
    proposed = True
    while confirm(person, f"Try the tracker for {TRIAL_S:.0f} seconds, the bent arm before both cameras?", proposed):
        config = load_config(LocalConfig, folder.configuration)
        prepare_tracker(config.tracking)
        scene = tracker_kind(config.tracking.method).scene
        if scene == "room":
            person.tell("keep the arm out of both pictures for the first second, then hold it bent before the cameras")
        try:
            findings = judge_trial(_try_tracker(config, tools), scene == "dark")
        except (CameraError, ModelError) as error:
            person.tell(str(error))
            continue
        for line in as_text(findings).splitlines():
            person.tell(line)
        proposed = worst(findings) is not Severity.OK


def _try_tracker(config: LocalConfig, tools: Tools) -> TrackerTrial:
    """A trial of the configured tracker with the configured cameras."""
    operator, rig = config.operator, load_rig(Path(config.operator.rig))
    settings = operator.settings_of(NAMES)
    tracker = make_tracker(rig, config.tracking)
    with ExitStack() as opened:
        sources = zip(NAMES, operator.sources, strict=True)
        cameras = [opened.enter_context(closing(tools.open(str(s), n, settings[n]))) for n, s in sources]
        return run_trial(rig, tracker, tools.views(cameras, config.capture, TRIAL_S))
