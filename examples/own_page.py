"""A page of one's own that shows a view of the cell: python examples/own_page.py [CAMERA] [PORT] [VIDEO] [CELL]

A browser shows the answer to `/` as a film: JPEG pictures one after the other, each as old as the link makes it.
"""

import asyncio
import sys
from collections.abc import AsyncIterator

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import StreamingResponse
from starlette.routing import Route

from common.link.channels import CAMERA, ChannelSession
from common.link.transport import open_link
from common.messages.video import Codec

HEAD = b"--picture\r\nContent-Type: image/jpeg\r\n\r\n"


def main(camera: str = "side", port: str = "8480", video: str = "tcp/127.0.0.1:7448", cell: str = "lab") -> None:
    """Serve the page until Ctrl-C."""
    with open_link(connect=(video,), sessions=(ChannelSession.VIDEO,)) as link:
        newest = link.latest(CAMERA, cell, camera)

        async def pictures() -> AsyncIterator[bytes]:
            while True:
                if (frame := newest.take()) is not None and frame.data and frame.codec is Codec.JPEG:
                    yield HEAD + frame.data + b"\r\n"
                await asyncio.sleep(0.01)

        async def film(_: Request) -> StreamingResponse:
            return StreamingResponse(pictures(), media_type="multipart/x-mixed-replace; boundary=picture")

        uvicorn.run(Starlette(routes=[Route("/", film)]), host="127.0.0.1", port=int(port), log_level="warning")


if __name__ == "__main__":
    main(*sys.argv[1:])
