"""Films on disk: a lossless video of each camera, the rig, and a line of truth for each instant."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, closing
from itertools import zip_longest
from pathlib import Path

import cv2
import numpy as np

from common.cameras.sources import open_camera
from common.errors import CameraError
from farhand.tracking.recorded_pairs import RecordedPairs
from lab.films.film import FilmInstant, HandTruth, TrackingFilm
from local_site.calibration.rig_file import load_rig, save_rig
from local_site.simulation.body import ArmTruth
from local_site.tracking.tracker import Views

LOSSLESS = cv2.VideoWriter.fourcc(*"HFYU")
POINTS = ("elbow", "wrist", "index", "thumb")
FACTS = "film.json"


def write_film(film: TrackingFilm, folder: Path) -> int:
    """Write a film into a folder, and return its number of instants; CameraError when a video cannot be written.

    The folder then holds NAME.avi of every camera, rig.json, truth.jsonl and film.json; a line of truth is null where
    the arm is absent, else as in the recordings, with `operator_R_hand`, `right` and `posture`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    save_rig(film.rig, folder / "rig.json")
    writers: list[cv2.VideoWriter] = []
    lines: list[str] = []
    for instant in film.instants():
        images = [view.current.image for view in instant.views.views]
        if not writers:
            size = images[0].shape[1], images[0].shape[0]
            writers = [_writer(folder / f"{c.name}.avi", film.fps, size) for c in film.rig.cameras]
        for writer, image in zip(writers, images, strict=True):
            writer.write(image)
        lines.append(json.dumps(_line(len(lines), instant)) + "\n")
    for writer in writers:
        writer.release()
    (folder / "truth.jsonl").write_text("".join(lines), encoding="utf-8")
    (folder / FACTS).write_text(json.dumps({"name": film.name, "fps": film.fps}) + "\n", encoding="utf-8")
    return len(lines)


def read_film(folder: Path) -> TrackingFilm:
    """A film that was written; CameraError when pictures and truth differ in number."""
    facts = json.loads((folder / FACTS).read_text(encoding="utf-8"))
    rig = load_rig(folder / "rig.json")
    truths = [_truth(json.loads(line)) for line in (folder / "truth.jsonl").read_bytes().splitlines()]

    def instants() -> Iterator[FilmInstant]:
        with ExitStack() as stack:
            cameras = [
                stack.enter_context(closing(open_camera(str(folder / f"{c.name}.avi"), c.name))) for c in rig.cameras
            ]
            for number, (views, truth) in enumerate(zip_longest(RecordedPairs(*cameras), truths, fillvalue=...)):
                if not isinstance(views, Views) or isinstance(truth, type(...)):
                    raise CameraError(f"{folder} ends after {number} instants, but has {len(truths)} lines of truth")
                yield FilmInstant(views, truth)

    return TrackingFilm(facts["name"], rig, facts["fps"], instants)


def read_films(folder: Path) -> list[TrackingFilm]:
    """All films that were written into folders of this one."""
    return [read_film(facts.parent) for facts in sorted(folder.glob(f"*/{FACTS}"))]


def _writer(path: Path, fps: float, size: tuple[int, int]) -> cv2.VideoWriter:
    writer = cv2.VideoWriter(str(path), LOSSLESS, fps, size)
    if not writer.isOpened():
        raise CameraError(f"cannot write {path}: free the disk, or install OpenCV with FFmpeg")
    return writer


def _line(number: int, instant: FilmInstant) -> dict[str, object] | None:
    truth = instant.truth
    if truth is None:
        return None
    points = {name: np.round(getattr(truth.arm, name), 6).tolist() for name in POINTS}
    return {
        "frame": number,
        "t": round(instant.views.t_ns * 1e-9, 6),
        **points,
        "hand_open": truth.arm.hand_open,
        "operator_R_hand": None if truth.operator_R_hand is None else np.round(truth.operator_R_hand, 6).tolist(),
        "right": truth.right,
        "posture": truth.posture,
    }


def _truth(line: dict[str, object] | None) -> HandTruth | None:
    if line is None:
        return None
    elbow, wrist, index, thumb = (np.array(line[name]) for name in POINTS)
    arm = ArmTruth(elbow, wrist, index, thumb, bool(line["hand_open"]))
    rotation = None if line["operator_R_hand"] is None else np.array(line["operator_R_hand"])
    return HandTruth(arm, rotation, bool(line["right"]), str(line["posture"]))
