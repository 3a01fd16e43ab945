"""Writes the package of a new driver: a template that works, under the name of the arm."""

import keyword
import re
import sys
import tokenize
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from common.errors import ConfigError
from farhand.outputs import make_folder, write_result
from remote_site.drivers.registry import GROUP

TEMPLATE = Path(__file__).parent / "template"
OLD_NAME, OLD_CLASS = "new_arm", "NewArm"
NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
MOST_LETTERS = 40


def write_package(name: str, folder: Path) -> list[Path]:
    """Write FOLDER/NAME, which must not exist yet, and return its files; ConfigError names what is in the way."""
    target = folder / name
    _check(name)
    if target.exists() or target.is_symlink():
        raise ConfigError(f"{target} exists, and nothing is overwritten; choose another NAME or --out")
    if find_spec(name) is not None:
        raise ConfigError(
            f"a Python module {name} is installed already, which the new one would hide; choose another NAME"
        )
    files = {target / _renamed(str(path.relative_to(TEMPLATE)), name): path for path in _sources()}
    for made in sorted({path.parent for path in files}):
        make_folder("--out", made)
    for path, source in files.items():
        write_result(path, _renamed(source.read_text(encoding="utf-8"), name).encode())
    return list(files)


def next_steps(name: str, folder: Path) -> list[str]:
    """Say what to do with the package that was written, a line each."""
    target = folder / name
    return [
        "It drives a simulated arm as it is. Next:",
        f"  {sys.executable} -m pip install --editable {target}",
        f"  farhand driver test {name}",
        f"then replace what is marked REPLACE in {target / name / 'driver.py'}, as {target / 'README.md'} says",
    ]


def class_name(name: str) -> str:
    """The class of an arm: MyArm for my_arm."""
    return "".join(part.capitalize() for part in name.split("_"))


def _check(name: str) -> None:
    """ConfigError for a name that cannot be that of a package, a function and, capitalised, a class of the template."""
    if not NAME.fullmatch(name) or len(name) > MOST_LETTERS:
        raise ConfigError(
            f"NAME {name!r}: give up to {MOST_LETTERS} small letters, digits and single underscores, a letter first, "
            "such as my_arm"
        )
    for point in entry_points(group=GROUP, name=name):
        raise ConfigError(
            f"NAME {name}: a driver of this name is installed already ({point.value}); choose another NAME"
        )
    if keyword.iskeyword(name) or {name, class_name(name)} & _identifiers():
        raise ConfigError(f"NAME {name}: the word is used by Python or by the package itself; choose another NAME")


def _identifiers() -> set[str]:
    """Every identifier of the template, but the two that are replaced, and its folders."""
    found = {path.name for path in TEMPLATE.iterdir()}
    for path in _sources():
        if path.suffix == ".py":
            with tokenize.open(path) as lines:
                tokens = tokenize.generate_tokens(lines.readline)
                found |= {token.string for token in tokens if token.type == tokenize.NAME}
    return found - {OLD_NAME, OLD_CLASS}


def _sources() -> list[Path]:
    return sorted(path for path in TEMPLATE.rglob("*") if path.is_file() and path.suffix != ".pyc")


def _renamed(text: str, name: str) -> str:
    return text.replace(OLD_NAME, name).replace(OLD_CLASS, class_name(name))
