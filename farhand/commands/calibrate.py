"""The commands under `farhand calibrate`."""

from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from farhand.commands.options import AsJson, load_own, until_signal
from farhand.terminal import aside, tell

if TYPE_CHECKING:
    from farhand.calibration.points import Calibrated
    from local_site.config import LocalConfig

RigFile = Annotated[Path, typer.Option(help="Rig file to write, which does not exist yet.")]
Serials = Annotated[list[str] | None, typer.Option(help="A camera's serial number, as left=NUMBER.")]
LeftPictures = Annotated[str, typer.Option(help="Folder, quoted pattern such as 'left_*.png', or video; by name.")]
RightPictures = Annotated[str, typer.Option(help="The same for the right camera, taken at the same instants.")]
Third = Annotated[str | None, typer.Option(help="The same for a third camera.")]
Fourth = Annotated[str | None, typer.Option(help="The same for a fourth camera.")]
Squares = Annotated[str, typer.Option(help="Board: columns x rows of squares (not of corners).")]
SquareMm = Annotated[float, typer.Option(help="Board: side of a square, measured on the print.", min=1)]
MarkerMm = Annotated[float, typer.Option(help="Board: side of a marker (charuco).", min=1)]
Dictionary = Annotated[str, typer.Option(help="Board: its markers' dictionary (charuco).")]
Standing = Annotated[bool, typer.Option("--standing", help="The board is upright in the first pose, not flat.")]
CameraConfigFile = Annotated[
    Path | None, typer.Option("--config", help="A local site's TOML file: how its section 'operator' sets the cameras.")
]
FoundPictures = Annotated[
    Path | None, typer.Option(help="Folder for what was found and covered, as PNG; earlier ones are replaced.")
]

calibrate_app = typer.Typer(
    help="Compute a rig from measurements.\n\nExample: farhand calibrate points control_points.csv",
    no_args_is_help=True,
)


@calibrate_app.command("points")
def calibrate_points_command(
    csv: Annotated[Path, typer.Argument(help="X_mm,Y_mm,Z_mm,uL_px,vL_px,uR_px,vR_px[,u3_px,v3_px[,u4_px,v4_px]]")],
    out: RigFile = Path("rig.json"),
    size: Annotated[str | None, typer.Option(help="The pictures' size, as 640x480, to judge the coverage.")] = None,
    serial: Serials = None,
    as_json: AsJson = False,
) -> None:
    """Solve the cameras from control points, and print the reprojection and 3D error.

    Example: farhand calibrate points control_points.csv --out rig.json
    """
    from farhand.calibration.points import calibrate_points, parse_pair, solvable
    from farhand.outputs import check_new_file

    check_new_file("--out", out, [csv])
    parsed = None if size is None else parse_pair(size, "--size")
    with solvable():
        _tell_rig(calibrate_points(csv, out, parsed, serial or ()), as_json=as_json)


@calibrate_app.command("images")
def calibrate_images_command(
    left: LeftPictures,
    right: RightPictures,
    third: Third = None,
    fourth: Fourth = None,
    board: Annotated[str, typer.Option(help="plate (of discs), charuco or chessboard.")] = "plate",
    discs: Annotated[str, typer.Option(help="Plate: columns x rows of discs.")] = "5x5",
    pitch_mm: Annotated[float, typer.Option(help="Plate: from disc to disc.", min=1, max=10_000)] = 250.0,
    disc_mm: Annotated[float, typer.Option(help="Plate: diameter of a disc.", min=1, max=10_000)] = 32.0,
    heights_mm: Annotated[str, typer.Option(help="Plate: its height in each picture.")] = "0,497,994",
    squares: Squares = "8x6",
    square_mm: SquareMm = 30.0,
    marker_mm: MarkerMm = 22.0,
    dictionary: Dictionary = "5X5_250",
    standing: Standing = False,
    out: RigFile = Path("rig.json"),
    pictures: FoundPictures = None,
    serial: Serials = None,
    as_json: AsJson = False,
) -> None:
    """Solve the cameras from pictures of a plate of discs at known heights, or of a printed board in many poses.

    Example: farhand calibrate images --left 'left_*.png' --right 'right_*.png' --heights-mm 0,497,994
    """
    from farhand.calibration.boards import calibrate_board_pictures, make_board
    from farhand.calibration.pictures import PictureJob, by_name, calibrate_plate, parse_heights
    from farhand.calibration.points import parse_pair, solvable
    from farhand.outputs import check_folder, check_new_file
    from farhand.terminal import progress_bar
    from local_site.calibration.plate import Plate

    sources = by_name((left, right, third, fourth))
    check_new_file("--out", out, sources.values())
    check_folder("--pictures", pictures, sources.values())
    job = PictureJob(sources, out, pictures, serial or ())
    if board == "plate":
        plate = Plate(*parse_pair(discs, "--discs"), pitch_mm / 1000, disc_mm / 1000)
        heights = parse_heights(heights_mm)
        with solvable():
            _tell_rig(calibrate_plate(job, plate, heights), as_json=as_json)
        return
    printed = make_board(board, parse_pair(squares, "--squares"), square_mm, marker_mm, dictionary)
    with solvable():
        with progress_bar() as show:
            calibrated = calibrate_board_pictures(job, printed, standing, show)
        _tell_rig(calibrated, as_json=as_json)


@calibrate_app.command("live")
def calibrate_live_command(
    left: Annotated[str, typer.Option(help="Device, URL, video file or folder of images.")],
    right: Annotated[str, typer.Option(help="The same for the right camera.")],
    third: Third = None,
    fourth: Fourth = None,
    board: Annotated[str, typer.Option(help="charuco or chessboard.")] = "charuco",
    poses: Annotated[int, typer.Option(help="How many poses to take.", min=5, max=200)] = 15,
    squares: Squares = "8x6",
    square_mm: SquareMm = 30.0,
    marker_mm: MarkerMm = 22.0,
    dictionary: Dictionary = "5X5_250",
    standing: Standing = False,
    out: RigFile = Path("rig.json"),
    pictures: FoundPictures = Path("calibration"),
    serial: Serials = None,
    config: CameraConfigFile = None,
    as_json: AsJson = False,
) -> None:
    """Solve the cameras while a printed board is held still in one pose after another; Ctrl-C ends the taking early.

    Example: farhand calibrate live --left 0 --right 2 --board charuco --squares 8x6 --square-mm 30 --marker-mm 22
    """
    from farhand.calibration.boards import calibrate_live, make_board
    from farhand.calibration.cameras import configured_cameras
    from farhand.calibration.pictures import PictureJob, by_name
    from farhand.calibration.points import parse_pair
    from farhand.outputs import check_folder, check_new_file

    sources = by_name((left, right, third, fourth))
    check_new_file("--out", out, sources.values())
    check_folder("--pictures", pictures, sources.values())
    printed = make_board(board, parse_pair(squares, "--squares"), square_mm, marker_mm, dictionary)
    job = PictureJob(sources, out, pictures, serial or (), configured_cameras(_site_of(config), list(sources)))
    calibrated = calibrate_live(job, printed, standing, poses, until_signal(), aside(as_json=as_json))
    _tell_rig(calibrated, as_json=as_json)


@calibrate_app.command("latency")
def calibrate_latency_command(
    left: Annotated[str, typer.Option(help="Device or URL of a running camera.")],
    right: Annotated[str | None, typer.Option(help="The same for the right camera.")] = None,
    third: Third = None,
    fourth: Fourth = None,
    config: CameraConfigFile = None,
    screen_ms: Annotated[
        float | None, typer.Option(help="The screen's own delay, if it was measured.", min=0, max=500)
    ] = None,
    port: Annotated[int, typer.Option(help="Where the page is served on this host; 0: anywhere.", min=0)] = 0,
    as_json: AsJson = False,
) -> None:
    """Measure each camera's latency before a screen that fades between black and white, and print what to configure.

    Example: farhand calibrate latency --left 0 --right 2 --config local.toml
    """
    import secrets

    from common.errors import CalibrationError
    from common.host_clock import MonotonicClock
    from farhand.calibration.cameras import configured_cameras
    from farhand.calibration.latency.measuring import as_builtins, describe, measure, open_for_latency, watch_screen
    from farhand.calibration.latency.page import PatternPage
    from farhand.calibration.pictures import by_name

    sources = by_name((left, right, third, fourth))
    setup = configured_cameras(_site_of(config), list(sources))
    should_stop = until_signal()
    with ExitStack() as stack:
        page = stack.enter_context(PatternPage(MonotonicClock(), secrets.token_urlsafe(8), port))
        cameras = [stack.enter_context(closing(camera)) for camera in open_for_latency(sources, setup)]
        aside(as_json=as_json)(
            f"open {page.url} on the screen that the cameras see, and press Start there; Ctrl-C ends this"
        )
        measured, refused = measure(*watch_screen(cameras, page, should_stop), screen_ms)
    if measured:
        tell(describe(measured, screen_ms).splitlines(), {"cameras": as_builtins(measured)}, as_json=as_json)
    if refused:
        raise CalibrationError("\n".join(refused))


def _tell_rig(calibrated: "Calibrated", *, as_json: bool) -> None:
    from farhand.calibration.points import as_builtins, describe

    tell(describe(calibrated).splitlines(), as_builtins(calibrated), as_json=as_json)


def _site_of(config: Path | None) -> "LocalConfig | None":
    """The local site of a file, None without one."""
    from local_site.config import LocalConfig

    return load_own(LocalConfig, config) if config is not None else None
