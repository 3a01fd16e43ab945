"""The rig's file: JSON that a person can read, refused where it cannot be right."""

from pathlib import Path

import msgspec

from common.atomic_file import write_atomically
from common.errors import CalibrationError
from local_site.calibration.checks import rig_mistakes
from local_site.calibration.rig import Rig


def load_rig(path: Path, named_by: str = "operator.rig") -> Rig:
    """Read a rig file; CalibrationError names what is wrong and the cure, with the key or option that names it."""
    cure = f"make a rig with: farhand calibrate points CSV --out rig.json, or live, and name it in {named_by}"
    try:
        rig = msgspec.json.decode(path.read_bytes(), type=Rig)
    except OSError as error:
        raise CalibrationError(f"cannot read the rig {path}: {error.strerror}; {cure}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{path} is not a rig file of this version, or not whole: {error}; {cure}") from error
    mistakes = rig_mistakes(rig)
    if mistakes:
        raise CalibrationError("\n  ".join([f"{path} cannot be used; {cure}", *mistakes]))
    return rig


def save_rig(rig: Rig, path: Path) -> None:
    """Write a rig file, readable by a person; an earlier one is replaced only by a complete one."""
    text = msgspec.json.format(msgspec.json.encode(rig), indent=2) + b"\n"
    try:
        write_atomically(path.resolve(), text)
    except OSError as error:
        raise CalibrationError(f"cannot write the rig {path}: {error.strerror}; choose another path") from error
