import numpy as np

from twonav_cli.dataset.plan import GRID, HELD_OUT, RANDOM, FramePlan, PlanConfig, plan_frames
from twonav_cli.dataset.poses import TEST, TRAIN
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

FRAME = GridFrame(0.0, 0.0, 0.05, 30, 30)


def _plan(seed: int, random_frames: int = 40) -> FramePlan:
    config = PlanConfig(90, random_frames, 10)
    return plan_frames(np.zeros(FRAME.shape, dtype=bool), FRAME, [Pose(0.7, 0.7, 0.0)], config, seed)


def test_a_plan_holds_each_kind_with_its_label() -> None:
    plan = _plan(1)
    assert [(plan.kinds == kind).sum() for kind in (RANDOM, HELD_OUT)] == [40, 10]
    assert set(plan.splits[plan.kinds == RANDOM]) == {TRAIN}
    assert set(plan.splits[plan.kinds == HELD_OUT]) == {TEST}
    assert (plan.kinds == GRID).sum() == len(np.unique(plan.poses[plan.kinds == GRID][:, :2], axis=0)) * 4


def test_more_training_frames_leave_the_held_out_ones_as_they_were() -> None:
    few, many = _plan(1), _plan(1, random_frames=80)
    assert np.array_equal(few.poses[few.kinds == HELD_OUT], many.poses[many.kinds == HELD_OUT])
    assert few.digest == _plan(1).digest
    assert few.digest != _plan(2).digest
