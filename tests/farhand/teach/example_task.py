"""A task as teaching writes it, for the tests."""

from farhand.teach.task_file import TaskFile, TaskMotion, TaskOrigin, TaughtFrame, WayPoint

TASK = TaskFile(
    task=TaskOrigin(
        name='a "peg" \\ of ours', robot="a465", recorded="x.mcap, episode 2", gripper_at_start="open", tolerance_mm=2
    ),
    frame=TaughtFrame(xyz_mm=(100.25, -3.5, 20.0), rpy_deg=(0.0, 0.0, 90.0)),
    motion=TaskMotion(speed_mm_s=80.0, blend_mm=0.0),
    waypoints=(
        WayPoint(xyz_mm=(0.0, 0.0, 50.0), rotation_deg=(0.0, 90.0, 0.0)),
        WayPoint(xyz_mm=(0.0, 0.0, 0.0), rotation_deg=(0.0, 90.0, 0.0), gripper="closed", dwell_s=0.5, speed=0.25),
    ),
)
