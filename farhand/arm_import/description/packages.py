"""Search for the files that a URDF names: package://NAME/..., file:///..., or beside the URDF."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

from common.errors import ConfigError, ModelError

PACKAGE, FILE = "package://", "file://"


@dataclass(frozen=True, slots=True)
class Packages:
    """The folders of packages: `given` by name, the `search` path's, and those around the URDF in `folder`."""

    folder: Path
    given: Mapping[str, Path]
    search: Sequence[Path]

    def find(self, filename: str) -> Path:
        """The file; ModelError names what was looked for, where, and the option that cures it."""
        if filename.startswith(PACKAGE):
            return self._in_package(*filename.removeprefix(PACKAGE).split("/", 1))
        path = Path(unquote(urlsplit(filename).path) if filename.startswith(FILE) else filename)
        found = path if path.is_absolute() else self.folder / path
        if not filename or not found.is_file():
            raise ModelError(f"there is no file {found}; put the mesh there, or correct its name in the URDF")
        return found.resolve()

    def _in_package(self, name: str, inside: str = "") -> Path:
        folders = self._folders(name)
        for folder in folders:
            if (folder / inside).is_file():
                return (folder / inside).resolve()
        if not folders:
            raise ModelError(
                f"there is no package {name!r} in ROS_PACKAGE_PATH, nor around the URDF; say where it is with "
                f"--package {name}=FOLDER, the folder that holds {inside}"
            )
        looked = ", ".join(map(str, folders))
        raise ModelError(f"the package {name!r} ({looked}) has no {inside}; give another: --package {name}=FOLDER")

    def _folders(self, name: str) -> list[Path]:
        """The folders that may be this package, the likeliest first."""
        if name in self.given:
            return [self.given[name]]
        around = [self.folder, *self.folder.parents]
        searched = [folder for root in self.search for folder in (root, root / name) if folder.name == name]
        beside = [near for folder in around for near in (folder, folder / name) if near.name == name]
        return [folder for folder in dict.fromkeys((*searched, *beside)) if folder.is_dir()]


def packages_given(options: Sequence[str]) -> dict[str, Path]:
    """The folders by name of NAME=FOLDER options; ConfigError for another form, and for a folder that is none."""
    given = {}
    for option in options:
        name, separator, folder = option.partition("=")
        if not (name and separator and folder):
            raise ConfigError(f"--package {option}: write it as NAME=FOLDER")
        if not Path(folder).is_dir():
            raise ConfigError(f"--package {option}: {folder} is no folder")
        given[name] = Path(folder)
    return given


def search_path(environment: Mapping[str, str]) -> list[Path]:
    """The folders in which ROS looks for packages."""
    first = [Path(part) for part in environment.get("ROS_PACKAGE_PATH", "").split(":") if part]
    second = [Path(part) / "share" for part in environment.get("AMENT_PREFIX_PATH", "").split(":") if part]
    return first + second
