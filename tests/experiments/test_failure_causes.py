"""A lost robot whose view looked like other places is told from one that was sure and wrong."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.experiments.failure_causes import AMBIGUOUS, CAUSES, MISLOCALIZED, failure_of
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.recording.palette import CAUSE_COLOURS
from twonav_cli.stages.stage import Observation

TRUE, BELIEVED = Pose(5.0, 1.0, 0.0), Pose(1.0, 4.0, 0.0)


def seen(*places: tuple[float, float, float]) -> Observation:
    """Return the look of a lost robot that believes in places (weight, x_m, y_m)."""
    rows = np.array([(*place, 0.1) for place in places])
    grid = np.zeros((1, 1), dtype=np.float32)
    belief = Belief(rows, np.array([(1.0, 0.0, 0.1)]), 0.05, 50.0, grid, GridFrame(0, 0, 9, 1, 1))
    return Observation(Cell(0, 0), Cell(1, 1), TRUE, BELIEVED, None, belief)


@pytest.mark.parametrize("outcome", ["false-arrival", "time-out"])
@pytest.mark.parametrize(
    ("places", "cause"),
    [
        ([(0.98, 1.0, 4.0), (0.02, 9.0, 1.0)], MISLOCALIZED),
        ([(0.85, 1.0, 4.0), (0.15, 5.1, 1.0)], AMBIGUOUS),
        ([(0.4, 1.0, 4.0), (0.35, 9.0, 1.0), (0.25, 3.0, 3.0)], AMBIGUOUS),
    ],
    ids=["sure and wrong", "the true place among others", "unsure"],
)
def test_a_lost_robot(outcome: str, places: list[tuple[float, float, float]], cause: str) -> None:
    found, evidence = failure_of(outcome, seen(*places), Cell(0, 0), [])
    assert found == cause
    assert "sure to be at (1.0, 4.0) m" in evidence


def test_a_lost_robot_without_a_belief_is_mislocalized() -> None:
    look = Observation(Cell(0, 0), Cell(1, 1), TRUE, BELIEVED)
    assert failure_of("false-arrival", look, Cell(0, 0), [])[0] == MISLOCALIZED
    assert set(CAUSE_COLOURS) == {"none", *CAUSES}
    assert set(CAUSES) == {"mislocalized", "ambiguous view", "stuck", "blocked", "loop", "time-out"}
