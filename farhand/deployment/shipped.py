"""The configurations and systemd units inside the package: printed, and written to a folder."""

from pathlib import Path
from typing import NamedTuple

from common.errors import ConfigError
from common.text import instead_of
from farhand.deployment.schemas import SCHEMAS, schema_files
from farhand.outputs import make_folder, write_result

HERE = Path(__file__).parent
NAMES = tuple(sorted(path.stem for path in (HERE / "sites").glob("*.toml")))
FOR_UNITS = "the units run /opt/farhand/.venv/bin/farhand with /etc/farhand/NAME.toml: edit ExecStart for other folders"


def read_configuration(name: str) -> str:
    """The text of a shipped configuration; ConfigError, listing the names, when there is none."""
    if name not in NAMES:
        raise ConfigError(f"there is no configuration {name!r}; {instead_of(name, NAMES)}")
    return (HERE / "sites" / f"{name}.toml").read_text(encoding="utf-8")


def configuration_files(given: Path) -> tuple[Path, ...]:
    """The files that a path or a name stands for: of NAME, where there is no such file, local-NAME and remote-NAME."""
    pair = tuple(HERE / "sites" / f"{site}-{given}.toml" for site in ("local", "remote"))
    return pair if not given.exists() and all(path.is_file() for path in pair) else (given,)


class WrittenFiles(NamedTuple):
    """Which files were written, and which were there already and stay as they are."""

    written: list[Path]
    kept: list[Path]


def in_words(files: WrittenFiles) -> list[str]:
    """A line for each file, and a hint."""
    kept = (f"kept {path}: it exists" for path in files.kept)
    return [*(f"wrote {path}" for path in files.written), *kept, FOR_UNITS]


def write_all(folder: Path) -> WrittenFiles:
    """Write DIR/NAME.toml, the schemas that these name, and DIR/systemd/*.service where no such file exists.

    ConfigError when the folder cannot be written.
    """
    units = folder / "systemd"
    for made in (folder, folder / SCHEMAS, units):
        make_folder("DIR", made)
    targets = {folder / path.name: path.read_bytes() for path in sorted((HERE / "sites").glob("*.toml"))}
    targets |= schema_files(folder / SCHEMAS)
    targets |= {units / path.name: path.read_bytes() for path in sorted((HERE / "systemd").glob("*.service"))}
    files = WrittenFiles([], [])
    for target, content in targets.items():
        if target.exists() or target.is_symlink():
            files.kept.append(target)
        else:
            write_result(target, content)
            files.written.append(target)
    return files
