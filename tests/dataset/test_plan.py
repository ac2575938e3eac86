import numpy as np

from twonav_cli.config import FRAME_SPACING_M
from twonav_cli.dataset.plan import (
    GRID,
    GRID_SET,
    HELD_CELL,
    HELD_OUT,
    RANDOM,
    RANDOM_SET,
    FramePlan,
    PlanConfig,
    plan_frames,
)
from twonav_cli.dataset.poses import TEST, TRAIN, VALIDATION
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

FRAME = GridFrame(0.0, 0.0, 0.05, 40, 40)


def _plan(name: str, seed: int = 1, random_frames: int = 1200) -> FramePlan:
    config = PlanConfig(90, random_frames, 10, 0.1)
    return plan_frames(name, np.zeros(FRAME.shape, dtype=bool), FRAME, [Pose(0.7, 0.7, 0.0)], config, seed)


def test_the_random_set_holds_each_kind_with_its_label() -> None:
    plan = _plan(RANDOM_SET)
    assert [(plan.kinds == kind).sum() for kind in (RANDOM, HELD_OUT)] == [1200, 10]
    assert [(plan.splits[plan.kinds == RANDOM] == split).sum() for split in (TRAIN, VALIDATION)] == [1188, 12]
    assert set(plan.splits[plan.kinds != RANDOM]) == {TEST}


def test_the_grid_set_holds_the_papers_split_of_every_cell_that_is_not_held_out() -> None:
    plan = _plan(GRID_SET)
    assert set(plan.kinds) == {GRID}
    assert set(plan.splits) == {TRAIN, VALIDATION, TEST}
    assert len(plan.poses) == 4 * len(np.unique(plan.poses[:, :2], axis=0))
    assert len(plan.chunks) == len(plan.ways) == len(plan.poses) // 4


def test_no_training_frame_lies_in_a_held_out_cell() -> None:
    grid, random = _plan(GRID_SET), _plan(RANDOM_SET)
    held = np.unique(random.poses[random.kinds == HELD_CELL][:, :2], axis=0)
    assert len(held) >= 1
    trained = np.concatenate([grid.poses, random.poses[random.kinds == RANDOM]])
    inside = np.abs(trained[:, None, :2] - held).max(axis=2) < FRAME_SPACING_M / 2 - 1e-6
    assert not inside.any()
    near = np.abs(trained[:, None, :2] - held).max(axis=2) < FRAME_SPACING_M
    assert near.any()


def test_each_chunk_of_the_grid_is_one_cell_and_its_way_begins_at_the_cell_before() -> None:
    plan = _plan(GRID_SET)
    for number, ((first, end), way) in enumerate(zip(plan.chunks, plan.ways, strict=True)):
        assert len(np.unique(plan.poses[first:end, :2], axis=0)) == 1
        assert np.allclose(way[-1], plan.poses[first, :2])
        if number:
            assert np.allclose(way[0], plan.poses[first - 1, :2])


def test_chunks_cover_every_frame_once() -> None:
    for name in (GRID_SET, RANDOM_SET):
        plan = _plan(name)
        assert np.concatenate([np.arange(*chunk) for chunk in plan.chunks]).tolist() == list(range(len(plan.poses)))


def test_more_training_frames_leave_the_held_out_ones_as_they_were() -> None:
    few, many = _plan(RANDOM_SET), _plan(RANDOM_SET, random_frames=2400)
    for kind in (HELD_OUT, HELD_CELL):
        assert np.array_equal(few.poses[few.kinds == kind], many.poses[many.kinds == kind])
    assert few.digest == _plan(RANDOM_SET).digest
    assert few.digest != _plan(RANDOM_SET, seed=2).digest
