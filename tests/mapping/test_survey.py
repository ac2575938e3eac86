"""The robot surveys a scene by itself."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from true_mapper import TrueMapper

from twonav_cli.config import MappingConfig
from twonav_cli.events import Event, KeyframeMapped, MapDrawn, Note
from twonav_cli.geometry import Pose, distance_m, relative_pose
from twonav_cli.mapping.occupancy import UNKNOWN, OccupancyMap
from twonav_cli.mapping.scan import RangeSensor
from twonav_cli.mapping.survey import Survey, Surveyed
from twonav_cli.mapping.survey_config import SurveyConfig
from twonav_cli.navigation.costmap import LASER_X_M
from twonav_cli.scene.catalog import Scene, read_scene
from twonav_cli.scene.laser import BEAM_ANGLES_RAD, RangeFinder
from twonav_cli.scene.world import World

FLAT = """
<mujoco model="flat">
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="right" type="box" size="0.05 1.6 0.5" pos="2.05 0 0.5"/>
    <geom name="left" type="box" size="0.05 1.6 0.5" pos="-2.05 0 0.5"/>
    <geom name="up" type="box" size="2.1 0.05 0.5" pos="0 1.55 0.5"/>
    <geom name="down" type="box" size="2.1 0.05 0.5" pos="0 -1.55 0.5"/>
    <geom name="above" type="box" size="0.05 {half} 0.5" pos="0.5 {above} 0.5"/>
    <geom name="below" type="box" size="0.05 {half} 0.5" pos="0.5 {below} 0.5"/>
    <site name="goal/west" pos="-1.4 0.2 0"/>
    <site name="start/west" pos="-1.4 0.2 0" euler="0 0 30"/>
  </worldbody>
  <custom><numeric name="twonav.map" data="-2.4 -1.6 2.4 1.6"/></custom>
</mujoco>
"""
USUAL = SurveyConfig()
SMALL = MappingConfig(particles=3, proposal="maximum")
BEHIND = (1.5, 1.2)
"""A place beside the door of the other room."""


@pytest.fixture
def flat(tmp_path: Path):
    """Return a function that makes two rooms with a door of some width between them."""

    def make(door_m: float) -> Scene:
        half = (3.0 - door_m) / 4
        path = tmp_path / "flat.xml"
        path.write_text(FLAT.format(half=half, above=1.5 - half, below=half - 1.5))
        return read_scene(str(path))

    return make


def sensor() -> RangeSensor:
    return RangeSensor(BEAM_ANGLES_RAD, Pose(LASER_X_M, 0.0, 0.0), 8.0)


def told(scene: Scene, config: SurveyConfig = USUAL, base: str = "omni", seed: int = 0) -> Surveyed:
    """Return what is found with a mapper that is told the truth."""
    return Survey(scene, config, SMALL, base, seed, mapper=TrueMapper(scene.map_frame, sensor())).run()


def kind_at(map_: OccupancyMap, place: tuple[float, float]) -> int:
    return int(map_.pixels[map_.frame.cell_at(*place)])


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_the_robot_sees_all_of_both_rooms_and_comes_back(flat, base: str) -> None:
    found = told(flat(1.0), base=base)
    assert found.outcome == "finished"
    inside = found.map.pixels[found.map.frame.cell_at(0, 1.45).row : found.map.frame.cell_at(0, -1.45).row]
    assert (inside[:, 10:86] != UNKNOWN).all()
    assert found.collisions == 0
    start, end = found.truth[0].pose, found.truth[-1].pose
    assert distance_m(start, end) < 0.15
    assert found.driven_m == pytest.approx(9.0, abs=5.0)
    assert found.time_s == found.truth[-1].stamp_s


def test_its_own_map_and_way_are_right_to_a_few_centimetres(flat) -> None:
    scene = flat(1.0)
    found = Survey(scene, SurveyConfig(), SMALL).run()
    assert found.outcome == "finished"
    true = {stamped.stamp_s: stamped.pose for stamped in found.truth}
    assert found.trajectory[0].pose == pytest.approx(next(iter(scene.starts.values())))
    assert max(distance_m(stamped.pose, true[stamped.stamp_s]) for stamped in found.trajectory) < 0.08
    walls = found.map.occupied
    assert walls[found.map.frame.cell_at(0, 1.52).row - 1 : found.map.frame.cell_at(0, 1.45).row + 1, 30].any()
    assert found.map.free[found.map.frame.cell_at(*BEHIND)]


def test_a_room_behind_a_door_that_is_too_narrow_is_left_and_the_survey_ends(flat) -> None:
    found = told(flat(0.3))
    assert found.outcome == "finished"
    assert kind_at(found.map, BEHIND) == UNKNOWN
    assert max(stamped.pose.x_m for stamped in found.truth) < 0.5


def test_the_same_seed_gives_the_same_survey_and_another_seed_another(flat) -> None:
    scene = flat(1.0)
    first, again, other = (Survey(scene, SurveyConfig(sides=0), SMALL, seed=seed).run() for seed in (3, 3, 4))
    assert first.truth == again.truth
    assert first.trajectory == again.trajectory
    assert first.map.digest == again.map.digest
    assert first.trajectory != other.trajectory


def test_the_survey_ends_when_its_time_is_over_or_when_it_is_asked_to_stop(flat) -> None:
    scene = flat(1.0)
    short = told(scene, SurveyConfig(time_limit_s=8.0))
    assert short.outcome == "timed-out"
    assert 8.0 <= short.time_s < 20.0
    survey = Survey(scene, SurveyConfig(), SMALL, mapper=TrueMapper(scene.map_frame, sensor()))
    stopped = survey.run(lambda: True)
    assert stopped.outcome == "stopped"
    assert stopped.time_s < 1.0


def test_looking_again_sees_the_floor_from_more_sides(flat) -> None:
    scene = flat(1.0)
    shares = []
    for sides in (0, 4):
        config = SurveyConfig(sides=sides, near_m=1.0)
        survey = Survey(scene, config, SMALL, mapper=TrueMapper(scene.map_frame, sensor()))
        found = survey.run()
        assert found.outcome == "finished"
        shares.append(survey._near.seen_from(4)[found.map.free].mean())
    assert shares[1] > shares[0] + 0.1


def test_the_mapper_hears_every_period_with_odometry_that_drifts_and_ranges_that_are_noisy(flat) -> None:
    scene = flat(1.0)
    mapper = TrueMapper(scene.map_frame, sensor())
    found = Survey(scene, SurveyConfig(range_noise_m=0.02, sides=0), SMALL, mapper=mapper).run()
    stamps = np.array([reading.stamp_s for reading in mapper.readings])
    assert len(stamps) == len(found.truth)
    assert np.diff(stamps).max() < 0.35
    first, last = mapper.readings[0], mapper.readings[-1]
    assert first.pose_odom == Pose(0.0, 0.0, 0.0)
    moved = relative_pose(found.truth[0].pose, found.truth[-1].pose)
    drift_m = distance_m(moved, last.pose_odom)
    assert 1e-3 < drift_m < 1.0
    world = World(scene)
    world.place(found.truth[0].pose)
    noise_m = first.ranges_m - RangeFinder(world).scan()
    assert np.std(noise_m) == pytest.approx(0.02, rel=0.25)


def test_what_happens_leaves_as_events_with_the_truth_beside_it(flat) -> None:
    seen: list[Event] = []
    found = Survey(flat(1.0), SurveyConfig(sides=0), SMALL, sink=seen.append).run()
    keyframes = [event for event in seen if isinstance(event, KeyframeMapped)]
    assert len(keyframes) == len(found.trajectory)
    assert all(event.pose_true is not None for event in keyframes)
    drawn = [event for event in seen if isinstance(event, MapDrawn)]
    assert drawn[-1].frame == found.map.frame
    assert np.array_equal(drawn[-1].pixels, found.map.pixels)
    said = [event.text for event in seen if isinstance(event, Note)]  # who sends RunEnded says how it ended
    assert said == ["exploring: going to where the known floor ends", "going back to the start"]


def test_a_place_that_is_not_reached_is_tried_again_and_then_left(flat, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = flat(1.0)
    survey = Survey(scene, SurveyConfig(), SMALL, mapper=TrueMapper(scene.map_frame, sensor()))
    tried: list[tuple[float, float]] = []
    go = survey._drive.go

    def never_east(point: tuple[float, float], map_: OccupancyMap) -> bool:
        if point[0] < 0.2:
            return go(point, map_)
        tried.append(point)
        return False

    monkeypatch.setattr(survey._drive, "go", never_east)
    found = survey.run()
    assert found.outcome == "finished"
    assert tried
    cells = [scene.map_frame.cell_at(*point) for point in tried]
    assert max(cells.count(cell) for cell in set(cells)) <= SurveyConfig().tries


def test_nothing_outside_the_area_of_the_map_is_looked_for(flat, tmp_path: Path) -> None:
    flat(1.0)
    path = tmp_path / "flat.xml"
    path.write_text(path.read_text().replace('data="-2.4 -1.6 2.4 1.6"', 'data="-2.4 -1.6 0.0 1.6"'))
    found = told(read_scene(str(path)))
    assert found.outcome == "finished"
    assert found.map.frame.shape == (64, 48)
    assert max(stamped.pose.x_m for stamped in found.truth) < 0.1


def test_a_robot_that_has_no_room_does_not_turn(flat) -> None:
    scene = flat(1.0)
    for place, turns in ((Pose(-1.4, 0.2, 0.0), True), (Pose(-1.77, 1.2, math.pi / 2), False)):
        cramped = replace(scene, starts={"here": place})
        survey = Survey(cramped, USUAL, SMALL, mapper=TrueMapper(scene.map_frame, sensor()))
        survey._drive.hear()
        survey._look_round()
        assert (survey._time_s() > 3.0) == turns


def test_what_the_bumper_felt_is_not_tried_again(flat, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = flat(1.0)
    survey = Survey(scene, USUAL, SMALL, mapper=TrueMapper(scene.map_frame, sensor()))
    survey._note_failure((1.0, 0.0), touched=True)
    survey._note_failure((1.0, 1.0), touched=False)
    refused = survey._failed >= USUAL.tries
    assert refused[scene.map_frame.cell_at(1.0, 0.0)]
    assert not refused[scene.map_frame.cell_at(1.0, 1.0)]
    assert refused.sum() == 9
