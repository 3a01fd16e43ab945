"""The landmark models: which files they are, where they lie on this machine, and whether they are unchanged."""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from common.errors import NotInstalledError

INSTALL = "farhand models install"
FOLDER = "farhand/models"


@dataclass(frozen=True, slots=True)
class ModelFile:
    """One model: its name, its path inside the wheel that it comes from, and its checksum."""

    name: str
    path: str
    sha256: str


def _model(folder: str, name: str, sha256: str) -> ModelFile:
    return ModelFile(name, f"mediapipe/modules/{folder}/{name}", sha256)


PALM_DETECTION = _model(
    "palm_detection",
    "palm_detection_full.tflite",
    "1b14e9422c6ad006cde6581a46c8b90dd573c07ab7f3934b5589e7cea3f89a54",
)
HAND_LANDMARKS = _model(
    "hand_landmark",
    "hand_landmark_full.tflite",
    "11c272b891e1a99ab034208e23937a8008388cf11ed2a9d776ed3d01d0ba00e3",
)
QUICK_HAND_LANDMARKS = _model(
    "hand_landmark",
    "hand_landmark_lite.tflite",
    "048edd3645c9bf7397d19a9f6e3a42957d6e414c9bea6598030a2e9b624156e6",
)
MODEL_FILES = (PALM_DETECTION, HAND_LANDMARKS, QUICK_HAND_LANDMARKS)


def service_cache() -> str:
    """The service's cache folder, as systemd gives it to the service; empty elsewhere."""
    return os.environ.get("CACHE_DIRECTORY", "").partition(":")[0]


def model_folder(service: str | None = None) -> Path:
    """Return the models' folder: in the service's cache, which is this process's if not given, else in the user's."""
    cache = service_cache() if service is None else service
    if cache:
        return Path(cache) / "models"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / FOLDER


def how_to_install(service: str | None = None) -> str:
    """The command that puts the models there: a service's user has no cache folder but the service's."""
    cache = service_cache() if service is None else service
    return f"sudo -u farhand env CACHE_DIRECTORY={cache} {INSTALL}" if cache else INSTALL


def read_model(model: ModelFile, folder: Path | None = None) -> bytes:
    """An installed model's bytes; NotInstalledError that names the cure when it is missing or has been changed."""
    path = (folder or model_folder()) / model.name
    try:
        content = path.read_bytes()
    except OSError as error:
        raise NotInstalledError(f"the landmark model {path} is not there: run '{how_to_install()}'") from error
    if hashlib.sha256(content).hexdigest() != model.sha256:
        raise NotInstalledError(f"the landmark model {path} is damaged or another version: run '{how_to_install()}'")
    return content
