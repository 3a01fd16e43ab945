"""Files of an import, and what it may replace: files that an earlier import wrote and nobody changed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from common.errors import ConfigError, ModelError
from farhand.arm_import.writing.manifest import digests_in, is_as_written
from farhand.outputs import check_file, make_folder, write_result


@dataclass(frozen=True, slots=True)
class Places:
    """The configuration; beside it the arm's file, and the folder of its meshes."""

    toml: Path
    urdf: Path
    meshes: Path

    @classmethod
    def around(cls, out: Path, source: Path) -> "Places":
        """Beside the configuration `out`; the arm's file has another name where the maker's own is there."""
        beside = out.with_suffix(".urdf")
        urdf = beside if beside.resolve() != source.resolve() else out.with_name(f"{out.stem}-arm.urdf")
        return cls(out, urdf, out.with_name(f"{out.stem}_meshes"))

    def within(self, folder: Path) -> "Places":
        """The same names in another folder."""
        return Places(*(folder / path.name for path in (self.toml, self.urdf, self.meshes)))

    def check(self, source: Path) -> None:
        """ConfigError where nothing can be written, or what is there is not, or no longer, an import's."""
        if self.toml.suffix != ".toml":
            raise ConfigError(f"--out {self.toml}: give a file that ends in .toml")
        for file in (self.toml, self.urdf):
            check_file("--out", file, [source])
        written = self._as_written()
        others = [file for file in self._existing() if file not in written]
        if others:
            raise ConfigError(
                f"--out {self.toml}: {others[0]} exists already, and only what an import wrote and nobody changed is "
                "replaced; give another name, or move it away first"
            )

    def write(self, contents: Mapping[str, bytes]) -> None:
        """Write files by their names as seen from the configuration; what an earlier import left goes."""
        folder = self.toml.parent
        for file in self._as_written():
            if file.relative_to(folder).as_posix() not in contents:
                file.unlink()
        for name, content in contents.items():
            make_folder("--out", (folder / name).parent)
            write_result(folder / name, content)
        if self.meshes.is_dir() and not self._meshes():
            self.meshes.rmdir()

    def _meshes(self) -> list[Path]:
        return sorted(self.meshes.iterdir()) if self.meshes.is_dir() else []

    def _existing(self) -> list[Path]:
        """Everything that is in these places."""
        folder = [self.meshes] if self.meshes.exists() and not self.meshes.is_dir() else []
        return [*(file for file in (self.toml, self.urdf) if file.exists()), *folder, *self._meshes()]

    def _as_written(self) -> set[Path]:
        """Of these, the files that are as an earlier import wrote them."""
        if not self.urdf.is_file():
            return set()
        digests, folder = digests_in(self.urdf.read_bytes()), self.toml.parent
        files = {file.relative_to(folder).as_posix(): file for file in self._existing() if file.is_file()}
        return {file for name, file in files.items() if is_as_written(name, file.read_bytes(), digests)}


def read_urdf(path: Path) -> bytes:
    """The maker's file; ModelError where it cannot be read, or is one that an import wrote."""
    try:
        urdf = path.read_bytes()
    except OSError as error:
        raise ModelError(f"cannot read {path}: {error.strerror}; give the path of a URDF file") from error
    if digests_in(urdf):
        raise ModelError(f"{path} was written by farhand arm import; give the maker's file, which it names")
    return urdf
