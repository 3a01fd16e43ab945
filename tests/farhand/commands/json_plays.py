"""How each command comes to a result in a test: its arguments, and what stands in for a site, a camera or long work."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import tests.common.messages.golden_examples as golden
from common.recording.repair import Repaired
from farhand.calibration.latency.delay import Delay
from farhand.calibration.latency.measuring import CameraLatency
from farhand.calibration.points import Calibrated
from farhand.doctor.findings import warning
from farhand.export.lerobot.dataset_export import ExportSummary
from farhand.loopback.measured_run import run_figures
from farhand.loopback.plan import LoopbackOptions
from farhand.loopback.recorder import Record
from farhand.replay.verify import Difference, ReplayVerdict
from farhand.status.observed import Observed
from farhand.teach.writing import as_toml
from farhand.tracking.summary import Summary
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from remote_site.config import RemoteConfig
from remote_site.drivers.conformance.verdicts import Verdict
from tests.farhand.teach.example_task import TASK

REPLIED = "the arm follows \x1b[31mthe hand"  # of another site, with what a terminal would obey
ENGAGE, LEASE = "farhand.authority.engage.", "farhand.authority.lease."


def gives(result: Any) -> Callable[..., Any]:
    """A function that returns this, whatever it is given."""
    return lambda *_, **__: result


@dataclass(frozen=True)
class Play:
    """A command's arguments, what is put in place of what, commands before it, files, and how it ends."""

    arguments: Sequence[str] = ()
    instead: Mapping[str, Any] = field(default_factory=dict)
    before: Sequence[Sequence[str]] = ()
    prepare: Callable[[], object] = lambda: None
    code: int = 0


class _Watch:
    """A cell that is watched."""

    def __init__(self, *_: object) -> None:
        self.seen = Observed("tcp/127.0.0.1:7447", "cell")
        self.seen.take_state(golden.STATE, 0)
        self.seen.expect(["front_high"])

    def measure(self, *, pictures: bool) -> None:
        """Nothing changes."""


class _Loop:
    """A loopback of which nothing came."""

    operator_views = ()
    failure = None

    def __init__(self, options: LoopbackOptions, *_: object) -> None:
        self._record = options.record
        self.record = Record()

    def run(self) -> dict[str, Any]:
        """The figures of nothing."""
        operator = SimpleNamespace(truth=dict, openings=gives(0))
        figures: dict[str, Any] = run_figures(self.record, operator, RemoteConfig(), [])  # type: ignore[arg-type]
        return figures | {"too_slow": None, "slow_views": None}


@contextmanager
def _no_sessions(_: object) -> Any:
    yield []


def _asks(function: str) -> Play:
    return Play(instead={function: gives(REPLIED)})


def _tells_beforehand(function: str, place: int) -> Play:
    """The function gets at this place what tells a person something before the result."""

    def replied(*given: Any) -> str:
        given[place]("to reset: fault")
        return REPLIED

    return Play(instead={function: replied})


def _rig_of(*arguments: str, made_by: str) -> Play:
    made = Calibrated(exact_rig(SimulationConfig().stereo), Path("rig.json"), ("few points",))
    return Play(arguments, {made_by: gives(made)})


def _task() -> None:
    Path("task.toml").write_text(as_toml(TASK))


CREATED = [["certificates", "create", "lab"]]
MAINTENANCE = ENGAGE + "request_maintenance"
RECORDED = _asks("farhand.authority.record.request_record")
LATENCY = CameraLatency("left", 40.0, 2.0, 16.7, False, Delay(40.0, 2.0, 0.99, 90.0, 30.0, 34.0))
ENDS = "farhand.calibration.latency.measuring."
VERIFY = "farhand.replay."
EXPORTS = {"farhand.export.recording.open_sessions": _no_sessions}
PLAYS: dict[str, Play] = {
    "engage": _asks(ENGAGE + "request_engage"),
    "disengage": _asks(ENGAGE + "request_disengage"),
    "stop": _asks(ENGAGE + "request_stop"),
    "reset": _tells_beforehand(ENGAGE + "request_reset", 3),
    "maintenance stop": _asks(MAINTENANCE),
    "maintenance reset": _tells_beforehand(MAINTENANCE, 3),
    "lease show": Play(instead={LEASE + "seen_state": gives(golden.STATE)}),
    "lease take": _tells_beforehand(LEASE + "take_lease", 3),
    "lease give": Play(["ben"], {LEASE + "find_asker": gives(None), LEASE + "act_on_lease": gives(REPLIED)}),
    "lease release": _asks(LEASE + "act_on_lease"),
    "record start": RECORDED,
    "record stop": RECORDED,
    "episode begin": RECORDED,
    "episode end": RECORDED,
    "episode label": RECORDED,
    "status": Play(instead={"farhand.status.watch.StatusWatch": _Watch, "farhand.status.watch.OVER_NS": 0}),
    "loopback": Play(instead={"farhand.loopback.measured_run.Loopback": _Loop}, code=1),
    "track": Play(
        ["--rig", "rig.json", "--left", "a", "--right", "b"], {"farhand.tracking.track_run.run_track": gives(Summary())}
    ),
    "replay": Play(
        ["a.mcap", "--verify"],
        {
            VERIFY + "recorded_cycles.recorded_pipeline": gives(None),
            VERIFY + "recorded_cycles.recorded_cycles": gives(()),
            VERIFY + "recorded_cycles.cycle_count": gives(1),
            VERIFY + "recorded_cycles.other_release": gives(""),
            VERIFY + "verify.verify": gives(ReplayVerdict(3, 0.1, Difference(2, 0.004, "the gripper"))),
        },
        code=1,
    ),
    "record repair": Play(["a.mcap"], {"common.recording.repair.repair": gives(Repaired(False, 7, 1.5, 12))}),
    "export lerobot": Play(
        ["a.mcap", "--out", "dataset"],
        EXPORTS | {"farhand.export.lerobot.dataset_export.export_lerobot": gives(ExportSummary(1, 20, 20, ("b",)))},
    ),
    "export csv": Play(
        ["a.mcap", "--out", "tables"], EXPORTS | {"farhand.export.tables.export_csv": gives([Path("a.csv")])}
    ),
    "export mp4": Play(
        ["a.mcap", "--out", "videos"], EXPORTS | {"farhand.export.videos.write.export_mp4": gives([Path("a.mp4")])}
    ),
    "teach extract": Play(["a.mcap", "--out", "task.toml"], {"farhand.teach.extraction.extracted": gives(TASK)}),
    "teach show": Play(["task.toml"], prepare=_task),
    "experiment": Play(
        ["follow", "--out", "build"], {"lab.experiments.run.run_experiment": gives("4 mm\nwritten to build")}
    ),
    "calibrate points": _rig_of("points.csv", made_by="farhand.calibration.points.calibrate_points"),
    "calibrate images": _rig_of("--left", "l", "--right", "r", made_by="farhand.calibration.pictures.calibrate_plate"),
    "calibrate live": _rig_of("--left", "0", "--right", "2", made_by="farhand.calibration.boards.calibrate_live"),
    "calibrate latency": Play(
        ["--left", "0"],
        {
            ENDS + "open_for_latency": gives([]),
            ENDS + "watch_screen": gives((None, {})),
            ENDS + "measure": gives(([LATENCY], [])),
        },
    ),
    "doctor": Play(instead={"farhand.doctor.examination.examine": gives([warning("disk", "full", "free some")])}),
    "limits": Play(),
    "driver list": Play(),
    "tracker list": Play(),
    "driver test": Play(
        ["kinematic"], {"remote_site.runtime.conformance.test_driver": gives({"rests": Verdict.REPEAT})}, code=3
    ),
    "driver new": Play(["my_arm"]),
    "arm import": Play(["arm.urdf"], {"farhand.arm_import.import_arm.import_arm": gives(["imported: arm.urdf"])}),
    "config show": Play(["remote"]),
    "config init": Play(["sites"]),
    "config check": Play(["absent.toml"], code=1),
    "config schema": Play(),
    "certificates create": Play(["lab"]),
    "certificates operator": Play(["lab", "ben"], before=CREATED),
    "certificates router": Play(["lab"], before=CREATED),
    "certificates renew": Play(["lab"], before=CREATED),
    "models install": Play(instead={"farhand.models.install.install": lambda _folder, _wheel, say: say("getting ...")}),
}
