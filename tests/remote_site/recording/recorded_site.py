"""A site on stepped time that is recorded: control and a robot, a camera, the memory, and the recorder itself."""

from datetime import UTC, datetime
from pathlib import Path

import msgspec
import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.link.channels import HAND
from common.messages.codec import encode
from common.messages.requests import RecordAction
from common.messages.video import CameraStatus, Codec, VideoFrame
from common.recording.config import RecordConfig
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.recorder import CellRecorder
from remote_site.recording.records import RecordOrder
from remote_site.recording.taps import ControlTap, VideoTap
from remote_site.video.full_pictures import FullPictures
from remote_site.video.streaming.pictures import encode_jpeg
from remote_site.video.streaming.setting import StreamSetting
from tests.remote_site.driven_loop import CONFIG, DrivenLoop

CELL, CAMERA = CONFIG.cell, CONFIG.video.cameras[0].name
KEY = HAND.key_for(CELL, operator="operator-7")
FULL = StreamSetting(CONFIG.video.quality, 1.0, 30.0)
BEGAN = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)
TICKS_PER_PICTURE = 8


class RecordedSite:
    """`run` advances site and recorder together; a picture of noise comes every 32 ms."""

    def __init__(self, folder: Path, record: RecordConfig | None = None) -> None:
        self.loop = DrivenLoop()
        self.clock = self.loop.clock
        self.memory = RecordingMemory.create(folder / "memory", self.clock.now_ns())
        self.out = folder / "recordings"
        self.out.mkdir(mode=0o700, exist_ok=True)
        config = msgspec.structs.replace(CONFIG, record=record or RecordConfig())
        plan = RecordingPlan(self.out, CELL, "test", config.record)
        self.began = BEGAN
        recording = GuardedRecording(plan, lambda: self.began)
        self.recorder = CellRecorder(config, recording, SiteAttachment(folder / "memory"))
        self.recorder.step(self.clock.now_ns())
        self.tap = ControlTap(self.memory, self.clock)
        self.video = VideoTap(self.memory, CELL, self.clock)
        self.full = FullPictures(CONFIG.video, self.video)
        self.setting = FULL
        self.side_px = 64
        self._noise = np.random.default_rng(1)
        self._ticks = 0

    def run(self, seconds: float, speed_m_s: float = 0.0) -> None:
        """Advance by this time; the recorder steps a dozen times a second."""
        for _ in range(round(seconds * 250)):
            self.loop.tick(speed_m_s=speed_m_s)
            self.note()
            self._after_tick(recorder_lives=True)

    def idle(self, seconds: float, *, recorder_lives: bool = True) -> None:
        """As `run`, with the last cycle again and again, which takes a fraction of the time."""
        driven = self.loop.driven
        for _ in range(round(seconds * 250)):
            self.clock.advance_ms(4)
            assert driven.given is not None
            driven.given = driven.given._replace(now_ns=self.clock.now_ns(), samples=())
            self.note()
            self._after_tick(recorder_lives=recorder_lives)

    def _after_tick(self, *, recorder_lives: bool) -> None:
        self._ticks += 1
        if self._ticks % TICKS_PER_PICTURE == 0:
            self.picture()
        if recorder_lives and self._ticks % 20 == 0:
            self.recorder.step(self.clock.now_ns())

    def note(self) -> None:
        """What control does behind a command."""
        driven = self.loop.driven
        assert driven.given is not None
        assert driven.command is not None
        for named in driven.given.samples:
            self.tap.note_message(KEY, encode(named.sample), sent=False)
        self.tap.note_cycle(driven.given, driven.command, driven.ordered, driven.report)

    def picture(self) -> None:
        """An exposure, sent as the setting wants it."""
        image = self._noise.integers(0, 255, (self.side_px, self.side_px, 3), dtype=np.uint8)
        frame = Frame(image, self.clock.now_ns(), self._ticks)
        sent = VideoFrame(
            camera=CAMERA,
            seq=self._ticks,
            capture_ns=frame.capture_ns,
            capture_estimated=False,
            status=CameraStatus.LIVE,
            reason="",
            width=self.side_px,
            height=self.side_px,
            codec=Codec.JPEG,
            key=True,
            data=encode_jpeg(image, self.setting.quality),
        )
        if self.full.wanted:
            self.full.see(CAMERA, frame, sent, self.setting)

    def order(self, action: RecordAction, **given: object) -> None:
        """An order of the lease's holder, and the recorder's next step."""
        self.tap.order(RecordOrder(action, "anna", **given))  # type: ignore[arg-type]
        self.recorder.step(self.clock.now_ns())

    def end(self) -> None:
        """The site ends in order, and the recorder notices."""
        self.memory.remove()
        self.memory.close()
        self.clock.advance_ms(NS_PER_S / 1e6)
        self.recorder.step(self.clock.now_ns())

    @property
    def files(self) -> list[Path]:
        return sorted(self.out.iterdir())
