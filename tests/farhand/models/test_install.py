"""The landmark models: only those that were tried are installed, and every failure names its cure."""

import hashlib
import subprocess
import tracemalloc
import zipfile
from pathlib import Path

import pytest

from common.errors import ModelError, NotInstalledError
from farhand.models import install as module
from local_site.tracking.landmarks import model_files
from local_site.tracking.landmarks.model_files import ModelFile, model_folder, read_model

CONTENTS = {"palm.tflite": b"palms", "hand.tflite": b"hands"}
MODELS = tuple(
    ModelFile(name, f"somewhere/{name}", hashlib.sha256(content).hexdigest()) for name, content in CONTENTS.items()
)


@pytest.fixture(autouse=True)
def two_models(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MODEL_FILES", MODELS)


def wheel(folder: Path, contents: dict[str, bytes]) -> Path:
    path = folder / "package.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in contents.items():
            archive.writestr(f"somewhere/{name}", content)
    return path


def test_models_from_a_wheel_are_installed_and_read_again(tmp_path: Path) -> None:
    said: list[str] = []
    module.install(tmp_path / "models", wheel(tmp_path, CONTENTS), said.append)
    assert [read_model(model, tmp_path / "models") for model in MODELS] == list(CONTENTS.values())
    assert sorted(path.name for path in (tmp_path / "models").iterdir()) == sorted(CONTENTS)
    assert "Apache-2.0" in said[-1]
    assert str(tmp_path / "models") in said[-1]


@pytest.mark.parametrize(
    ("contents", "why"),
    [(CONTENTS | {"hand.tflite": b"other"}, "checksum"), ({"palm.tflite": b"palms"}, "hand.tflite")],
)
def test_another_wheel_is_refused_and_leaves_what_is_there(
    tmp_path: Path, contents: dict[str, bytes], why: str
) -> None:
    module.install(tmp_path, wheel(tmp_path, CONTENTS), lambda _: None)
    with pytest.raises(ModelError, match=why) as caught:
        module.install(tmp_path, wheel(tmp_path, contents), lambda _: None)
    assert "farhand models install --from FILE" in str(caught.value)
    assert read_model(MODELS[1], tmp_path) == b"hands"


@pytest.mark.slow
@pytest.mark.parametrize("compression", [zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA])
@pytest.mark.parametrize("stated", [None, 5])
def test_a_wheel_whose_model_fills_the_memory_is_refused_unread(
    tmp_path: Path, compression: int, stated: int | None
) -> None:
    """It states what it is decompressed, or less."""
    path = tmp_path / "bomb.whl"
    with zipfile.ZipFile(path, "w", compression) as archive:
        for model in MODELS:
            archive.writestr(model.path, bytes(64 << 20))
        for entry in archive.filelist:
            entry.file_size = stated or entry.file_size
    tracemalloc.start()
    try:
        with pytest.raises(ModelError, match="--from FILE"):
            module.install(tmp_path / "models", path, lambda _: None)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 4 << 20


@pytest.mark.parametrize("content", [None, b"no archive"])
def test_a_file_that_is_missing_or_no_wheel_is_refused(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "x.whl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ModelError, match="--from FILE"):
        module.install(tmp_path, path, lambda _: None)


def test_a_folder_that_cannot_be_made_is_refused_with_the_cure(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ModelError, match="XDG_CACHE_HOME"):
        module.install(tmp_path / "file/models", wheel(tmp_path, CONTENTS), lambda _: None)


def test_what_pip_says_is_passed_on_with_the_cure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    failed = subprocess.CompletedProcess([], 1, "", "a warning\nERROR: no such host\n")
    monkeypatch.setattr(subprocess, "run", lambda *_args, **_options: failed)
    with pytest.raises(ModelError, match=r"no such host.*--from FILE"):
        module.install(tmp_path, None, lambda _: None)


def test_models_that_are_there_are_not_got_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module.install(tmp_path, wheel(tmp_path, CONTENTS), lambda _: None)

    def fail(_: Path) -> Path:
        raise ModelError("got again")

    monkeypatch.setattr(module, "download", fail)
    said: list[str] = []
    module.install(tmp_path, None, said.append)
    assert "already" in said[-1]
    assert "Apache-2.0" in said[-1]
    (tmp_path / "hand.tflite").write_bytes(b"changed")
    with pytest.raises(ModelError, match="got again"):
        module.install(tmp_path, None, said.append)


def test_a_model_that_is_missing_or_changed_names_the_one_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CACHE_DIRECTORY", raising=False)
    with pytest.raises(NotInstalledError, match="run 'farhand models install'"):
        read_model(MODELS[0], tmp_path)
    (tmp_path / "palm.tflite").write_bytes(b"changed")
    with pytest.raises(NotInstalledError, match="run 'farhand models install'"):
        read_model(MODELS[0], tmp_path)


def test_a_service_is_told_the_command_for_its_own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    with pytest.raises(NotInstalledError, match=f"CACHE_DIRECTORY={tmp_path} farhand models install"):
        read_model(MODELS[0])


def test_the_folder_is_the_services_or_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CACHE_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert model_folder() == tmp_path / model_files.FOLDER
    monkeypatch.setenv("CACHE_DIRECTORY", "/var/cache/farhand:/elsewhere")
    assert model_folder() == Path("/var/cache/farhand/models")


def test_a_pip_of_the_working_folder_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`sudo farhand models install` in a folder of somebody else's."""
    (tmp_path / "pip").mkdir()
    (tmp_path / "pip/__init__.py").touch()
    (tmp_path / "pip/__main__.py").write_text("import pathlib; pathlib.Path('ran').touch()")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    with pytest.raises(ModelError, match=r"--from FILE"):
        module.install(tmp_path / "models", None, lambda _: None)
    assert not (tmp_path / "ran").exists()
