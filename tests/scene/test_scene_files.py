"""The shipped scenes: written by their script, light, and drivable from maze cell to maze cell."""

import subprocess
import sys
from collections import deque
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = ("apartment", "kitchen")
CELL_M, PIXEL_M = 0.4, 0.05
BAND_M = (0.03, 0.45)  # what stands between these heights blocks the robot
TURNING_RADIUS_M = 0.315
GOALS = {
    "apartment": {"kitchen", "table", "sofa", "tv", "bed", "wardrobe", "bath", "desk", "bookshelf", "door"},
    "kitchen": {"stove", "fridge", "table", "window", "shelf"},
}


def load(name: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(SCENES / name / "scene.xml"))


def footprints(model: mujoco.MjModel) -> NDArray[np.float64]:
    """(x0, x1, y0, y1) of every geom in the height band, (N, 4)."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = []
    for geom in range(model.ngeom):
        if not model.geom_contype[geom] or model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            continue
        turn = np.abs(data.geom_xmat[geom].reshape(3, 3))
        size = model.geom_aabb[geom, 3:]
        low, high = data.geom_xpos[geom] - turn @ size, data.geom_xpos[geom] + turn @ size
        if high[2] > BAND_M[0] + 1e-6 and low[2] < BAND_M[1] - 1e-6:
            found.append((low[0], high[0], low[1], high[1]))
    return np.array(found)


def free_cells(model: mujoco.MjModel) -> tuple[NDArray[np.bool_], NDArray[np.float64], NDArray[np.float64]]:
    """Reachable free cells (rows from below, cols), centre x (C,), centre y (R,)."""
    x0, y0, x1, y1 = model.numeric("twonav.map").data
    cols, rows = round((x1 - x0) / CELL_M), round((y1 - y0) / CELL_M)
    blocked = np.zeros((rows * 8, cols * 8), dtype=bool)
    for left, right, low, high in footprints(model):
        c0, c1 = np.floor((left - x0) / PIXEL_M + 1e-6), np.ceil((right - x0) / PIXEL_M - 1e-6)
        r0, r1 = np.floor((low - y0) / PIXEL_M + 1e-6), np.ceil((high - y0) / PIXEL_M - 1e-6)
        blocked[int(r0) : int(r1), int(c0) : int(c1)] = True
    free = ~blocked.reshape(rows, 8, cols, 8).any(axis=(1, 3))
    xs, ys = x0 + CELL_M * (np.arange(cols) + 0.5), y0 + CELL_M * (np.arange(rows) + 0.5)
    start = next(iter(places(model, "start/").values()))
    return flood(free, cell_of(model, start)), xs, ys


def flood(free: NDArray[np.bool_], first: tuple[int, int]) -> NDArray[np.bool_]:
    """The free cells that four moves reach from `first`."""
    reached = np.zeros_like(free)
    reached[first] = free[first]
    queue = deque([first])
    while queue:
        row, col = queue.popleft()
        for there in ((row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)):
            if 0 <= there[0] < free.shape[0] and 0 <= there[1] < free.shape[1] and free[there] and not reached[there]:
                reached[there] = True
                queue.append(there)
    return reached


def places(model: mujoco.MjModel, prefix: str) -> dict[str, NDArray[np.float64]]:
    """The positions of the sites whose name starts with `prefix`."""
    names = [model.site(i).name for i in range(model.nsite)]
    return {name: model.site(name).pos[:2] for name in names if name.startswith(prefix)}


def cell_of(model: mujoco.MjModel, point: NDArray[np.float64]) -> tuple[int, int]:
    """(row from below, col) of a point; the point must be the cell's centre."""
    steps = (point - model.numeric("twonav.map").data[:2]) / CELL_M - 0.5
    assert np.allclose(steps, np.round(steps), atol=1e-3)
    return round(float(steps[1])), round(float(steps[0]))


@pytest.mark.parametrize("name", NAMES)
def test_goals_and_starts_are_distinct_free_cells_that_reach_each_other(name: str) -> None:
    model = load(name)
    free = free_cells(model)[0]
    goals, starts = places(model, "goal/"), places(model, "start/")
    cells = [cell_of(model, point) for point in (goals | starts).values()]
    assert {goal.removeprefix("goal/") for goal in goals} == GOALS[name]
    assert len(starts) >= 4
    assert len(set(cells)) == len(cells)
    assert all(free[cell] for cell in cells)


@pytest.mark.parametrize("name", NAMES)
def test_the_robot_can_turn_at_the_centre_of_every_free_cell(name: str) -> None:
    model = load(name)
    free, xs, ys = free_cells(model)
    boxes = footprints(model)
    tight = []
    for row, col in np.argwhere(free):
        dx = np.maximum(np.maximum(boxes[:, 0] - xs[col], xs[col] - boxes[:, 1]), 0)
        dy = np.maximum(np.maximum(boxes[:, 2] - ys[row], ys[row] - boxes[:, 3]), 0)
        if np.hypot(dx, dy).min() < TURNING_RADIUS_M + 0.005:
            tight.append((int(col), int(row)))
    assert free.sum() > 80
    assert tight == []


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_is_cheap_to_draw_and_every_geom_has_a_name(name: str) -> None:
    model = load(name)
    assert (model.geom_group == 0).sum() <= 60
    assert model.tex_width.max() <= 1024
    assert model.vis.quality.shadowsize == 0
    assert not any(model.light_castshadow)
    assert all(model.geom(i).name for i in range(model.ngeom))


def test_the_scene_files_are_what_their_script_writes() -> None:
    code = "import build_scenes as b; print(b.apartment().text() + '|' + b.small_kitchen().text(), end='')"
    run = subprocess.run([sys.executable, "-c", code], cwd=SCENES, capture_output=True, text=True, check=True)
    committed = "|".join((SCENES / name / "scene.xml").read_text(encoding="utf-8") for name in NAMES)
    assert run.stdout == committed
