"""Choice of the codec for a cell's pictures: JPEG while the link carries it, else H.264."""

from enum import StrEnum

from common.clock import NS_PER_S
from common.messages.video import Codec

RETRY_NS = 60 * NS_PER_S  # a trial of JPEG on a link that is too narrow makes pictures late for half a second
LONGEST_RETRY_NS = 16 * RETRY_NS
TRIAL_NS = 20 * NS_PER_S


class CodecPreference(StrEnum):
    """What a site's configuration asks for; auto follows the link."""

    AUTO = "auto"
    JPEG = "jpeg"
    H264 = "h264"


class CodecChoice:
    """The codec for one console; `encodes` is whether H.264 can be encoded here.

    The narrow link that made it H.264 is tried with JPEG again after a minute without late pictures; each trial that
    fails doubles the time until the next, to 16 minutes at most.
    """

    def __init__(self, preference: CodecPreference, *, encodes: bool) -> None:
        self._preference, self._encodes = preference, encodes
        self.codec = Codec.H264 if preference is CodecPreference.H264 else Codec.JPEG
        self._since_ns = 0
        self._retry_ns = RETRY_NS
        self._in_trial = False
        self._was_opening = False

    def follow(self, *, decodes: bool, opening: bool, narrow: bool, late_ns: int, now_ns: int) -> bool:
        """Choose the codec; return whether JPEG is to be tried now.

        `decodes` is whether the page decodes H.264, `opening` whether little is sent because nothing is known of the
        link, `narrow` whether it carries less than full JPEG, `late_ns` when pictures were last late.
        """
        if self._preference is not CodecPreference.AUTO or not self._encodes:
            return False
        if not decodes:
            self._set(Codec.JPEG, now_ns)
            return False
        opened, self._was_opening = self._was_opening and not opening, opening
        if opening or (opened and not narrow):
            self._set(Codec.H264 if opening else Codec.JPEG, now_ns)
            return False
        if self.codec is Codec.JPEG:
            self._in_trial = self._in_trial and now_ns - self._since_ns < TRIAL_NS
            if narrow:
                self._retry_ns = min(2 * self._retry_ns, LONGEST_RETRY_NS) if self._in_trial else RETRY_NS
                self._set(Codec.H264, now_ns)
            return False
        if now_ns - max(late_ns, self._since_ns) < self._retry_ns:
            return False
        self._in_trial = True
        self._set(Codec.JPEG, now_ns)
        return True

    def _set(self, codec: Codec, now_ns: int) -> None:
        if codec is not self.codec:
            self.codec, self._since_ns = codec, now_ns
