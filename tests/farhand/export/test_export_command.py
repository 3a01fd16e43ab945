"""`farhand export` as a person runs it."""

import sys

import pytest

from farhand.cli import main
from tests.farhand.export.lerobot.made_dataset import info
from tests.farhand.export.test_recording import recorded  # noqa: F401  # a fixture


@pytest.fixture
def run(monkeypatch, capsys):
    def ended(*arguments):
        monkeypatch.setattr(sys, "argv", ["farhand", "export", *map(str, arguments)])
        code: str | int | None = 0
        try:
            main()
        except SystemExit as end:
            code = end.code
        told = capsys.readouterr()
        return code or 0, told.out, told.err

    return ended


def test_a_recording_becomes_a_dataset_a_table_and_a_video(run, recorded, tmp_path):  # noqa: F811
    code, out, _ = run("lerobot", recorded, "--out", tmp_path / "dataset", "--fps", 20)
    assert (code, info(tmp_path / "dataset")["total_episodes"]) == (0, 1)
    assert "1 episodes" in out
    for kind, suffix in (("csv", ".csv"), ("mp4", ".mp4")):
        code, out, _ = run(kind, recorded, "--out", tmp_path / kind)
        (made,) = (tmp_path / kind).iterdir()
        assert (code, made.suffix) == (0, suffix)
        assert str(made) in out.replace("\n", "")


def test_what_exists_is_kept_and_the_error_names_the_cure(run, recorded, tmp_path):  # noqa: F811
    (tmp_path / "dataset").mkdir()
    (tmp_path / "dataset/mine").write_text("kept")
    code, _, err = run("lerobot", recorded, "--out", tmp_path / "dataset")
    assert code == 2
    assert "give another, or remove it first" in err
    assert [path.name for path in (tmp_path / "dataset").iterdir()] == ["mine"]
    run("csv", recorded, "--out", tmp_path / "tables")
    code, _, err = run("csv", recorded, "--out", tmp_path / "tables")
    assert (code, err.count("never written over")) == (2, 1)
