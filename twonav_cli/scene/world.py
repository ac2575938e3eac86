"""A scene with the robot in it: put it somewhere, drive it, ask what it touches."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import OBSTACLE_FLOOR_M
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, Twist, wrap_angle
from twonav_cli.scene.compiled_scene import LOAD_ERRORS, one_line
from twonav_cli.scene.engine import mujoco
from twonav_cli.scene.robot import PLANE_AXES, PREFIX, TRACK_M, WHEEL_RADIUS_M, robot_spec

if TYPE_CHECKING:
    from twonav_cli.scene.catalog import Scene

TIMESTEP_S = 0.002
TURN_UPDATE_S = 0.01
"""How often the omnidirectional base's velocities are turned into the world while it turns."""

GRAVITY_MPS2 = 9.81
NEAR_M = 0.02
"""Nothing nearer to the camera is drawn; 9 cm lie between the lens and the robot's front."""

FAR_M = 100.0


def compile_with_robot(scene: Scene, base: str) -> Any:
    """Return the compiled model of a scene with the robot attached and the physics and drawing settings of ours.

    Raises:
        TwonavError: MuJoCo refuses the scene, or there is no such base.
    """
    robot = robot_spec(base)
    try:
        spec = mujoco.MjSpec.from_file(str(scene.xml_path))
        frame = spec.worldbody.add_frame(pos=(0.0, 0.0, scene.floor_z_m))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # attaching warns that the scene's options win; ours are set below
            spec.attach(robot, prefix=PREFIX, frame=frame)
        _set_options(spec)
        model = spec.compile()
    except LOAD_ERRORS as error:
        raise TwonavError(f"{scene.xml_path} cannot be loaded with the robot in it: {one_line(error)}") from error
    model.geom_margin[:] = 0.0  # a margin of the scene's floor would lift the robot by it
    model.vis.map.znear = NEAR_M / model.stat.extent
    model.vis.map.zfar = FAR_M / model.stat.extent
    return model


def _set_options(spec: Any) -> None:
    """Set the physics that the robot needs and the cheapest drawing: no shadow map, no multisampling."""
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.iterations = 100
    spec.option.gravity = (0.0, 0.0, -GRAVITY_MPS2)
    spec.option.disableflags = 0
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.offsamples = 0
    spec.visual.quality.numquads = 1


class World:
    """MuJoCo's model and state of a scene with one robot.

    Attributes:
        scene: What was loaded.
        base: "omni" or "differential".
        model: MuJoCo's model of scene and robot.
        data: MuJoCo's state.
        chassis_id: The robot's body.
        is_robot: [geoms] which geoms are the robot's.
        is_plane: [geoms] which geoms are planes.
    """

    def __init__(self, scene: Scene, base: str = "omni") -> None:
        self.scene = scene
        self.base = base
        self.model = compile_with_robot(scene, base)
        self.data = mujoco.MjData(self.model)
        self.chassis_id: int = self.model.body(PREFIX + "chassis").id
        joint = self.model.joint(PREFIX + ("plane_x" if base == "omni" else "free"))
        self._qpos = int(joint.qposadr[0])
        self._qvel = int(joint.dofadr[0])
        names = [name for name, _, _ in PLANE_AXES] if base == "omni" else ["wheel_left", "wheel_right"]
        self._motors = np.array([self.model.actuator(PREFIX + name).id for name in names])
        root = np.asarray(self.model.body_rootid)[np.asarray(self.model.geom_bodyid)]
        self.is_robot: NDArray[np.bool_] = np.asarray(root == self.chassis_id)
        self.is_plane: NDArray[np.bool_] = np.asarray(self.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)
        self.place(next(iter({**scene.starts, **scene.goals}.values())))

    @property
    def time_s(self) -> float:
        """Simulated time since the world was made."""
        return float(self.data.time)

    def place(self, pose: Pose) -> None:
        """Put everything back as the scene has it, and the robot upright and at rest on the floor at `pose`.

        Whether it fits there is not asked; `touching` tells. The clock goes on.
        """
        time_s = self.data.time
        mujoco.mj_resetData(self.model, self.data)
        self.data.time = time_s
        q = self._qpos
        if self.base == "omni":
            self.data.qpos[q : q + 3] = pose
        else:
            half_rad = pose.theta_rad / 2
            self.data.qpos[q : q + 3] = (pose.x_m, pose.y_m, self.scene.floor_z_m)
            self.data.qpos[q + 3 : q + 7] = (math.cos(half_rad), 0.0, 0.0, math.sin(half_rad))
        mujoco.mj_forward(self.model, self.data)

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Drive with a velocity for a time, rounded to whole physics steps.

        Args:
            twist: In the robot's frame. The differential base has no sideways speed and ignores it.
            duration_s: How long; at least one step of 2 ms is taken.

        Raises:
            TwonavError: The physics diverged.
        """
        steps = max(1, round(duration_s / TIMESTEP_S))
        if self.base == "omni":
            self._drive_on_plane(twist, steps)
        else:
            turn_mps = twist.turn_radps * TRACK_M / 2
            speeds = (twist.forward_mps - turn_mps, twist.forward_mps + turn_mps)
            self.data.ctrl[self._motors] = np.divide(speeds, WHEEL_RADIUS_M)
            mujoco.mj_step(self.model, self.data, nstep=steps)
        if self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            raise TwonavError(f"the physics of {self.scene.xml_path} diverged: look for bodies that overlap in it")
        # Steps leave the bodies where they were before the last one; camera and rays look from where they are now.
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def _drive_on_plane(self, twist: Twist, steps: int) -> None:
        """Drive the omnidirectional base; while it turns, its velocity in the world is renewed every 10 ms."""
        turning = twist.turn_radps != 0.0 or abs(self.data.qvel[self._qvel + 2]) > 1e-3
        chunk = round(TURN_UPDATE_S / TIMESTEP_S) if turning else steps
        while steps > 0:
            taken = min(chunk, steps)
            # the heading in the middle of the chunk, so that an arc is followed without drifting outward
            heading_rad = self.data.qpos[self._qpos + 2] + twist.turn_radps * taken * TIMESTEP_S / 2
            cos, sin = math.cos(heading_rad), math.sin(heading_rad)
            self.data.ctrl[self._motors] = (
                cos * twist.forward_mps - sin * twist.left_mps,
                sin * twist.forward_mps + cos * twist.left_mps,
                twist.turn_radps,
            )
            mujoco.mj_step(self.model, self.data, nstep=taken)
            steps -= taken

    def pose(self) -> Pose:
        """Return where the robot is: the middle of its axle, in the map frame."""
        q = self._qpos
        x_m, y_m = float(self.data.qpos[q]), float(self.data.qpos[q + 1])
        if self.base == "omni":
            return Pose(x_m, y_m, wrap_angle(float(self.data.qpos[q + 2])))
        w, x, y, z = (float(value) for value in self.data.qpos[q + 3 : q + 7])
        return Pose(x_m, y_m, wrap_angle(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))))

    def twist(self) -> Twist:
        """Return how the robot moves, in its own frame."""
        v = self._qvel
        theta_rad = self.pose().theta_rad
        turn_radps = float(self.data.qvel[v + (2 if self.base == "omni" else 5)])
        x_mps, y_mps = float(self.data.qvel[v]), float(self.data.qvel[v + 1])
        cos, sin = math.cos(theta_rad), math.sin(theta_rad)
        return Twist(cos * x_mps + sin * y_mps, -sin * x_mps + cos * y_mps, turn_radps)

    def touching(self) -> list[str]:
        """Return the names of what the robot touches, the floor left out: geom, else body, else "geom 12".

        The floor is every contact that is low enough for the robot to drive over it.
        """
        count = self.data.ncon
        if count == 0:
            return []
        pairs = np.asarray(self.data.contact.geom)[:count]  # [contacts, 2]
        height_m = np.asarray(self.data.contact.pos)[:count, 2] - self.scene.floor_z_m
        ours = self.is_robot[pairs] & (pairs >= 0)  # [contacts, 2]; -1 stands for something soft
        counts = (ours.sum(axis=1) == 1) & (height_m > OBSTACLE_FLOOR_M)
        others = np.where(ours[:, 0], pairs[:, 1], pairs[:, 0])[counts]
        return sorted({self._name_of(int(geom)) for geom in others})

    def _name_of(self, geom: int) -> str:
        """Return the name of a geom, else of its body, else its number."""
        if geom < 0:
            return "something soft"
        try:
            body = int(self.model.geom_bodyid[geom])
            return self.model.geom(geom).name or (self.model.body(body).name if body else "") or f"geom {geom}"
        except UnicodeDecodeError:
            return f"geom {geom}"

    def geom_bottoms_m(self) -> NDArray[np.float64]:
        """Return the height of every geom's lowest point [geoms] (of its bounding box); planes have none (-inf)."""
        rotation = np.asarray(self.data.geom_xmat).reshape(-1, 3, 3)
        box = np.asarray(self.model.geom_aabb)  # [geoms, 6] middle and half sizes
        middle_m = self.data.geom_xpos[:, 2] + np.einsum("gj,gj->g", rotation[:, 2], box[:, :3])
        bottom_m = middle_m - np.einsum("gj,gj->g", np.abs(rotation[:, 2]), box[:, 3:])
        return np.where(self.is_plane, -np.inf, bottom_m)
