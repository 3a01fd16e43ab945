"""An export that is interrupted goes on where it was, and never over a dataset."""

import pytest

from common.errors import ConfigError, ExportError, InterruptionError
from farhand.export.lerobot.dataset_export import ExportSettings, export_lerobot
from farhand.export.lerobot.staging import ExportJob, Staging
from tests.farhand.export.lerobot.made_dataset import export, made_sessions


def files(root):
    return {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def interrupted(out, frames):
    """An export that is stopped after so many frames."""
    asked = iter(range(10_000))
    with pytest.raises(InterruptionError, match="the same command goes on"):
        export_lerobot(made_sessions(), ExportSettings(out), lambda: next(asked) >= frames, lambda *_: None)


def test_what_is_complete_is_not_encoded_again_and_the_dataset_is_the_same(tmp_path):
    whole = export(made_sessions(), tmp_path / "whole")
    interrupted(tmp_path / "cut", 75)  # in the second episode, of 60, 51 and 48 frames
    assert not (tmp_path / "cut").exists()
    summary = export(made_sessions(), tmp_path / "cut")
    assert (summary.frames, summary.encoded) == (whole.frames, whole.frames - 60)
    assert files(tmp_path / "cut") == files(tmp_path / "whole")
    assert not (tmp_path / "cut.part").exists()


def test_an_episode_cut_by_a_kill_is_encoded_again(tmp_path):
    export(made_sessions(), tmp_path / "whole")
    interrupted(tmp_path / "cut", 75)
    half = tmp_path / "cut.part/000001"
    assert not (half / "episode.json").exists()
    (half / "front.mp4").write_bytes(b"cut short")
    (half / "frames.parquet").write_bytes(b"")
    export(made_sessions(), tmp_path / "cut")
    assert files(tmp_path / "cut") == files(tmp_path / "whole")


def test_a_dataset_is_never_written_over(tmp_path):
    export(made_sessions(), tmp_path / "dataset")
    before = files(tmp_path / "dataset")
    with pytest.raises(ConfigError, match="exists, and is never written over: give another, or remove it"):
        export(made_sessions(), tmp_path / "dataset")
    assert files(tmp_path / "dataset") == before
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ConfigError, match="never written over"):
        export(made_sessions(), tmp_path / "file")


def test_an_interrupted_export_of_another_kind_is_not_continued(tmp_path):
    interrupted(tmp_path / "cut", 5)
    with pytest.raises(ExportError, match=r"with other fps: repeat that command to go on, .* remove .*cut.part"):
        export(made_sessions(), tmp_path / "cut", fps=10)
    with pytest.raises(ExportError, match="with other sessions"):
        export(made_sessions()[:1], tmp_path / "cut")
    (tmp_path / "cut.part/job.json").write_bytes(b"{}")
    with pytest.raises(ExportError, match="with other settings"):
        export(made_sessions(), tmp_path / "cut")


def test_two_exports_to_one_place_exclude_each_other(tmp_path):
    job = ExportJob(("a",), (), 30, "")
    with Staging(tmp_path / "out", job):
        second = Staging(tmp_path / "out", job)
        with pytest.raises(ExportError, match="under way"):
            second.__enter__()
    with Staging(tmp_path / "out", job):
        pass
