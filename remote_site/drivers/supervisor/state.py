"""The states of the driver supervisor and its transition table; pure."""

from enum import Enum, auto


class SupervisorState(Enum):
    """The supervisor's state: how near the robot is to taking commands.

    "The stop" is the verified, jerk-limited one that the supervisor plans and writes itself; `Driver.stop` leaves
    stopping to the robot. A call of the driver fails when it raises or exceeds its deadline; a reading is bad when it
    cannot be true (`ReadingCheck`). Events that a state does not list change nothing. A latched fault that is not calm
    is kept when another fault follows.

    ===========  ====================  =======================================  ==========  ===========================
    row          state                 event [guard]                            next        action
    ===========  ====================  =======================================  ==========  ===========================
    activate     INACTIVE, ACTIVATING  activation [arm at rest]                 ACTIVATING  Driver.activate
    rejected     INACTIVE, ACTIVATING  activation [arm at rest, call fails]     IDLE        Driver.stop, fault
    arm_moves    INACTIVE, ACTIVATING  activation [arm measured moving]         same        fault REFUSED
    unread       INACTIVE              activation [no good reading]             same        fault
    elsewhere    INACTIVE              activation [arm measured elsewhere]      same        fault APART
    withdrawn    ACTIVATING            activation [either of these]             IDLE        Driver.stop, fault
    too_early    DRIVEN                activation                               STOPPING    begin stop, REFUSED
    answered     ACTIVATING            reading [no fault, arm at q0]            FOLLOWING   clear fault
    apart        ACTIVATING            reading [no fault, arm elsewhere]        IDLE        Driver.stop, APART
    refused      ACTIVATING            reading [fault, not calm]                HELD        fault of the robot
    waits        ACTIVATING            reading [calm fault]                     same        none
    command      FOLLOWING             command [within limits]                  same        schedule it
    over_limit   FOLLOWING             command [guard refuses]                  STOPPING    begin stop, LIMITS
    outdated     ACTIVE                command [other stop_count]               same        note control is alive
    hand_over    BRAKING               command [meets the stop at its time]     FOLLOWING   end stop, schedule it
    missed       BRAKING               command [elsewhere, or written past it]  same        stop_count + 1
    stop_order   ACTIVE                order to stop                            STOPPING    begin stop, STOPPED
    late         FOLLOWING             no command for 3 ticks [in motion]       BRAKING     begin stop, stop_count + 1
    late_rest    ACTIVE                no command for 3 ticks [at rest]         same        write the motion again
    silent       ACTIVE                no order for the time-out                STOPPING    begin stop, COMMAND_TIMEOUT
    slow         ACTIVATING, ACTIVE    no turn in time for a second             IDLE        Driver.stop, DEADLINE
    stopped      STOPPING              stop written to its end, robot settled   HELD        Driver.stop
    robot_fault  DRIVEN                reading [fault]                          IDLE        Driver.stop, fault
    bad_reading  ACTIVATING, DRIVEN    reading [bad]                            IDLE        Driver.stop, fault
    bad_at_rest  INACTIVE              reading [bad]                            same        fault
    astray       DRIVEN                reading [arm off what was written]       IDLE        Driver.stop, NOT_FOLLOWING
    call_fails   ACTIVATING, DRIVEN    read or write fails                      IDLE        Driver.stop, fault
    read_fails   INACTIVE              read fails [not a first one refused]     same        fault
    ===========  ====================  =======================================  ==========  ===========================

    "Begin stop" in BRAKING keeps the stop that is under way. INACTIVE, ACTIVE and DRIVEN are the sets below.
    """

    IDLE = auto()  # not led: the reported motion is the robot as measured
    HELD = auto()  # not led any more: the reported motion is still the last one written
    ACTIVATING = auto()  # the driver was asked to activate, the robot has not answered yet
    FOLLOWING = auto()  # control's commands are written
    BRAKING = auto()  # commands were late: the stop is written, and control may continue from within it
    STOPPING = auto()  # the stop is written, and only an activation moves the robot again


INACTIVE = frozenset({SupervisorState.IDLE, SupervisorState.HELD})
ACTIVE = frozenset({SupervisorState.FOLLOWING, SupervisorState.BRAKING})
DRIVEN = ACTIVE | {SupervisorState.STOPPING}
