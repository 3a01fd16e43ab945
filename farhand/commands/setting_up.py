"""`farhand setup`."""

from pathlib import Path
from typing import Annotated

import typer


def setup(
    out: Annotated[Path, typer.Option(help="Folder for all that is made; a second run goes on from there.")] = Path(
        "setup"
    ),
    camera: Annotated[
        list[str] | None, typer.Option(help="A camera that is not found: device or URL; repeat it for each.")
    ] = None,
) -> None:
    """Set up two cameras with questions and answers: find them, print the board, calibrate, try the tracker, configure.

    Example: farhand setup --out my-setup
    """
    from common.cameras.modes import device_of, list_modes
    from common.cameras.sources import open_camera
    from common.host_clock import MonotonicClock
    from farhand.setup.conversation import TerminalPerson
    from farhand.setup.finding_cameras import find_devices
    from farhand.setup.steps import Tools, set_up
    from farhand.setup.trial import views_for
    from farhand.terminal import progress_bar

    person, clock = TerminalPerson(), MonotonicClock()
    named = tuple(camera or ())
    tools = Tools(
        find=lambda: [*named, *(found for found in find_devices() if found not in named)],
        modes=lambda source: list_modes(device) if (device := device_of(source)) else (),
        open=lambda source, name, settings: open_camera(source, name, settings=settings),
        views=lambda cameras, pairing, seconds: views_for(cameras, pairing, clock, seconds),
        progress=progress_bar,
    )
    set_up(out, person, tools)
