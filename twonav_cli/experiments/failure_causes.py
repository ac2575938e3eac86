"""Why a trial failed: one cause of a closed list, and one sentence of evidence for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from twonav_cli.events import confidence_of
from twonav_cli.experiments.belief_evidence import belief_sentence, share_near
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.stages.stage import Observation

MISLOCALIZED, AMBIGUOUS, STUCK, BLOCKED, LOOP, TIME_OUT = (
    "mislocalized", "ambiguous view", "stuck", "blocked", "loop", "time-out",
)  # fmt: skip
CAUSES = (MISLOCALIZED, AMBIGUOUS, STUCK, BLOCKED, LOOP, TIME_OUT)
"""Every cause there is."""

UNSURE_BELOW, TRUE_PLACE_ABOVE = 0.5, 0.05
"""A lost robot's view was ambiguous when it was less sure than this, or gave the true place more than that (ours)."""

STUCK_LOOK_BACK, STUCK_WITHIN_M = 10, 0.05
"""A failed trial was "stuck" when its last actions were blocked and moved the robot by less than this in all (ours)."""

BLOCKED_LOOK_BACK, BLOCKED_AT_LEAST = 20, 10
"""A failed trial was "blocked" when so many of its last actions were (ours)."""

LOOP_LOOK_BACK, LOOP_CELLS_AT_MOST = 40, 8
"""A failed trial was a "loop" when its last steps saw so few cells (ours)."""


@dataclass(frozen=True)
class Passed:
    """What a trial remembers of a step to explain a failure.

    Attributes:
        cell: Where the agent believed to be after it.
        blocked: Whether the action counts as blocked.
        place: Where the robot was, in a stage with poses.
        wrong_cell: Whether the robot then stood in another cell than the action, as it ended, should have led to.
    """

    cell: Cell
    blocked: bool
    place: Pose | None = None
    wrong_cell: bool = False


def failure_of(outcome: str, seen: Observation, goal_cell: Cell, passed: list[Passed]) -> tuple[str, str]:
    """Return why a trial failed, one of CAUSES, and one sentence of evidence; both empty when it did not.

    Args:
        outcome: "reached", "false-arrival" or "time-out".
        seen: What was known at the end.
        goal_cell: Where the trial was to end.
        passed: Its steps.
    """
    if outcome == "reached":
        return "", ""
    believed, true = tuple(seen.cell), tuple(seen.true_cell)
    if outcome == "false-arrival" or believed != true:
        ended = (
            f"Arrival was declared in {believed}, but the robot stands in {true}."
            if outcome == "false-arrival"
            else f"At the end the robot believes to be in {believed} and stands in {true}."
        )
        return AMBIGUOUS if _view_was_ambiguous(seen) else MISLOCALIZED, f"{ended} {belief_sentence(seen)}".rstrip()
    last = passed[-STUCK_LOOK_BACK:]
    if len(last) == STUCK_LOOK_BACK and all(step.blocked for step in last) and _moved_m(last) < STUCK_WITHIN_M:
        return STUCK, f"The last {len(last)} actions were blocked, and the robot stayed within {_moved_m(last):.2f} m."
    last = passed[-BLOCKED_LOOK_BACK:]
    blocked = sum(step.blocked for step in last)
    if blocked >= BLOCKED_AT_LEAST:
        return BLOCKED, f"{blocked} of the last {len(last)} actions were blocked."
    recent = passed[-LOOP_LOOK_BACK:]
    cells = len({step.cell for step in recent})
    if len(recent) == LOOP_LOOK_BACK and cells <= LOOP_CELLS_AT_MOST:
        return LOOP, f"The last {len(recent)} steps saw only {cells} cells."
    return TIME_OUT, f"After {len(passed)} actions the robot is in {true} and the goal in {tuple(goal_cell)}."


def _view_was_ambiguous(seen: Observation) -> bool:
    """Whether a lost robot doubted: it was hardly sure, or thought of the true place as well."""
    confidence = confidence_of(seen.belief, seen.filtered)
    if confidence is None or seen.pose_true is None:
        return False
    return confidence < UNSURE_BELOW or share_near(seen.belief, seen.filtered, seen.pose_true) > TRUE_PLACE_ABOVE


def _moved_m(steps: list[Passed]) -> float:
    """Return how far apart the places of some steps lie at most; nothing says so in a maze (infinite)."""
    places = [step.place for step in steps if step.place is not None]
    if len(places) < len(steps):
        return math.inf
    xs, ys = [place.x_m for place in places], [place.y_m for place in places]
    return math.hypot(max(xs) - min(xs), max(ys) - min(ys))
