"""MediaPipe Hands as a child process with libraries of its own: pictures come by standard input, landmarks go back.

A request is a line of JSON {"scene", "shapes"} and the pictures' bytes after it; the answer a line {"wall_ms",
"processor_ms", "hands"} with, for each picture, 21 landmarks [x, y] as fractions of width and height, or null.
"""

import json
import os
import sys
import time
from typing import Any, BinaryIO

import mediapipe
import numpy as np


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer until the requests end; every camera of every scene has a tracker of its own."""
    scene, trackers = None, []
    while line := requests.readline():
        header = json.loads(line)
        pictures = [_read(requests, shape) for shape in header["shapes"]]
        if header["scene"] != scene:
            scene = header["scene"]
            trackers = [mediapipe.solutions.hands.Hands(max_num_hands=1) for _ in pictures]
        wall, processor = time.perf_counter(), time.process_time()
        results = [tracker.process(picture) for tracker, picture in zip(trackers, pictures, strict=True)]
        wall_ms, processor_ms = 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)
        found = (result.multi_hand_landmarks for result in results)
        hands = [[(mark.x, mark.y) for mark in hand[0].landmark] if hand else None for hand in found]
        answer = {"wall_ms": wall_ms, "processor_ms": processor_ms, "hands": hands}
        answers.write(json.dumps(answer).encode() + b"\n")
        answers.flush()


def _read(requests: BinaryIO, shape: list[int]) -> Any:
    picture = np.frombuffer(requests.read(int(np.prod(shape))), np.uint8).reshape(shape)
    rgb = np.repeat(picture[..., None], 3, axis=2) if picture.ndim == 2 else picture[..., ::-1]
    return np.ascontiguousarray(rgb)


if __name__ == "__main__":
    # Whatever the libraries print must not get between the answers.
    own_output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    serve(sys.stdin.buffer, own_output)
