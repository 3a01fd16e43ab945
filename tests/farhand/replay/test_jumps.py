"""The list of a replay has what a person may want to see again, and nothing of what only comes and goes."""

from farhand.replay.recorded_scene import RecordedEvent, worth_a_jump

SAID = (
    (0.0, "session", "disengaged (site_starting): the site is starting"),
    (0.2, "session", "disengaged (robot_not_ready): the robot is not ready"),
    (0.4, "session", "disengaged (not_engaged): not engaged yet"),
    (2.0, "session", "engaged (ok): the arm follows the hand"),
    (2.0, "episode", "episode 1: begin, unknown"),
    (3.0, "session", "engaged (singular): near a singular posture (condition 119): slowed to 84%"),
    (3.1, "session", "engaged (ok): the arm follows the hand"),
    (4.0, "session", "holding (lost): the hand is lost"),
    (4.5, "session", "engaged (ok): the arm follows the hand"),
    (6.0, "session", "disengaged (stopped): stopped by anna; reset it, then engage"),
    (6.1, "session", "disengaged (stopped): stopped by anna and berta; reset it, then engage"),
    (7.0, "session", "disengaged (reset): reset"),
    (7.5, "session", "disengaged (stopped): stopped by anna; reset it, then engage"),
    (8.0, "session", "fault (fault): the drive has failed"),
    (9.0, "session", "no events are known from here on: damaged"),
)


def test_only_changes_of_the_state_stops_and_episodes_are_listed() -> None:
    found = [(event.at_s, event.kind, event.words) for event in worth_a_jump(RecordedEvent(*said) for said in SAID)]
    assert found == [
        (2.0, "engaged", "engaged: the arm follows the hand"),
        (2.0, "episode", "episode 1: begin, unknown"),
        (4.0, "holding", "holding: the hand is lost"),
        (4.5, "engaged", "engaged: the arm follows the hand"),
        (6.0, "stop", "disengaged: stopped by anna; reset it, then engage"),
        (7.5, "stop", "disengaged: stopped by anna; reset it, then engage"),
        (8.0, "fault", "fault: the drive has failed"),
        (9.0, "session", "no events are known from here on: damaged"),
    ]
