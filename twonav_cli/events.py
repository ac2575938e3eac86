"""What happened: small records that loops emit, and that recordings, progress bars, the game and tests consume.

Every event carries the clock (`trial`, `step`, `time_s`): `step` counts actions over the whole run and is never reset,
`trial` counts attempts at a goal, `time_s` is simulated time. G goals, R rows, C columns, A = 4 actions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import Maze

FloatArray = NDArray[np.float64]

LEAST_WEIGHT = 0.03
"""Probability from which another place is worth naming (ours)."""


@dataclass(frozen=True)
class Clock:
    """When an event happened."""

    trial: int = 0
    step: int = 0
    time_s: float = 0.0


@dataclass(frozen=True)
class Event:
    """Anything that happened in a run."""

    clock: Clock


@dataclass(frozen=True)
class RunStarted(Event):
    """A run begins: everything that stays the same in it."""

    command: str
    """"play", "train" or "evaluate"."""
    stage: str
    """"map", "maze", "2d", "3d" or "localizer"."""
    scene: str
    seed: int
    settings: dict[str, str] = field(default_factory=dict)
    maze: Maze | None = None
    maze_frame: GridFrame | None = None
    occupied: NDArray[np.bool_] | None = None
    """[map rows, map cols] occupied pixels of the 5 cm map."""
    map_frame: GridFrame | None = None


@dataclass(frozen=True)
class GoalChosen(Event):
    """The next goal was chosen, by whom or by which rule."""

    goal: str
    reason: str
    td_errors: FloatArray | None = None
    """[G] mean squared TD error of each goal over the free entries."""
    learned: NDArray[np.bool_] | None = None
    """[G] goals that were learned already, among which a rule does not choose; None when a person chose."""


@dataclass(frozen=True)
class TrialStarted(Event):
    """One attempt at a goal begins."""

    goal: str
    start: Cell
    pose_true: Pose | None = None


@dataclass(frozen=True)
class DriveTrace:
    """What the controller weighed in one control period."""

    candidates: NDArray[np.float32]
    """[N, T, 2] rolled-out positions, map frame, metres, as the controller believes them."""
    costs: NDArray[np.float32]
    """[N] total cost; inf where the footprint would touch something."""
    best: int
    """Index of the chosen candidate, -1 when none was admissible."""
    cost_map: NDArray[np.float32]
    """[h, w] cost 0 (free) to 1 (touching) around the robot."""
    cost_frame: GridFrame
    """Where the cost map lies in the map frame."""


@dataclass(frozen=True)
class Tick(Event):
    """One control period of a driving robot."""

    pose_true: Pose
    pose_believed: Pose
    scan_m: FloatArray
    """[180] ranges from right (-90 degrees) to left (+90 degrees); cut ranges read the cut."""
    drive: DriveTrace | None = None
    image: NDArray[np.uint8] | None = None
    """[84, 84, 3] RGB when the camera was looked through in this period."""


@dataclass(frozen=True)
class Filtered:
    """What the belief filter makes of all looks and of the odometry between them (Eq. 4-5)."""

    probability: float
    """Share of its belief at the estimate, 0 to 1."""
    spread_m: float
    spread_rad: float
    particles: NDArray[np.float32]
    """[P, 3] some of its particles."""
    others: FloatArray
    """[K, 3] weight, x_m, y_m of the other places that it holds possible, the likeliest first."""
    placed: float = 1.0
    """Share of its belief that the particles stand for; the rest is elsewhere on the floor, nobody knows where."""


@dataclass(frozen=True)
class Looked(Event):
    """The camera was looked through while the robot stands: before an action, or after it was carried."""

    pose_true: Pose
    image: NDArray[np.uint8]
    """[84, 84, 3] RGB."""
    pose_estimate: Pose | None = None
    """None when nothing was estimated from the picture."""
    belief: Belief | None = None
    """What the picture alone says; its pose is the localizer's, whatever a filter makes of it."""
    filtered: Filtered | None = None


@dataclass(frozen=True)
class StepTaken(Event):
    """One action was chosen and carried out."""

    goal: str
    cell: Cell
    """Where the agent believed to be before."""
    action: int
    next_cell: Cell
    """Where the agent believes to be afterwards."""
    outcome: str
    """"reached", "blocked" or "timed-out"."""
    q_values: FloatArray
    """[A] values of the current goal in `cell`, before the update."""
    td_errors: FloatArray
    """[G] squared TD error of every goal at this step (Eq. 3)."""
    greedy: bool
    true_cell: Cell | None = None
    """Where the robot really is afterwards."""
    pose_true: Pose | None = None
    pose_estimate: Pose | None = None
    """Where the robot believes to be after the action: the filter's pose, or without one the localizer's; None in the
    maze."""
    image: NDArray[np.uint8] | None = None
    """[84, 84, 3] RGB, what the localizer saw after the action."""
    belief: Belief | None = None
    """What that picture alone says, None in the maze and with the simulator's truth."""
    filtered: Filtered | None = None
    """What the filter makes of it, None without one."""


@dataclass(frozen=True)
class TrialEnded(Event):
    """One attempt at a goal is over."""

    goal: str
    start: Cell
    outcome: str
    """"reached", "time-out" or "false-arrival" (declared, but the robot stands elsewhere)."""
    steps: int
    shortest: int
    cause: str = ""
    """Why it failed, from a closed list (`failure_causes.CAUSES`); "" when it did not."""
    evidence: str = ""
    pose_true: Pose | None = None
    pose_estimate: Pose | None = None


@dataclass(frozen=True)
class TrialBatch(Event):
    """Many trials of a compiled loop, as columns of length n."""

    goal: NDArray[np.int64]
    """[n] index of the goal."""
    start: NDArray[np.int64]
    """[n] index of the start."""
    steps: NDArray[np.int64]
    """[n] actions taken."""
    reached: NDArray[np.bool_]
    """[n] whether the goal was reached."""
    shortest: NDArray[np.int64]
    """[n] length of the shortest way."""
    td_errors: FloatArray
    """[n, G] mean squared TD error of each goal over the free entries, after the trial."""
    last_step: NDArray[np.int64]
    """[n] value of the run's step counter when the trial ended."""


@dataclass(frozen=True)
class GoalLearned(Event):
    """A goal met the criterion."""

    goal: str


@dataclass(frozen=True)
class GoalAdded(Event):
    """A goal was added while the run went on: every table has one goal more from here on, the last one."""

    name: str
    cell: Cell


@dataclass(frozen=True)
class QSnapshot(Event):
    """The whole table at one moment."""

    q: FloatArray
    """[G, R, C, A]."""
    td_errors: FloatArray | None = None
    """[G, R, C, A] squared TD error of the latest visit (Eq. 3), not a number where an action was never tried."""


@dataclass(frozen=True)
class Kidnapped(Event):
    """The robot was carried elsewhere."""

    pose_before: Pose
    pose_after: Pose


@dataclass(frozen=True)
class FittingStep(Event):
    """Progress of a network's training, every few batches. `clock.step` counts batches, `clock.trial` epochs."""

    loss: float
    learning_rate: float
    images_per_s: float


@dataclass(frozen=True)
class FittingValidated(Event):
    """A network was measured during its training. `clock.step` counts batches, `clock.trial` epochs."""

    metrics: dict[str, float]


@dataclass(frozen=True)
class KeyframeMapped(Event):
    """A scan was put into the map. `clock.step` counts keyframes, `clock.time_s` is the time since the first scan."""

    pose: Pose
    """Of the best particle."""
    poses: FloatArray
    """[P, 3] of every particle, before they are drawn again."""
    weights: FloatArray
    """[P] normalised."""
    effective: float
    """Effective number of particles (Grisetti et al. 2007, Eq. 20)."""
    resampled: bool
    unmatched: int
    """Particles whose scan matching failed, so that odometry was kept (§4.1)."""
    hits: FloatArray
    """[N, 2] where the beams ended, map frame, as the best particle believes."""
    pose_odom: Pose
    """Where odometry alone would be, in the frame of the map."""
    pose_true: Pose | None = None
    """Of the simulator, where there is one."""


@dataclass(frozen=True)
class MapDrawn(Event):
    """The map of the best particle at one moment, and the way it believes to have come."""

    pixels: NDArray[np.uint8]
    """[rows, cols]: 0 occupied, 205 unknown, 254 free."""
    frame: GridFrame
    path: FloatArray
    """[K, 3] its pose at every keyframe so far."""


@dataclass(frozen=True)
class Note(Event):
    """A sentence for the log; level is INFO, WARN or ERROR."""

    level: str
    text: str


@dataclass(frozen=True)
class RunEnded(Event):
    """A run is over."""

    outcome: str


def confidence_of(belief: Belief | None, filtered: Filtered | None) -> float | None:
    """Return how sure the robot is of where it believes to be, 0 to 1; None where neither says anything."""
    if filtered is not None:
        return filtered.probability
    return belief.confidence if belief is not None else None


def other_places(belief: Belief | None, filtered: Filtered | None, least: float = LEAST_WEIGHT) -> FloatArray:
    """Return weight, x_m, y_m [K, 3] of the other places where the robot could be, the likeliest first."""
    if filtered is not None:
        others = filtered.others
    elif belief is not None:
        others = np.column_stack([(1.0 - belief.lost) * belief.places[1:, 0], belief.places[1:, 1:3]])
    else:
        return np.zeros((0, 3))
    return np.asarray(others[others[:, 0] >= least], dtype=np.float64)


Sink = Callable[[Event], None]
"""Anything that consumes events."""


def to_all(*sinks: Sink) -> Sink:
    """Return a sink that hands each event to every given sink in order."""

    def send(event: Event) -> None:
        for sink in sinks:
            sink(event)

    return send


def to_nobody(event: Event) -> None:
    """Consume an event and do nothing."""
