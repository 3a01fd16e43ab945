"""The simulated cell: physics, robot controller, scenery."""

import os

# MuJoCo would otherwise load a windowing library on import; views are rendered through EGL, opened by the video process
# alone, after its fork.
os.environ["MUJOCO_GL"] = "disable"
