"""The doctor's judgements over made-up facts: each level, and a cure wherever something is to be done."""

from dataclasses import replace

import msgspec
import pytest

from farhand.doctor import arm, cameras, landmarks, machine, site
from farhand.doctor.findings import Finding, Severity, as_builtins, as_text, error, ok, warning, worst

SHARED = "/run/shared"
LANDMARKS = landmarks.LandmarkFacts("2.3.0", "/m", (), "farhand models install")
GB, MB = 1_000_000_000, 1_000_000
CASES = [
    (machine.check_python((3, 12, 1), ()), "ok", "3.12.1"),
    (machine.check_python((3, 10, 9), ()), "error", "3.10.9"),
    (machine.check_python((3, 11, 0), ("numba", "daqp")), "error", "numba, daqp"),
    (machine.check_rendering(None), "ok", "EGL"),
    (machine.check_rendering("no EGL here"), "error", "no EGL here"),
    (machine.check_real_time(0, granted=True), "ok", "priority 50"),
    (machine.check_real_time(20, granted=False), "warning", "RLIMIT_RTPRIO is 20"),
    (machine.check_congestion("bbr", ("bbr",)), "ok", "BBR"),
    (machine.check_congestion("cubic", ("cubic", "bbr")), "warning", "cubic"),
    (machine.check_congestion("", ()), "warning", "unknown"),
    (machine.check_disk("/var", 50 * GB), "ok", "50000 MB"),
    (machine.check_disk("/var", GB), "warning", "1000 MB"),
    (machine.check_disk("/var", MB), "error", "1 MB"),
    (machine.check_disk("/var", None), "warning", "/var"),
    (machine.check_shared_memory(SHARED, GB), "ok", "1000 MB"),
    (machine.check_shared_memory(SHARED, 32 * MB), "warning", "32 MB"),
    (machine.check_shared_memory(SHARED, None), "error", "not mounted"),
    (machine.check_cache("/c", writable=True, compiled=43), "ok", "43 functions"),
    (machine.check_cache("/c", writable=False, compiled=43), "ok", "43 functions"),
    (machine.check_cache("/c", writable=True, compiled=0), "warning", "first start"),
    (machine.check_cache("/c", writable=False, compiled=0), "warning", "every start"),
    (landmarks.check_landmarks(LANDMARKS)[0], "ok", "ai-edge-litert 2.3.0"),
    (landmarks.check_landmarks(LANDMARKS)[1], "ok", "/m, unchanged"),
    (landmarks.check_landmarks(replace(LANDMARKS, runtime=""))[0], "error", "not installed"),
    (landmarks.check_landmarks(replace(LANDMARKS, wrong=("palm.tflite",)))[1], "error", "changed in /m: palm.tflite"),
    (arm.check_robot("a465", "kinematic", ())[0], "ok", "driver kinematic"),
    (arm.check_robot("a", "b", [("robot", "no file", "give one")])[0], "error", "no file"),
    (arm.check_guard(()), "ok", "not guarded: people, cables"),
    (arm.check_guard(("the tool", "the cell")), "warning", "not guarded: the tool; the cell; people, cables"),
    (arm.check_stops(arm.StopFacts("j1", 333.8, 600.0, "a.urdf")), "ok", "takes 334 ms at most (j1), of 600 allowed"),
    (
        arm.check_stops(arm.StopFacts("j1", 333.8, 600.0, "a.urdf", ("j1", "j2"))),
        "warning",
        "a.urdf states no jerk for j1, j2, so 100 rad/s³ counts; a stop takes 334 ms",
    ),
    (cameras.check_camera(cameras.CameraFacts("left", "0", (640, 480))), "ok", "640 x 480"),
    (
        cameras.check_camera(
            cameras.CameraFacts("left", "0", (640, 480), state="640 x 480, MJPG; stamped by its driver")
        ),
        "ok",
        "gives 640 x 480, MJPG; stamped",
    ),
    (
        cameras.check_camera(cameras.CameraFacts("left", "0", problem="gives 15 fps. Cure: choose 30")),
        "error",
        "gives 15 fps",
    ),
    (cameras.check_camera(cameras.CameraFacts("left", "0", holder="farhand (process 7)")), "ok", "process 7"),
    (cameras.check_camera(cameras.CameraFacts("left", "0", holder="cheese (process 7)")), "error", "cheese"),
    (cameras.check_camera(cameras.CameraFacts("left", "0", problem="cannot open 0")), "error", "cannot open 0"),
    (cameras.check_rig(cameras.RigFacts("rig.json", 3.2)), "ok", "3 days"),
    (cameras.check_rig(cameras.RigFacts("rig.json", 200.0)), "warning", "200 days"),
    (cameras.check_rig(cameras.RigFacts("rig.json")), "warning", "has no date"),
    (cameras.check_rig(cameras.RigFacts("rig.json", problem="is no rig")), "error", "is no rig"),
    (site.check_port(site.PortFacts("control", "tcp/127.0.0.1:7447", free=True)), "ok", "free"),
    (site.check_port(site.PortFacts("control", "e", holder="farhand-control (process 9)")), "ok", "farhand-control"),
    (site.check_port(site.PortFacts("control", "e", holder="nginx (process 9)")), "error", "nginx"),
    (site.check_port(site.PortFacts("control", "e")), "error", "another user"),
    (site.check_port(site.PortFacts("control", "e", problem="refused")), "error", "refused"),
    (site.check_clock(site.ClockFacts("e", 2_000_000, 300_000)), "ok", "2.000 ms, uncertainty 0.300 ms"),
    (site.check_clock(site.ClockFacts("e", 2_000_000, 30_000_000)), "warning", "30.000 ms"),
    (site.check_clock(site.ClockFacts("e")), "warning", "does not answer"),
    (site.check_clock(site.ClockFacts("e", problem="another protocol")), "error", "another protocol"),
]


@pytest.mark.parametrize(("finding", "level", "words"), CASES)
def test_a_fact_is_judged_and_what_is_wrong_has_a_cure(finding: Finding, level: str, words: str) -> None:
    assert finding.level == level
    assert words in finding.sentence
    assert bool(finding.cure) is (level != "ok")


def test_bbr_that_is_not_loaded_is_loaded_first() -> None:
    loaded = machine.check_congestion("cubic", ("cubic", "bbr"))
    absent = machine.check_congestion("cubic", ("cubic",))
    assert "modprobe" not in loaded.cure
    assert absent.cure.startswith("modprobe tcp_bbr")


def test_pictures_of_another_size_than_calibrated_are_an_error() -> None:
    rig = cameras.RigFacts("rig.json", 1.0, ((640, 480), (640, 480), None))
    probed = (
        cameras.CameraFacts("left", "0", (640, 480)),
        cameras.CameraFacts("right", "2", (1280, 720)),
        cameras.CameraFacts("third", "4", (1280, 720)),
    )
    (wrong,) = cameras.check_sizes(rig, probed)
    assert (wrong.check, wrong.level) == ("camera right", Severity.ERROR)
    assert "1280 x 720, but it was calibrated with 640 x 480" in wrong.sentence


def test_the_tracker_for_rooms_is_told_of_grey_cameras() -> None:
    probed = cameras.CameraFacts("left", "0", (640, 480)), cameras.CameraFacts("right", "2", (640, 480), is_grey=True)
    (grey,) = cameras.check_colours("learned", probed)
    assert (grey.check, grey.level) == ("camera right", Severity.WARNING)
    assert "gives colour" in grey.cure
    assert cameras.check_colours("silhouette", probed) == []


def test_the_worst_finding_counts() -> None:
    fine, poor, bad = ok("a", "fine"), warning("b", "poor", "mend"), error("c", "bad", "buy")
    assert worst([]) is worst([fine]) is Severity.OK
    assert worst([poor, fine]) is Severity.WARNING
    assert worst([bad, poor, fine]) is Severity.ERROR


def test_findings_are_told_to_people_and_to_programs() -> None:
    found = [ok("a", "fine"), warning("b", "poor", "mend")]
    assert as_text(found).splitlines() == [
        "ok       a: fine",
        "warning  b: poor",
        "           cure: mend",
        "1 ok, 1 warning, 0 error",
    ]
    told = as_builtins(found)
    assert told["worst"] == "warning"
    assert msgspec.to_builtins(told["findings"][1]) == {
        "check": "b",
        "level": "warning",
        "sentence": "poor",
        "cure": "mend",
    }
