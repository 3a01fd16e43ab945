"""Messages reach the event loop in their order, and as many of the newest as the channel keeps."""

import asyncio

import pytest

from common.messages.video import KeyFrameRequest
from local_site.console.listening import Handover


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
