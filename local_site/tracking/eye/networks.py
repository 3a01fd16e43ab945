"""Runs the networks on the processor: a crop or a picture in, what they find there out."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.errors import ModelError
from common.geometry import Array
from local_site.tracking.eye.arm_points import POINTS

NetworkName = Literal["arm", "hand", "finder"]
SHARPEST = 7.0  # the logarithm of the greatest whitening: a deviation of 1/1000 of the crop


@dataclass(frozen=True, slots=True)
class CropAnswer:
    """What a network finds in a crop, lengths in shares of its width.

    `points` (22, 2) and their `covariances` (22, 2, 2); the logits of the `parts` (5, 96, 96): other things, hand,
    forearm, upper arm, cloth; how probably there is a `bare` hand, and a `right` one (a left one, if mirrored).
    """

    points: Array
    covariances: Array
    parts: NDArray[np.float32]
    bare: float
    right: float


class EyeNetworks:
    """The networks, ready to look; one core each. Raises ModelError for a file that the runtime refuses."""

    def __init__(self) -> None:
        self._sessions = {name: _session(name) for name in ("arm", "hand", "finder")}

    def look(self, name: Literal["arm", "hand"], crop: Image, *, mirrored: bool) -> CropAnswer:
        """Look at a BGR crop (192, 192, 3); `mirrored` for a left arm, which the network then sees as a right one."""
        shown = crop[:, ::-1] if mirrored else crop
        parts, points, whole = self._sessions[name].run(None, {"picture": _tensor(shown)})
        return _answer(parts[0], points[0].astype(np.float64), whole[0], mirrored=mirrored)

    def find(self, picture: Image) -> NDArray[np.float32]:
        """Look for hands in a BGR picture (144, 192, 3): the answer (7, 36, 48) of each cell of 4 x 4 px."""
        cells: NDArray[np.float32] = self._sessions["finder"].run(None, {"picture": _tensor(picture)})[0][0]
        return cells


def sigmoid(logits: Array) -> Array:
    """Compute probabilities of logits."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(logits, -40.0, 40.0))))


def _answer(parts: NDArray[np.float32], points: Array, whole: Array, *, mirrored: bool) -> CropAnswer:
    at, covariances = points[:, :2].copy(), _covariances(points[:, 2:5])
    if mirrored:
        parts = parts[:, :, ::-1]
        at[:, 0] = 1.0 - at[:, 0]
        covariances = covariances * np.array([[1.0, -1.0], [-1.0, 1.0]])
    bare, right = sigmoid(whole.astype(np.float64)).tolist()
    return CropAnswer(at, covariances, parts, bare, right)


def _covariances(whitening: Array) -> Array:
    """The covariances (22, 2, 2) whose whitening is the lower triangle exp(a), b, exp(c) of each row (22, 3)."""
    a, b, c = whitening.T
    triangle = np.zeros((POINTS, 2, 2))
    triangle[:, 0, 0], triangle[:, 1, 1] = np.exp(np.clip(a, -3.0, SHARPEST)), np.exp(np.clip(c, -3.0, SHARPEST))
    triangle[:, 1, 0] = b
    deviation = np.linalg.inv(triangle)
    return np.asarray(deviation @ deviation.transpose(0, 2, 1))


def _tensor(bgr: Image) -> NDArray[np.float32]:
    rgb = np.ascontiguousarray(bgr[:, :, ::-1].transpose(2, 0, 1)[None], dtype=np.float32)
    return rgb / np.float32(127.5) - np.float32(1.0)


@cache
def _session(name: NetworkName) -> Any:
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    path = files("local_site.tracking.eye") / "models" / f"{name}.onnx"
    try:
        return ort.InferenceSession(path.read_bytes(), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # the errors of the runtime have no base of their own
        raise ModelError(f"the network {name} cannot be read: {error}; install Farhand again") from error
