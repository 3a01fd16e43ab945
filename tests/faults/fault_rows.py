"""The table of faults, one line each: what happens, what is promised, how it is played, on which pair of sites."""

import os
from dataclasses import dataclass
from signal import SIGCONT, SIGSTOP

from remote_site.session.config import ACCEPTANCE
from tests.faults.acts import control_gets, hand, impair, kill_local, robot
from tests.faults.cell_pair import CellPair
from tests.faults.clutch_plays import restless_release, silent_clutch
from tests.faults.engagement_plays import kill_video, late_hand, reset_under_key, stop_behind_reset, trickle
from tests.faults.far_plays import cut_shortly, far, jump_of_delay, over, too_far
from tests.faults.foreign_plays import record_strangely, slew_the_operator
from tests.faults.forgery import (
    counting_ones,
    flood,
    foreign_ones,
    hostile_ones,
    infinite_ones,
    old_ones,
    usurping_ones,
)
from tests.faults.gripper_plays import miss_an_order, restart_while_holding, uncounted
from tests.faults.network_plays import bear, crowd, lose, partition
from tests.faults.path_plays import restart_in_another_mode
from tests.faults.plays import (
    SURE_M,
    Play,
    astray,
    blink,
    by_palm,
    changed_asker,
    faulty,
    hold,
    jump_then_three,
    latch,
    outlast,
    second_operator,
    unmoved,
    unswung,
    usurped,
)
from tests.faults.process_plays import (
    close_page,
    kill_console,
    kill_control,
    kill_remote,
    late_page,
    pause_driver,
)
from tests.faults.reach_plays import reach_out, start_outside, sweep_wrist, wander
from tests.faults.viewer_plays import watch_in_crowds


@dataclass(frozen=True)
class Row:
    """A fault, and the `settings` of the remote site that its pair needs; `protocol` is what hand and state go by.

    `quick` ones are played in every run of the tests too. Unless `engaged`, the play begins before any engagement.
    """

    fault: str
    expected: str
    play: Play
    settings: tuple[str, ...] = ()
    quick: bool = False
    engaged: bool = True
    protocol: str = "tcp"


LATCHES, FAULTS = "STOP by age, LATCH", "LATCH; never cleared by itself"
RESTART = CellPair.start_local
AUTOMATIC = ("engagement.mode=automatic", f"engagement.automatic_accepted={ACCEPTANCE}")
HELD = ("engagement.mode=hold_to_run",)
WATCHED = ('video.cameras=[{name="front_high"},{name="front_low"},{name="side"},{name="gripper"}]', "video.quality=100")
VIEWED = ('video.cameras=[{name="side"}]', "video.width=320", "video.height=240")
NARROW = ("robot.position_deg.joint_1=[-20,20]",)
BEYOND = (*NARROW, "driver.options.stands_at=0.4363 0 -0.7854 0 -0.7854 0")
LONG_S = float(os.environ.get("FARHAND_FAULTS_LONG_S", "600"))
WELL = hand(camera="")
ENDLESS = "\ud83e is half a character, " * 75
# fmt: off
ROWS = (
    Row("hand lost", "STOP at once, LATCH after 500 ms", latch(hand(lost=True), hand(lost=False), says="as scripted"), quick=True),
    Row("camera unplugged", LATCHES, latch(hand(camera="unplugged"), RESTART)),
    Row("camera gives nothing", LATCHES, latch(hand(camera="off"), WELL, says="left")),
    Row("camera frozen", LATCHES, latch(hand(camera="stuck"), WELL, says="left")),
    Row("camera slow", "STOP while it lasts", hold(hand(camera="slow"), WELL, 2.0)),
    Row("local process killed -9", LATCHES, latch(kill_local, RESTART, says="old")),
    Row("control process killed -9", "the driver's process stops the arm; restart disengaged", kill_control, settings=AUTOMATIC),
    Row("control process stalls 200 ms", "the driver's process begins the stop; continue", blink(control_gets(SIGSTOP), control_gets(SIGCONT), 0.2)),
    Row("driver's process pauses 80 ms, position arm", "goes on from where it was sent, in no longer steps", pause_driver(0.08), settings=("driver.name=recorded_arm",)),
    Row("remote site killed -9", "the robot's own watchdog stops it; restart disengaged", kill_remote, settings=("driver.name=c500c",)),
    Row("remote site restarted with the gripper holding", "the gripper keeps what it holds until a toggle", restart_while_holding, settings=("driver.name=c500c",)),
    Row("gripper's link is down while it is told to open, then stop, reset, engage", "withdrawn; the gripper keeps what it holds", miss_an_order, settings=("driver.name=gripping",)),
    Row("samples count more openings than a hand can make", "a new baseline; gripper and arm stay, control goes on", uncounted(lambda pair: counting_ones(pair, 2.0))),
    Row("partition 100 ms", "continue or STOP, no catch-up", blink(impair(cut=True), impair(), 0.1)),
    Row("partition 1 s", "LATCH, no backlog, path back under 2 s", partition(1.0)),
    Row("partition 10 s", "LATCH, no backlog, path back under 2 s", partition(10.0)),
    Row("reordered, duplicated, late packets", "the arm follows", blink(impair(delay_ms=15, jitter_ms=15, reorders=True, doubled=0.3), impair(), 10.0)),
    Row("duplicated, overtaken, late samples", "dropped", unmoved(lambda pair: old_ones(pair, 1.0), "old")),
    Row("wall clock + 1 h", "nothing changes", blink(lambda pair: pair.step_wall_clock(3600), lambda _: None, 1.0)),
    Row("wall clock - 1 h", "nothing changes", blink(lambda pair: pair.step_wall_clock(-3600), lambda pair: pair.step_wall_clock(0), 1.0)),
    Row("malformed, oversized, hostile payloads", "dropped by the link or rejected and counted, no crash", unmoved(lambda pair: hostile_ones(pair, 1.0), "malformed", "invalid")),
    Row("NaN or infinity", "rejected at decode", unmoved(lambda pair: infinite_ones(pair, 0.5), "not_finite"), quick=True),
    Row("wrist jumps 1 m", "rejected; three LATCH; motion under 1 mm", jump_then_three, quick=True),
    Row("index and thumb are taken for each other", "the orientation is withheld, no swing, no drift", unswung(hand(swapped=True), hand(swapped=False), 1.5)),
    Row("an inferred thumb is on the wrong side", "the orientation is withheld, no swing, no drift", unswung(hand(swapped=True, inferred=True), hand(swapped=False, inferred=False), 1.5), quick=True),
    Row("the palm, which the tool copies, is known to 300 mm", "STOP at once, LATCH after 500 ms", by_palm(latch(hand(palm_sigma_m=0.3), hand(palm_sigma_m=SURE_M), says="the palm is known to")), settings=("mapping.point=palm",), engaged=False),
    Row("unreachable target", "leashed, reported, no thrash", reach_out((0, -3.0, 0, 0, 0, 0), 3.5, "saturated", "out_of_reach")),
    Row("singularity", "speed within limits, can back out", sweep_wrist),
    Row("self- or table collision", "never below the margin, can retreat", wander(60.0)),
    Row("joint limit", "stop at the margin, can retreat", reach_out((0.35, 0, 0, 0, 0, 0), 1.5, "ik_limit", "position"), settings=NARROW),
    Row("started beyond a joint limit", "only retreat", start_outside, settings=BEYOND, engaged=False),
    Row("second operator", "refused with the holder's name, fenced", second_operator(lambda pair: foreign_ones(pair, 1.0))),
    Row("another operator sends under the holder's lease", "refused by the name in the key, the arm stays", usurped(lambda pair: usurping_ones(pair, 1.0)), protocol="tls"),
    Row("consent for another", "void, with the name of who asks now", changed_asker, protocol="tls"),
    Row("70 viewers connect, and the process that serves them is killed", "follows; stops are answered, also that of a new session; the site goes on", watch_in_crowds, protocol="tls"),
    Row("2000 samples a second without the lease", "refused, the arm follows", outlast(lambda pair: flood(pair, 5.0), 0.95)),
    Row("a recorder of the next release writes an unknown field and an alarm of 1000 characters", "refused or cut, and told; the arm follows", record_strangely),
    Row("the operator's clock is slewed by 8 %", "the arm follows; ages are true; video and site live", slew_the_operator, settings=VIEWED),
    Row("driver raises", "LATCH, the loop ticks", faulty(robot(raises=True), robot(raises=False), says="ZeroDivisionError")),
    Row("driver blocks 200 ms", "deadline 50 ms, LATCH, the loop ticks", faulty(robot(blocks_ms=200), robot(), says="ms", more_s=0.2)),
    Row("robot reports a fault", "code mirrored, " + FAULTS, faulty(robot(fault="robot"), robot(fault=""), says="robot (E42)"), quick=True),
    Row("robot's fault is explained by 2000 characters", "cut, and " + FAULTS, faulty(robot(fault="robot", sentence=ENDLESS), robot(fault="", sentence="-"), says="…")),
    Row("robot reads NaN", "not_finite, " + FAULTS, faulty(robot(misreads="nan"), robot(misreads=""), says="not_finite")),
    Row("robot reads a joint off by 1 rad for 8 ms", "implausible at once, " + FAULTS, faulty(robot(misreads="jumped"), robot(misreads=""), says="implausible")),
    Row("robot's reading freezes", "silent after 100 ms, " + FAULTS, faulty(robot(misreads="frozen"), robot(misreads=""), says="silent", within_s=0.15)),
    Row("arm does not follow", "not_following within 1 s, names the joint, " + FAULTS, astray),
    Row("hardware e-stop reported", "no commands, LATCH, needs reset and engage", faulty(robot(fault="emergency_stop"), robot(fault=""), says="emergency_stop", silent=True)),
    Row("console tab closed", "STOP, LATCH within 500 ms", close_page, settings=HELD, engaged=False),
    Row("all reports of the page come 3 s late", "its key moves nothing", late_page, settings=HELD, engaged=False),
    Row("key pressed again while stopped, then reset", "STOP; the reset moves nothing, a new press does", reset_under_key, settings=HELD, engaged=False),
    Row("a stop behind a reset", "stays stopped until a reset by who was shown that stop", stop_behind_reset, protocol="tls"),
    Row("video process killed, engaged automatically", "STOP; restart disengaged", kill_video, settings=AUTOMATIC),
    Row("the remote site restarts in another mode during a path", "STOP; the arm stays without a key, the path's program ends", restart_in_another_mode(*AUTOMATIC), settings=HELD, engaged=False),
    Row("a sample every 170 ms", "STOP, LATCH after the longest hold", trickle),
    Row("hand first seen after a minute, automatic", "nothing engages", late_hand, settings=AUTOMATIC, engaged=False),
    Row("the console restarts while z is locked", "HOLD until a page reports again; z stays locked", kill_console),
    Row("the page falls silent while the clutch is held", "HOLD, then LATCH; nothing engages until it was pressed again and let go", silent_clutch),
    Row("the clutch is let go while the hand moves", "HOLD, then LATCH", restless_release),
    Row("200 ms jitter", "bounded slow-down, no late sample used", bear(60.0, 0.0, delay_ms=100, jitter_ms=100)),
    Row("video fills 20 Mbit/s, 20 ms each way", "pose p99 at most 1.3 times that without video", crowd(20.0, 20.0, 20.0), settings=WATCHED),
    Row("5 % loss, 20 ms each way, by TCP", "never latches", bear(60.0, 0.9, loss=0.05, delay_ms=20)),
    Row("5 % loss, 20 ms each way, by QUIC", "no latch in 10 min, tracking error at most + 10 %", lose(0.05, 20.0, LONG_S), protocol="quic"),
    Row("80 ms each way, 20 % jitter, 1 % loss, by QUIC", "follows, at most 2 changes a second", far(30.0, 0.995, delay_ms=80, jitter_ms=16, loss=0.01), protocol="quic", engaged=False),
    Row("hand lost, 80 ms each way", "STOP within its bound, LATCH", over(latch(hand(lost=True), hand(lost=False), says="as scripted"), delay_ms=80), engaged=False),
    Row("partition 1 s, 80 ms each way", "LATCH, no backlog, path back under 2 s", over(partition(1.0, delay_ms=80), delay_ms=80), engaged=False),
    Row("cut of 300 ms, 40 ms each way", "HOLD, follows within 1 s", cut_shortly(0.3, delay_ms=40), protocol="quic", engaged=False),
    Row("delay jumps from 20 to 120 ms", "one hold at most, follows within 2 s", jump_of_delay((20.0, 120.0), 20.0), protocol="quic", engaged=False),
    Row("190 ms each way", "does not engage, and says why", too_far, engaged=False),
)
# fmt: on
