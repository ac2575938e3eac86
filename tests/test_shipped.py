"""What is shipped works: every checkpoint belongs to its scene, and the robot finds a goal from its camera."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from twonav_cli.checkpoint import read_card
from twonav_cli.experiments.localizer_report import ReportConfig, localizer_report
from twonav_cli.experiments.map_errors import map_agreement, maze_differences
from twonav_cli.experiments.predecessors import load_agent, load_localize
from twonav_cli.mapping.floor import geometry_map, read_floor
from twonav_cli.mapping.known_maps import find_map
from twonav_cli.paths import checkpoints_dir
from twonav_cli.scene.catalog import scene_names

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("name", scene_names())
def test_the_agent_belongs_to_the_scene_and_its_map(name: str) -> None:
    floor = read_floor(name)
    assert load_agent(floor, "3d").goal_names == list(floor.scene.goals)


@pytest.mark.parametrize("name", scene_names())
@pytest.mark.parametrize("stage", ["maze", "2d", "3d"])
def test_a_new_goal_has_a_known_way_from_nearly_every_cell(name: str, stage: str) -> None:
    floor = read_floor(name)
    agent = load_agent(floor, stage)
    for cell in floor.maze.free_cells[::50]:
        added = agent.add_goal(cell)
        assert added.untried == ()
        # The robot once found no room in the gap between a wall and the bed: four cells of 459.
        assert len(added.without_way) <= (0 if stage == "maze" else 0.01 * len(floor.maze.free_cells))


@pytest.mark.parametrize("name", scene_names())
def test_the_localizer_belongs_to_its_scene(name: str) -> None:
    assert callable(load_localize(read_floor(name)))


@pytest.mark.parametrize("name", scene_names())
def test_the_shipped_map_is_one_that_the_robot_made_and_agrees_with_the_geometry(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    floor = read_floor(name)
    scene, start = floor.scene, next(iter(floor.scene.starts.values()))
    geometry = geometry_map(scene)
    assert map_agreement(floor.map, geometry, start)["agreeing"] >= 0.98
    assert maze_differences(floor.map, geometry, start) == {"blocked_by_us": [], "freed_by_us": []}
    assert floor.map_source == "survey"
    assert floor.walls is not None
    assert find_map(scene, "survey").folder == checkpoints_dir() / name / "map"  # type: ignore[union-attr]  # it is there


@pytest.mark.parametrize("scene", scene_names())
@pytest.mark.parametrize("name", ["localizer", "localizer-inception-9"])
def test_a_localizer_is_as_good_at_new_poses_as_its_card_says(scene: str, name: str) -> None:
    folder = checkpoints_dir() / scene / name
    found = localizer_report(read_floor(scene), folder, ReportConfig(200, 0, 0), 7, lambda name, done, total: None)
    said = read_card(folder)["metrics"]
    for trial in ("off_grid", "paper_split"):
        assert found[trial]["pos_median_m"] < 1.3 * said[trial]["pos_median_m"]
        assert found[trial]["ang_median_deg"] < 1.3 * said[trial]["ang_median_deg"]


@pytest.mark.parametrize("scene", scene_names())
def test_our_localizer_knows_what_it_does_not_know(scene: str) -> None:
    folder = checkpoints_dir() / scene / "localizer"
    report = ReportConfig(400, 0, 0)
    found = localizer_report(read_floor(scene), folder, report, 8, lambda name, done, total: None)
    said = read_card(folder)["metrics"]
    assert 0.8 < found["belief"]["places_90"] < 0.98
    assert said["off_grid"]["pos_median_m"] < 0.5 * said["off_grid_nearest"]["pos_median_m"]
    assert said["belief"]["auroc"] > 0.9


def test_the_robot_finds_the_kitchen_from_its_camera_and_leaves_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "play.rrd"
    twonav = [sys.executable, "-m", "twonav_cli"]
    played = subprocess.run(
        [*twonav, "play", "--goal", "kitchen", "--plain", "--record", str(path)],
        capture_output=True, text=True, timeout=120, check=False, cwd=ROOT,
    )  # fmt: skip
    assert played.returncode == 0, played.stderr
    assert "summary: 1 of 1 goals reached" in played.stdout
    inspected = subprocess.run([*twonav, "inspect", str(path), "--json"], capture_output=True, text=True, check=True)
    assert [trial["outcome"] for trial in json.loads(inspected.stdout)["trials"]] == ["reached"]
