"""What was seen from near, and from which sides."""

from __future__ import annotations

import math

import numpy as np

from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.near_views import NearViews
from twonav_cli.mapping.scan import RangeSensor

FRAME = GridFrame(-1.0, -1.0, 0.05, 40, 80)
ONE_BEAM = RangeSensor(np.array([0.0]), Pose(0.1, 0.0, 0.0), 8.0)


def test_a_beam_sees_the_cells_up_to_its_end_but_none_that_is_far() -> None:
    near = NearViews(FRAME, ONE_BEAM, 1.0)
    near.add(Pose(0.0, 0.02, 0.0), np.array([0.5]))
    seen = near.seen_from(1)
    assert seen[FRAME.cell_at(0.12, 0.02)]  # the sensor stands 0.1 m ahead
    assert seen[FRAME.cell_at(0.58, 0.02)]
    assert not seen[FRAME.cell_at(0.05, 0.02)]
    assert not seen[FRAME.cell_at(0.66, 0.02)]
    near.add(Pose(0.0, 0.32, 0.0), np.array([2.5]))
    assert near.seen_from(1)[FRAME.cell_at(1.08, 0.32)]
    assert not near.seen_from(1)[FRAME.cell_at(1.2, 0.32)]


def test_sides_are_counted_once_each() -> None:
    near = NearViews(FRAME, ONE_BEAM, 1.0)
    middle = FRAME.cell_at(0.52, 0.02)
    for _ in range(2):
        near.add(Pose(0.0, 0.02, 0.01), np.array([0.6]))
    assert near.seen_from(1)[middle]
    assert not near.seen_from(2)[middle]
    near.add(Pose(1.0, 0.02, math.pi - 0.01), np.array([0.6]))
    assert near.seen_from(2)[middle]
    assert not near.seen_from(3)[middle]


def test_beams_that_leave_the_map_are_no_trouble() -> None:
    near = NearViews(FRAME, ONE_BEAM, 5.0)
    near.add(Pose(-0.9, 0.0, math.pi), np.array([8.0]))
    near.add(Pose(20.0, 0.0, 0.0), np.array([8.0]))
    assert near.seen_from(1).sum() < 5
