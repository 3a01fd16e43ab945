"""Which cameras there are, what they see, and which is left."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np

from common.cameras.camera import Camera, Image
from common.cameras.images import write_image
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import shown_source
from common.errors import CameraError
from farhand.setup.conversation import SetupPerson, choose

OpenCamera = Callable[[str, str, CameraSettings], Camera]  # source, name, settings; CameraError with the cure

DEVICES, PATHS = Path("/dev"), Path("/dev/v4l/by-path")
SETTLING_FRAMES = 10  # automatic exposure finds its level in the first frames
THUMBNAIL_PX = 480
NONE_FOUND = (
    "give each camera a USB port of its own, close other programs that use it, let this user read it (sudo usermod -aG "
    "video $USER, then log in again), or name what was not found: farhand setup --camera /dev/video4 --camera rtsp://..."
)


def find_devices(devices: Path = DEVICES, paths: Path = PATHS) -> list[str]:
    """The video devices of this host, each by the name of its port where it has one, which lasts over restarts."""
    by_port = {path.resolve(): path for path in sorted(paths.iterdir())} if paths.is_dir() else {}
    numbered = [path for path in devices.glob("video*") if path.name.removeprefix("video").isdecimal()]
    numbered.sort(key=lambda path: int(path.name.removeprefix("video")))
    return [str(by_port.get(path.resolve(), path)) for path in numbered]


def try_cameras(sources: Sequence[str], open_camera: OpenCamera, person: SetupPerson) -> dict[str, Image]:
    """A picture of each source that gives one; of the others, why not."""
    pictures = {}
    for source in sources:
        person.show(f"trying {shown_source(source)}")
        try:
            pictures[source] = _picture(source, open_camera)
        except CameraError as error:
            person.tell(str(error))
    return pictures


def _picture(source: str, open_camera: OpenCamera) -> Image:
    """A picture of a source when its exposure has settled."""
    with closing(open_camera(source, Path(shown_source(source)).name, AS_IT_IS)) as camera:
        last = None
        for _ in range(SETTLING_FRAMES):
            if (frame := camera.read()) is None:
                break
            last = frame
    if last is None:
        raise CameraError(
            f"camera {shown_source(source)} gives no picture; many cameras have a second device that never gives one"
        )
    return last.image


def choose_cameras(pictures: Mapping[str, Image], thumbnails: Path, person: SetupPerson) -> tuple[str, str]:
    """The left and the right camera, as a person chooses them by their thumbnails; CameraError without two."""
    if len(pictures) < 2:
        raise CameraError(f"{len(pictures)} of the two cameras that are needed give pictures: {NONE_FOUND}")
    numbered = dict(zip(map(str, range(1, len(pictures) + 1)), pictures, strict=True))
    for number, source in numbered.items():
        write_image(thumbnails, f"camera_{number}", thumbnail(pictures[source], number))
    person.tell(f"a picture of each camera is in {thumbnails}: open them to see which is which")
    meanings = {number: _describe(source, pictures[source]) for number, source in numbered.items()}
    left = choose(person, "Which one is left, seen from behind the cameras?", meanings, "1")
    rest = {number: meaning for number, meaning in meanings.items() if number != left}
    right = next(iter(rest)) if len(rest) == 1 else choose(person, "Which one is right?", rest, next(iter(rest)))
    return numbered[left], numbered[right]


def _describe(source: str, picture: Image) -> str:
    height, width = picture.shape[:2]
    return f"{shown_source(source)}, {width} x {height} px, mean brightness {float(np.mean(picture)):.0f} of 255"


def thumbnail(picture: Image, number: str) -> Image:
    """A picture made THUMBNAIL_PX wide, with its number."""
    height, width = picture.shape[:2]
    small = cv2.resize(picture, (THUMBNAIL_PX, round(THUMBNAIL_PX * height / width)), interpolation=cv2.INTER_AREA)
    for colour, thickness in ((0, 8), (255, 3)):
        cv2.putText(small, number, (12, 48), cv2.FONT_HERSHEY_SIMPLEX, 1.6, (colour,) * 3, thickness, cv2.LINE_AA)
    return np.asarray(small, dtype=np.uint8)
