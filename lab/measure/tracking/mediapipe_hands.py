"""MediaPipe Hands beside our trackers: in an environment of its own, asked through a pipe, triangulated by our rig."""

import json
import os
import select
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Self

import msgspec
import numpy as np

from common.geometry import Array
from lab.measure.tracking.figures import Found
from lab.stage.processes import PIP, UnavailableError, run_quietly
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import triangulate
from local_site.tracking.tracker import Views

VERSION = "0.10.21"
ENVIRONMENT = Path("build") / "mediapipe"
# MediaPipe asks for JAX too, which its hands do not need and which takes long to resolve and hundreds of megabytes.
ALONE = (f"mediapipe=={VERSION}",)
NEEDED = (
    "absl-py",
    "attrs",
    "flatbuffers",
    "matplotlib",
    "numpy==1.26.4",
    "opencv-python-headless<4.12",
    "protobuf>=4.25.3,<5",
)
INSTALL = ("-I", *PIP, "--retries", "1", "--timeout", "15")
INSTALL_S = 300.0
ANSWER_S = 60.0
LANDMARKS = {"wrist": 0, "thumb": 4, "index": 8}

Hand = tuple[tuple[float, float], ...]


class _Answer(msgspec.Struct, frozen=True):
    wall_ms: float
    processor_ms: float
    hands: tuple[Hand | None, ...]


def install(environment: Path = ENVIRONMENT) -> Path:
    """The Python of an environment with MediaPipe, made once; UnavailableError states why not."""
    python, ready = environment / "bin/python", environment / f"ready-{VERSION}"
    if not ready.exists():
        shutil.rmtree(environment, ignore_errors=True)
        for command in (
            [sys.executable, "-m", "venv", str(environment)],
            [str(python), *INSTALL, "--no-deps", *ALONE],
            [str(python), *INSTALL, *NEEDED],
            [str(python), "-I", "-c", "import mediapipe"],
        ):
            run_quietly(command, INSTALL_S, _variables(environment))
        ready.touch()
    return python


def _variables(environment: Path) -> dict[str, str]:
    """Quiet logs, and nothing written outside the environment."""
    return {**os.environ, "GLOG_minloglevel": "2", "MPLCONFIGDIR": str((environment / "matplotlib").resolve())}


class MediaPipeHands:
    """The child process; use it as a context."""

    name = "MediaPipe Hands"
    needed = ("wrist", "index")

    def __init__(self, python: Path, environment: Path = ENVIRONMENT) -> None:
        self._log = (environment / "child.log").open("wb")
        self._child = subprocess.Popen(  # noqa: S603 - our own script
            [str(python), "-I", str(Path(__file__).with_name("mediapipe_child.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=_variables(environment),
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()
        self._child.communicate()
        self._log.close()

    def track(self, scene: str, rig: Rig, views: Views) -> Found:
        """Wrist, index and thumb of one pair, where both views show a hand; UnavailableError when the child is gone."""
        pictures = [view.current.image for view in views.views]
        header = json.dumps({"scene": scene, "shapes": [picture.shape for picture in pictures]}).encode() + b"\n"
        answer = self._ask(header + b"".join(picture.tobytes() for picture in pictures))
        sizes = [(picture.shape[1], picture.shape[0]) for picture in pictures]
        points = triangulate_landmarks(rig, answer.hands, sizes)
        return Found(points, answer.wall_ms, answer.processor_ms, covariances={})

    def _ask(self, request: bytes) -> _Answer:
        to_child, from_child = self._child.stdin, self._child.stdout
        if to_child is None or from_child is None:
            raise UnavailableError("the child has no pipes")
        try:
            to_child.write(request)
            to_child.flush()
        except BrokenPipeError as error:
            raise UnavailableError(f"the child ended, see {self._log.name}") from error
        if not select.select([from_child], [], [], ANSWER_S)[0]:
            raise UnavailableError(f"no answer within {ANSWER_S:.0f} s")
        line = from_child.readline()
        if not line:
            raise UnavailableError(f"the child ended, see {self._log.name}")
        return msgspec.json.decode(line, type=_Answer)


def triangulate_landmarks(rig: Rig, hands: Sequence[Hand | None], sizes: Sequence[tuple[int, int]]) -> dict[str, Array]:
    """Points (3,) in m of the landmarks in all views, given as fractions of the pictures' (width, height)."""
    if any(hand is None for hand in hands):
        return {}
    points = {}
    for name, number in LANDMARKS.items():
        pixels = []
        for camera, hand, size in zip(rig.cameras, hands, sizes, strict=True):
            pixel = np.array((hand or ())[number]) * size
            pixels.append(pixel if camera.lens is None else camera.lens.undistort_pixels(pixel))
        points[name] = triangulate(rig.matrices, pixels)
    return points
