"""The course of the task: grasp, place, retreat; and anew."""

from lab.visual_operator.stages import Course


def names(course, count):
    seen = []
    for _ in range(count):
        seen.append(course.stage.name)
        course.advance()
    return seen


def test_the_steps_come_in_the_order_of_the_task_and_end():
    course = Course()
    steps = ["above", "behind", "reach", "lift", "carry", "align", "lower", "retreat"]
    assert names(course, len(steps)) == steps
    assert not course.advance()


def test_a_step_that_asks_for_two_looks_counts_only_those_in_a_row():
    course = Course()
    names(course, 5)
    assert course.stage.name == "align"
    assert [course.seen(reached) for reached in (True, False, True, True)] == [False, False, False, True]


def test_anew_begins_with_the_first_step():
    course = Course()
    names(course, 4)
    assert course.holding
    course.restart()
    assert course.stage.name == "above"
    assert not course.holding
