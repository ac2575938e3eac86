import math

import mujoco
import numpy as np
import pytest
from conftest import MakeScene

from twonav_cli.config import ROBOT_FOOTPRINT_M, ROBOT_HEIGHT_M
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, Twist
from twonav_cli.scene.robot import BASES
from twonav_cli.scene.world import World

STAND = Twist(0.0, 0.0, 0.0)


@pytest.fixture(params=BASES)
def base(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def upright(world: World) -> float:
    return float(world.data.xmat[world.chassis_id][8])


@pytest.mark.parametrize("floor_m", [-0.1, 0.0, 0.3])
def test_a_placed_robot_is_where_it_was_put_and_stays_there(make_scene: MakeScene, base: str, floor_m: float) -> None:
    world = World(make_scene(floor_m), base)
    world.place(Pose(0.3, -0.4, 2.5))
    assert world.pose() == pytest.approx((0.3, -0.4, 2.5), abs=1e-12)
    assert world.twist() == STAND
    world.drive(STAND, 0.5)
    assert world.pose() == pytest.approx((0.3, -0.4, 2.5), abs=1e-3)
    assert world.data.xpos[world.chassis_id][2] == pytest.approx(floor_m, abs=1e-3)
    assert world.touching() == []


def test_a_metre_forward_is_a_metre(make_scene: MakeScene, base: str) -> None:
    world = World(make_scene(), base)
    world.place(Pose(-0.5, 0.2, 0.0))
    world.drive(Twist(0.5, 0.0, 0.0), 2.0)
    assert world.twist() == pytest.approx((0.5, 0.0, 0.0), abs=0.01)
    world.drive(STAND, 0.5)
    assert world.pose() == pytest.approx((0.5, 0.2, 0.0), abs=0.03)
    assert world.time_s == pytest.approx(2.5)


@pytest.mark.parametrize("turn", [-1.0, 1.0])
def test_a_quarter_turn_is_a_quarter_turn(make_scene: MakeScene, base: str, turn: float) -> None:
    world = World(make_scene(), base)
    world.place(Pose(0.0, 0.0, 0.0))
    world.drive(Twist(0.0, 0.0, turn * math.pi / 2), 1.0)
    world.drive(STAND, 0.5)
    assert world.pose() == pytest.approx((0.0, 0.0, turn * math.pi / 2), abs=0.03)


def test_a_circle_ends_where_it_began(make_scene: MakeScene, base: str) -> None:
    world = World(make_scene(), base)
    world.place(Pose(0.0, -0.5, 0.0))
    world.drive(Twist(0.5, 0.0, 1.0), math.pi)
    assert world.pose().y_m == pytest.approx(0.5, abs=0.05)
    world.drive(Twist(0.5, 0.0, 1.0), math.pi)
    assert world.pose()[:2] == pytest.approx((0.0, -0.5), abs=0.05)


def test_only_the_omnidirectional_base_moves_sideways(make_scene: MakeScene, base: str) -> None:
    world = World(make_scene(), base)
    world.place(Pose(0.0, -0.4, math.pi / 2))
    world.drive(Twist(0.0, 0.4, 0.0), 2.0)
    assert world.pose().x_m == pytest.approx(-0.8 if base == "omni" else 0.0, abs=0.03)
    assert world.pose().y_m == pytest.approx(-0.4, abs=0.01)


def test_a_wall_stops_the_robot_without_sinking_in_or_jumping(make_scene: MakeScene, base: str) -> None:
    world = World(make_scene(), base)
    world.place(Pose(1.2, 0.0, 0.0))
    fronts = []
    for _ in range(30):
        world.drive(Twist(0.6, 0.0, 0.0), 0.1)
        fronts.append(world.pose().x_m + 0.208)
        assert upright(world) > 0.999
        assert world.data.xpos[world.chassis_id][2] == pytest.approx(0.0, abs=2e-3)
    assert max(fronts) < 2.003
    assert min(fronts[10:]) > 1.99
    assert world.touching() == ["wall_right"]
    assert world.twist() == pytest.approx((0.0, 0.0, 0.0), abs=0.02)


def test_contacts_name_the_geom_or_its_body_and_never_the_floor(make_scene: MakeScene, base: str) -> None:
    rug = '<geom name="rug" type="box" size="0.8 0.8 0.005" pos="0 0 0.005"/>'
    chair = '<body name="chair" pos="1 0.9 0.2"><geom type="box" size="0.2 0.2 0.2"/></body>'
    nameless = '<geom type="box" size="0.2 0.2 0.2" pos="-1 0.9 0.2"/>'
    world = World(make_scene(more=rug + chair + nameless), base)
    world.place(Pose(0.0, 0.0, 0.0))
    world.drive(STAND, 0.2)
    assert world.touching() == []
    world.place(Pose(0.75, 0.9, 0.0))
    assert world.touching() == ["chair"]
    world.place(Pose(-0.75, 0.9, 0.0))
    assert world.touching()[0].startswith("geom ")


def test_what_collides_lies_inside_the_outline_that_is_planned_with(make_scene: MakeScene) -> None:
    world = World(make_scene(), "differential")
    world.place(Pose(0.0, 0.0, 0.0))
    solid = np.flatnonzero(world.is_robot & (np.asarray(world.model.geom_contype) != 0))
    outline = np.array(ROBOT_FOOTPRINT_M)
    edges = np.roll(outline, -1, axis=0) - outline
    assert len(solid) == 6
    for geom in solid:
        box, rotation = world.model.geom_aabb[geom], world.data.geom_xmat[geom].reshape(3, 3)
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        corners = world.data.geom_xpos[geom] + (box[:3] + signs * box[3:]) @ rotation.T  # [8, 3]
        inward = corners[:, None, :2] - outline  # [8, edges, 2]
        assert (edges[:, 0] * inward[..., 1] - edges[:, 1] * inward[..., 0] > 0).all()
        assert corners[:, 2].max() < ROBOT_HEIGHT_M


def test_the_same_drive_gives_the_same_pose_whatever_happened_before(make_scene: MakeScene, base: str) -> None:
    world = World(make_scene(), base)
    ends = []
    for detour in (False, True):
        if detour:
            world.place(Pose(1.0, 0.8, 1.0))
            world.drive(Twist(0.6, 0.1, 1.0), 1.5)
        world.place(Pose(-0.4, 0.1, 0.3))
        for _ in range(10):
            world.drive(Twist(0.4, 0.1, 0.7), 0.1)
        ends.append(world.pose())
    assert ends[0] == ends[1]


def test_the_physics_of_the_scene_does_not_break_the_robot(make_scene: MakeScene) -> None:
    world = World(make_scene())
    assert world.model.opt.timestep == 0.002
    assert world.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert tuple(world.model.opt.gravity) == (0.0, 0.0, -9.81)


def test_an_unknown_base_is_answered_with_the_right_ones(make_scene: MakeScene) -> None:
    with pytest.raises(TwonavError, match="omni, differential"):
        World(make_scene(), "tracked")
