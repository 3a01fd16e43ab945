"""A dataset in LeRobot's format v3.0: its counts, figures and pictures are those of the sessions."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from common.errors import ExportError
from farhand.export.lerobot import assembly
from farhand.export.resampling import instants
from tests.farhand.export.lerobot.made_dataset import FPS, episodes, export, frames, info, made_sessions, pictures, read
from tests.farhand.export.made_session import BEGIN_NS, EPOCH_NS, OPERATOR_NS, MadeSession, at_s, drawn, joints

LENGTHS = [60, 51, 48]
IMAGES = "observation.images."


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    out = tmp_path_factory.mktemp("exported") / "dataset"
    summary = export(made_sessions(), out)
    assert (summary.episodes, summary.frames, summary.left_out) == (3, sum(LENGTHS), ())
    return out


def test_counts_and_indices_run_through_all_sessions(dataset):
    rows, said = frames(dataset), info(dataset)
    assert (said["total_episodes"], said["total_frames"], said["total_tasks"]) == (3, sum(LENGTHS), 2)
    assert (said["codebase_version"], said["fps"], said["splits"]) == ("v3.0", FPS, {"train": "0:3"})
    assert rows["index"] == list(range(sum(LENGTHS)))
    assert rows["frame_index"] == [k for length in LENGTHS for k in range(length)]
    assert rows["episode_index"] == [number for number, length in enumerate(LENGTHS) for _ in range(length)]
    np.testing.assert_allclose(rows["timestamp"], np.array(rows["frame_index"]) / FPS, rtol=1e-6)
    assert [(row["dataset_from_index"], row["dataset_to_index"]) for row in episodes(dataset)] == [
        (0, 60), (60, 111), (111, 159),
    ]  # fmt: skip


def test_each_episode_is_a_row_group_of_its_own(dataset):
    file = pq.ParquetFile(dataset / "data/chunk-000/file-000.parquet")
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == LENGTHS
    said = json.loads(file.schema_arrow.metadata[b"huggingface"])["info"]["features"]
    assert said["action"] == {"feature": {"dtype": "float32", "_type": "Value"}, "length": 4, "_type": "List"}
    assert str(file.schema_arrow.field("action").type).startswith("fixed_size_list<element: float")
    assert set(said) == {name for name, one in info(dataset)["features"].items() if one["dtype"] != "video"}


def test_state_and_action_are_the_newest_not_later_than_each_instant(dataset):
    rows = frames(dataset)
    at = instants(at_s(0.5), at_s(2.5), FPS)
    measured_ns = BEGIN_NS + (at - BEGIN_NS) // 4_000_000 * 4_000_000
    sent_ns = BEGIN_NS + 1_000_000 + (at - BEGIN_NS - 1_000_000) // 4_000_000 * 4_000_000
    np.testing.assert_allclose(np.array(rows["observation.state"])[:60, :3], joints(measured_ns, 0.0), atol=1e-6)
    np.testing.assert_allclose(np.array(rows["action"])[:60, :3], joints(sent_ns - 1_000_000, 0.0) + 0.01, atol=1e-6)
    assert info(dataset)["features"]["action"]["names"] == ["waist.pos", "shoulder.pos", "elbow.pos", "gripper.pos"]
    for name, t_ns in (("frame", at), ("state", measured_ns), ("action", sent_ns), ("hand", sent_ns - 61_000_000)):
        seconds = np.array(rows[f"time.{name}"][:60])
        assert (np.round(seconds * 1e9).astype(np.int64) == t_ns - at_s(0.5)).all()
    operator_ns = np.round(np.array(rows["time.hand_operator"][:60]) * 1e9).astype(np.int64)
    begin_ns = episodes(dataset)[0]["operator_clock_begin_ns"]
    assert (operator_ns + begin_ns == sent_ns - 61_000_000 - OPERATOR_NS).all()


def test_pictures_are_those_exposed_last_and_their_times_are_true(dataset):
    rows, spans = frames(dataset), [(s, e) for s in made_sessions() for e in s.facts.episodes]
    for row, (made, episode) in zip(episodes(dataset), spans, strict=True):
        for k, (view, size) in enumerate(made.views.items()):
            key = f"videos/{IMAGES}{view}"
            shown = pictures(dataset, view, row[f"{key}/from_timestamp"], row[f"{key}/to_timestamp"])
            assert len(shown) == row["length"]
            exposed = np.array(rows[f"time.images.{view}"][row["dataset_from_index"] : row["dataset_to_index"]])
            exposed += (episode.begin_ns - BEGIN_NS) / 1e9
            late_ns = np.round((instants(episode.begin_ns, episode.end_ns, FPS) - BEGIN_NS) - exposed * 1e9)
            assert late_ns.min() >= 0
            assert late_ns.max() < 40_000_000  # 25 pictures a second
            for picture, at in ((shown[0], exposed[0]), (shown[-1], exposed[-1])):
                number = round((at - 0.007 * k) * made.camera_hz)
                errors = {n: error(picture, drawn(size, n, k)) for n in range(number - 2, number + 3)}
                assert min(errors, key=lambda n: errors[n]) == number
                assert errors[number] < 4


def error(picture, source):
    return float(np.abs(picture.astype(int) - source).mean())


def test_tasks_success_and_origin_are_kept(dataset):
    assert read(dataset / "meta/tasks.parquet") == {
        "task_index": [0, 1],
        "task": ["put the block on the mark", "öffne die Schublade"],
    }
    rows = episodes(dataset)
    assert [row["success"] for row in rows] == [True, False, True]
    assert [(row["session"], row["session_episode"]) for row in rows] == [("one", 1), ("one", 2), ("two", 1)]
    assert [row["begin_utc_ns"] - EPOCH_NS for row in rows] == [500_000_000, 2_700_000_000, 400_000_000]
    assert [frames(dataset)["task_index"][row["dataset_from_index"]] for row in rows] == [0, 1, 0]
    assert [row["tasks"] for row in rows][1] == ["öffne die Schublade"]


def test_statistics_are_those_of_the_data_and_pictures(dataset):
    stats = json.loads((dataset / "meta/stats.json").read_text(encoding="utf-8"))
    action = np.array(frames(dataset)["action"])
    np.testing.assert_allclose(stats["action"]["mean"], action.mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(stats["action"]["std"], action.std(axis=0), atol=1e-6)
    np.testing.assert_allclose(stats["action"]["q90"], np.quantile(action, 0.9, axis=0), atol=1e-6)
    front = stats[f"{IMAGES}front"]
    assert np.shape(front["mean"]) == (3, 1, 1)
    assert abs(front["mean"][1][0][0] - 90 / 255) < 0.02
    assert set(stats) == set(info(dataset)["features"])
    row = episodes(dataset)[1]
    assert row["stats/action/count"] == [51]
    assert np.shape(row[f"stats/{IMAGES}tool/q01"]) == (3, 1, 1)


def test_files_are_split_by_size_and_each_episode_says_where_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr(assembly, "VIDEO_MB", 0.02)
    monkeypatch.setattr(assembly, "FILES_PER_CHUNK", 2)
    export(made_sessions(), tmp_path / "split")
    key = f"videos/{IMAGES}front"
    rows = episodes(tmp_path / "split")
    assert [(row[f"{key}/chunk_index"], row[f"{key}/file_index"]) for row in rows] == [(0, 0), (0, 1), (1, 0)]
    assert [row[f"{key}/from_timestamp"] for row in rows] == [0.0, 0.0, 0.0]
    assert (tmp_path / f"split/{key}/chunk-001/file-000.mp4").exists()


def test_episodes_without_what_a_frame_needs_are_left_out_with_the_reason(tmp_path):
    made = MadeSession(spans=((0.5, 2.0), (2.1, 2.11), (3.0, 4.0)))
    summary = export([made], tmp_path / "short", task="stack")
    assert summary.episodes == 2
    assert summary.left_out == ("made, episode 2: it is too short",)
    assert [row["session_episode"] for row in episodes(tmp_path / "short")] == [1, 3]
    with pytest.raises(ExportError, match="no episode is left"):
        export([MadeSession(spans=())], tmp_path / "empty")


def test_sessions_of_another_kind_are_refused_by_name(tmp_path):
    with pytest.raises(ExportError, match="two has other has_gripper than one"):
        export([MadeSession("one"), MadeSession("two", has_gripper=False)], tmp_path / "mixed")
    other = MadeSession("two", views={"front": (160, 120)})
    with pytest.raises(ExportError, match=r"two has other views than one; .* --view"):
        export([MadeSession("one"), other], tmp_path / "mixed")
    assert export([MadeSession("one"), other], tmp_path / "mixed", views=("front",)).episodes == 4
    with pytest.raises(ExportError, match="has no view rear; it has front, tool"):
        export([MadeSession("one")], tmp_path / "rear", views=("rear",))
