"""What the rows of a status say of a cell, from its messages alone."""

import io

import msgspec
import pytest
from rich.console import Console

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import LoopTiming, SessionState, VideoLink
from common.messages.video import CameraStatus
from farhand.status.observed import Observed
from farhand.status.watch import as_lines, screen
from farhand.status.words import Mood, rows_of
from tests.present import present

NOW_NS = 500 * NS_PER_S
with_ = msgspec.structs.replace


def seen_with(state, cameras=()):
    seen = Observed("tcp/127.0.0.1:7447", "cell")
    seen.take_state(state, NOW_NS)
    seen.description, seen.round_trip_ms = golden.DESCRIPTION, 12.34
    seen.expect(cameras)
    return seen


def rows(state=golden.STATE, seen=None, now_ns=NOW_NS, software="0.1.0"):
    return {row.name: row for row in rows_of(seen or seen_with(state), state, now_ns, software)}


def test_an_engaged_cell_in_words():
    lease = with_(present(golden.STATE.lease), expires_ns=golden.STATE.t_ns + 4_200 * NS_PER_MS)
    state = with_(golden.STATE, lease=lease)
    told = rows(state)
    assert told["state"].words == "engaged: following the hand"
    assert told["state"].mood is Mood.GOOD
    assert told["lease"].words.startswith("anna (site 123456789abcdef) holds it, 4.2 s until")
    assert told["asked for"].words.endswith("consents with: farhand lease give ben")
    assert told["readiness"].words == "the arm is engaged"
    assert told["refused"].words == "2 stale, since the remote site started"
    link = present(state.hand_link)
    assert told["hand samples"].words.startswith(f"{1000 / link.interval_ms:.1f} a second")
    age = f"{link.age_ms:.0f} ms at arrival"
    assert told["hand age"].words.startswith(age)
    assert f"network {link.network_ms:.0f} ms" in told["hand age"].words
    assert told["obeyed"].words.startswith("up to 100 ms old, at 100% of full speed; the last took ")
    assert told["round trip"].words == "12.3 ms from here; the operator's clock is known to 0.1 ms"
    assert told["control"].words == "250.0 Hz, p99 0.21 ms late, 0 of 5000 missed"
    assert told["gripper"].words == "holding, 50 mm, 12 N; a toggle would command: open"
    cell = golden.DESCRIPTION
    assert told["cell"].words == f"{cell.cell} at tcp/127.0.0.1:7447, robot {cell.robot}, driver {cell.driver}"
    assert "SILENT" not in told


def test_what_is_missing_is_said_and_not_left_out():
    bare = with_(golden.STATE, lease=None, hand_link=None, gripper=None, recording=None, clock=None, obeyed=None)
    seen = seen_with(bare)
    seen.description = seen.round_trip_ms = None
    told = rows(with_(bare, state=SessionState.DISENGAGED), seen)
    assert told["lease"].words == "nobody holds it"
    assert "asked for" not in told
    assert told["hand samples"].words == "none come from the lease's holder"
    assert told["gripper"].words == "none is measured"
    assert told["recorder"].words == "none runs beside the remote site"
    assert told["round trip"].words == "no answer from here"
    assert "not known" in told["cell"].words
    assert told["readiness"].words.startswith("ready (ok): ")
    assert told["pictures"].words == "not counted yet"


def test_a_silent_cell_is_said_first():
    listed = list(rows(now_ns=NOW_NS + 7 * NS_PER_S).values())
    assert (listed[0].name, listed[0].mood) == ("SILENT", Mood.WRONG)
    assert listed[0].words == "nothing has come for 7 s; all below is as it was then"


@pytest.mark.parametrize(
    ("state", "name", "mood"),
    [
        (with_(golden.STATE, state=SessionState.FAULT), "state", Mood.WRONG),
        (with_(golden.STATE, state=SessionState.HOLDING), "state", Mood.WORTH_A_LOOK),
        (with_(golden.STATE, timing=LoopTiming(250.0, 2500.0, 0, 9, True)), "control", Mood.WORTH_A_LOOK),
        (with_(golden.STATE, timing=LoopTiming(250.0, 50.0, 0, 9, False)), "control", Mood.WORTH_A_LOOK),
        (with_(golden.STATE, recording=with_(golden.RECORDING, alarm="the disk is full")), "recorder", Mood.WRONG),
        (with_(golden.STATE, recording=with_(golden.RECORDING, lost=3)), "recorder", Mood.WORTH_A_LOOK),
    ],
)
def test_what_is_wrong_or_worth_a_look_stands_out(state, name, mood):
    assert rows(state)[name].mood is mood
    assert rows(golden.STATE)[name].mood is not mood


def test_another_release_stands_out():
    ours = golden.DESCRIPTION.software
    assert rows(software=ours)["version"].mood is Mood.PLAIN
    assert rows(software="9.9")["version"].words == f"{ours} there, 9.9 here"


def test_each_camera_has_its_rate_and_its_trouble():
    seen = seen_with(golden.STATE, ("front", "side"))
    live = with_(golden.VIDEO, camera="front", status=CameraStatus.LIVE, reason="", data=b"1")
    for k in range(31):
        seen.cameras["front"].take(live, NOW_NS - NS_PER_S + k * NS_PER_S // 30)
    missing = with_(live, camera="side", status=CameraStatus.MISSING, reason="cannot open /dev/video4", data=b"")
    seen.cameras["side"].take(missing, NOW_NS)
    told = rows(seen=seen)
    assert told["camera front"].words == "live, 30.0 a second"
    assert (told["camera side"].words, told["camera side"].mood) == (
        "missing, no rate yet: cannot open /dev/video4",
        Mood.WRONG,
    )


def test_a_narrow_link_of_the_pictures_is_told():
    narrow = VideoLink(carries_mbit_s=1.0, needs_mbit_s=8.0, reason="the link carries 1 of 8 Mbit/s")
    assert rows(with_(golden.STATE, video_link=narrow))["pictures' way"].words == narrow.reason


def test_nothing_that_a_site_says_acts_on_the_terminal():
    evil = with_(golden.STATE, reason="\x1b[2J\x1b]0;owned\x07 [red]words[/red]")
    seen = seen_with(evil)
    listed = rows_of(seen, evil, NOW_NS, "0.1.0")
    console = Console(width=100, force_terminal=True, record=True, file=io.StringIO())
    console.print(screen(listed, "cell"))
    shown = console.export_text(styles=True)
    assert "\x1b[2J" not in shown
    assert "\x1b]0" not in shown
    assert "[red]words[/red]" in shown
    assert any(line.startswith("state: engaged") for line in as_lines(listed))


def test_rates_are_those_of_the_last_three_seconds():
    seen = Observed("", "cell")
    rate = seen.state_rate
    assert rate.at(NOW_NS) is None
    rate.note(0)
    assert rate.at(NS_PER_MS) is None
    for k in range(1, 101):
        rate.note(k * 20 * NS_PER_MS)
    assert rate.at(2 * NS_PER_S) == pytest.approx(50.0)
    assert rate.at(10 * NS_PER_S) == 0.0
