"""Size and rate of both cameras: what they offer, what a person chooses, whether both give it at once."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing

from common.cameras.live import LiveCamera
from common.cameras.modes import CameraMode
from common.cameras.settings import CameraSettings
from common.errors import CameraError, ConfigError
from farhand.calibration.points import parse_pair
from farhand.setup.conversation import SetupPerson, ask_number
from farhand.setup.finding_cameras import OpenCamera

ListModes = Callable[[str], Sequence[CameraMode]]  # of a source; none where it does not say

USUAL_SIZE, USUAL_FPS = (640, 480), 30.0
MIN_SIZE, MAX_SIZE = (320, 240), (1920, 1200)  # with fewer pixels fingers are lost, with more no tracker keeps up
TRIED_FRAMES = 15


def choose_settings(
    sources: Mapping[str, str], modes: ListModes, tried: OpenCamera, person: SetupPerson
) -> CameraSettings:
    """Size and rate, as a person chooses them until both cameras give them at once."""
    offered = [modes(source) for source in sources.values()]
    sizes = common_sizes(offered)
    if sizes:
        person.tell(f"both cameras offer {', '.join(f'{width}x{height}' for width, height in sizes)}")
    while True:
        size = _ask_size(person, sizes)
        fps = ask_number(person, "How many pictures a second?", USUAL_FPS, 5, 240)
        settings = CameraSettings(
            width_px=size[0], height_px=size[1], fps=fps, pixel_format=needed_format(offered, size, fps)
        )
        try:
            for sentence in verify(sources, settings, tried):
                person.tell(sentence)
        except CameraError as error:
            person.tell(f"{error}; choose another size or rate")
            continue
        return settings


def _ask_size(person: SetupPerson, sizes: Sequence[tuple[int, int]]) -> tuple[int, int]:
    usual = USUAL_SIZE if USUAL_SIZE in sizes or not sizes else sizes[0]
    while True:
        try:
            return parse_pair(person.ask("Which size of picture?", f"{usual[0]}x{usual[1]}"), "the size")
        except ConfigError as error:
            person.tell(str(error))


def common_sizes(offered: Sequence[Sequence[CameraMode]]) -> list[tuple[int, int]]:
    """The sizes (width, height) that all cameras offer and that serve tracking, smallest first."""
    sizes = [{(mode.width_px, mode.height_px) for mode in own} for own in offered]
    common = set.intersection(*sizes) if sizes else set()
    return sorted(s for s in common if all(a <= b <= c for a, b, c in zip(MIN_SIZE, s, MAX_SIZE, strict=True)))


def needed_format(offered: Sequence[Sequence[CameraMode]], size: tuple[int, int], fps: float) -> str | None:
    """A pixel format in which all cameras give this size at this rate; None if they do not say.

    Pictures that are sent as they are come first, then those that are compressed, which share a USB port more easily
    but smear edges.
    """
    able = [{m.pixel_format for m in own if (m.width_px, m.height_px) == size and _gives(m, fps)} for own in offered]
    common = set.intersection(*able) if able else set()
    return min(common, key=lambda name: (name != "YUYV", name != "MJPG", name), default=None)


def _gives(mode: CameraMode, fps: float) -> bool:
    return any(abs(rate - fps) < 0.5 for rate in mode.fps)


def verify(sources: Mapping[str, str], settings: CameraSettings, tried: OpenCamera) -> list[str]:
    """Verify what both cameras do when they run at once, a sentence each; CameraError if one does not obey."""
    sentences = []
    with ExitStack() as opened:
        cameras = [opened.enter_context(closing(tried(source, name, settings))) for name, source in sources.items()]
        for _ in range(TRIED_FRAMES):
            for camera in cameras:
                camera.read()
        for camera in cameras:
            if isinstance(camera, LiveCamera):
                sentences.append(f"{camera.name}: {camera.state}")
                if camera.state.focus == "auto":
                    sentences.append(
                        f"warning: {camera.name} focuses by itself, which undoes the calibration; set focus in "
                        "[operator.cameras], such as focus = 0, or switch it off with v4l2-ctl"
                    )
    return sentences
