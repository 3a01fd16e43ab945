"""Messages reach the event loop in their order, and as many of the newest as the channel keeps."""

import asyncio

import msgspec
import pytest

from common.errors import TransportError
from common.messages.video import KeyFrameRequest, VideoFrame
from local_site.console.listening import Handover, Listeners
from local_site.console.pictures import only_of
from tests.common.messages.golden_examples import VIDEO


@pytest.mark.parametrize(("depth", "taken"), [(1, [5]), (3, [3, 4, 5]), (8, [0, 1, 2, 3, 4, 5])])
def test_a_loop_that_was_busy_gets_the_newest_in_order(depth: int, taken: list[int]) -> None:
    got: list[int] = []

    async def talk() -> None:
        handover = Handover[KeyFrameRequest](
            asyncio.get_running_loop(), lambda message: got.append(message.after_seq), depth
        )
        for seq in range(6):
            handover.put(KeyFrameRequest(camera="side", after_seq=seq))
        await asyncio.sleep(0)
        await asyncio.sleep(0)

    asyncio.run(talk())
    assert got == taken


class _Closed:
    """A subscription whose link is closed."""

    depth = 1

    def wait(self) -> KeyFrameRequest:
        raise TransportError("the link was closed")


def test_pages_that_come_and_go_leave_no_threads_behind() -> None:
    async def talk() -> int:
        listeners = Listeners(asyncio.get_running_loop())
        for _ in range(50):
            listeners.listen(_Closed(), print)  # type: ignore[arg-type]
            listeners.join()
        return len(listeners._threads)

    assert asyncio.run(talk()) == 1


def test_a_picture_that_says_it_is_of_another_camera_is_not_taken() -> None:
    taken: list[VideoFrame] = []
    take = only_of("side", taken.append)
    for name in ("side", "made_up_1", "made_up_2"):
        take(msgspec.structs.replace(VIDEO, camera=name))
    assert [frame.camera for frame in taken] == ["side"]
