"""The Pioneer 3-DX with one of two bases, ready to be put into a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from twonav_cli.config import BASES
from twonav_cli.errors import unknown_name
from twonav_cli.paths import scenes_dir
from twonav_cli.scene.engine import mujoco

PREFIX = "twonav-"
"""Mark of everything that belongs to the robot in a model that holds scene and robot."""

WHEEL_RADIUS_M = 0.0975
TRACK_M = 0.33
"""Distance between the middles of the wheels."""

PLANE_AXES: tuple[tuple[str, tuple[float, float, float], bool], ...] = (
    ("plane_x", (1.0, 0.0, 0.0), False),
    ("plane_y", (0.0, 1.0, 0.0), False),
    ("plane_turn", (0.0, 0.0, 1.0), True),
)
"""Joints of the omnidirectional base: name, axis in the world, whether it turns."""

ANSWER_S = 0.004
"""Time in which the omnidirectional base's servos answer (ours: two physics steps)."""

PUSH_N = 90.0
"""Largest force of the omnidirectional base (ours: what 9 kg can press against a floor at friction 1)."""

TURN_NM = 18.0
"""Largest torque of the omnidirectional base (ours: PUSH_N at 0.2 m)."""

MASS_KG = 9.0
TURN_INERTIA_KGM2 = 0.2
"""Of the whole robot about the vertical through the axle."""


def robot_path() -> Path:
    """Return the robot's own MJCF file."""
    return scenes_dir() / "robots" / "pioneer3dx.xml"


def robot_spec(base: str) -> Any:
    """Return the robot as an MjSpec whose origin is on the floor below the axle.

    Args:
        base: "omni" (the paper's base: moves in any direction, slides on the plane of the floor) or
            "differential" (two driven wheels and a caster).

    Raises:
        TwonavError: There is no such base.
    """
    if base not in BASES:
        raise unknown_name("base", base, BASES)
    spec = mujoco.MjSpec.from_file(str(robot_path()))
    if base == "omni":
        _put_on_plane(spec)
    return spec


def _put_on_plane(spec: Any) -> None:
    """Replace free joint, wheel joints and wheel motors by three joints of the plane with velocity servos."""
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for joint in list(spec.joints):
        spec.delete(joint)
    for name in ("tread_left", "tread_right", "caster"):
        spec.geom(name).contype = 0
        spec.geom(name).conaffinity = 0
    chassis = spec.body("chassis")
    for name, axis, turns in PLANE_AXES:
        kind = mujoco.mjtJoint.mjJNT_HINGE if turns else mujoco.mjtJoint.mjJNT_SLIDE
        chassis.add_joint(name=name, type=kind, axis=axis)
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        limit = TURN_NM if turns else PUSH_N
        actuator.set_to_velocity(kv=(TURN_INERTIA_KGM2 if turns else MASS_KG) / ANSWER_S)
        actuator.forcerange = (-limit, limit)
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
