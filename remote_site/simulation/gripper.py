"""The two-finger gripper of the simulated cell: body, fingers, one force-limited drive for both."""

import mujoco

from remote_site.simulation.config import GripperConfig

GRIP = "grip"
THINGS = 1
TOUCHES_ROBOT = 2

STIFFNESS_N_M = 4000.0
DAMPING_N_S_M = 60.0
FINGER_THICKNESS_M = 0.008
FINGER_HEIGHT_M = 0.022
DARK = (0.17, 0.19, 0.23, 1.0)
STEEL = (0.62, 0.65, 0.68, 1.0)
PAD = (0.95, 0.55, 0.15, 1.0)


def add_gripper(spec: mujoco.MjSpec, tool: mujoco.MjsBody, config: GripperConfig) -> None:
    """Mount the gripper on the tool frame, its fingers pointing along the tool's z and closing along y.

    The opening (m) is the tendon `grip`; its drive holds a commanded opening with at most `force_limit_n`.
    """
    body = tool.add_body(name="gripper_body")
    _add_housing(body, config)
    tendon = spec.add_tendon(name=GRIP)
    for side, name in ((1.0, "finger_left"), (-1.0, "finger_right")):
        _add_finger(body, name, side, config)
        tendon.wrap_joint(name, 1.0)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1="finger_left",
        name2="finger_right",
        data=[0, 1, *[0] * 10],
        solref=[0.004, 1.0],
    )
    drive = spec.add_actuator(name=GRIP, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=GRIP)
    drive.set_to_position(kp=STIFFNESS_N_M, kv=DAMPING_N_S_M)
    drive.forcelimited = True
    drive.forcerange = [-config.force_limit_n, config.force_limit_n]


def _add_housing(body: mujoco.MjsBody, config: GripperConfig) -> None:
    box, cylinder = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
    neck, block = 0.4 * config.body_length_m, 0.6 * config.body_length_m
    half = {"contype": TOUCHES_ROBOT, "conaffinity": THINGS}
    body.add_geom(
        type=cylinder,
        size=[0.028, neck / 2, 0],
        pos=[0, 0, neck / 2],
        rgba=STEEL,
        mass=0.3 * config.body_mass_kg,
        **half,
    )
    body.add_geom(
        type=box,
        size=[0.026, 0.052, block / 2],
        pos=[0, 0, neck + block / 2],
        rgba=DARK,
        mass=0.7 * config.body_mass_kg,
        **half,
    )


def _add_finger(body: mujoco.MjsBody, name: str, side: float, config: GripperConfig) -> None:
    half_opening = config.max_opening_m / 2.0
    finger = body.add_body(name=name, pos=[0, 0, config.body_length_m])
    finger.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[0, side, 0],
        range=[0.0, half_opening],
        ref=half_opening,
        damping=[5.0, 0, 0],
    )
    finger.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[FINGER_HEIGHT_M / 2, FINGER_THICKNESS_M / 2, config.finger_length_m / 2],
        pos=[0, side * (half_opening + FINGER_THICKNESS_M / 2), config.finger_length_m / 2],
        rgba=PAD,
        mass=config.finger_mass_kg,
        friction=[config.friction, 0.02, 0.001],
        condim=4,
        solref=[0.004, 1.0],
        solimp=[0.97, 0.995, 0.001, 0.5, 2],
        priority=1,
        contype=TOUCHES_ROBOT,
        conaffinity=THINGS,
    )
