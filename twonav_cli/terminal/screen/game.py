"""The game as a state machine: events go in, a new state comes out; nothing here knows a terminal.

G goals, R rows, C columns, A = 4 actions, as in `events`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.events import (
    Clock,
    Event,
    Filtered,
    GoalAdded,
    GoalChosen,
    GoalLearned,
    Kidnapped,
    Looked,
    Note,
    QSnapshot,
    RunEnded,
    RunStarted,
    StepTaken,
    Tick,
    TrialEnded,
    TrialStarted,
)
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import OFFSETS, UNREACHABLE, Maze

FloatArray = NDArray[np.float64]

NO_ARROW = -1
TRAIL_POINTS = 1500
TRAIL_SPACING_M = 0.08
LOG_LINES = 200
HISTORY_STEPS = 120
SPEEDS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)


@dataclass(frozen=True)
class LogLine:
    """A sentence of the log; level is INFO, WARN or ERROR."""

    level: str
    text: str


@dataclass(frozen=True)
class GameState:
    """Everything the play screen shows, after some events."""

    run: RunStarted | None = None
    clock: Clock = field(default_factory=Clock)
    ended: str = ""
    """Outcome of the run, empty while it goes on."""
    goal: str = ""
    reason: str = ""
    pose_true: Pose | None = None
    pose_estimate: Pose | None = None
    cell_true: Cell | None = None
    cell_believed: Cell | None = None
    trail: tuple[tuple[float, float], ...] = ()
    """True positions since the trial or the last kidnapping began, map frame, metres."""
    image: NDArray[np.uint8] | None = None
    belief: Belief | None = None
    """What the last picture that was looked at says by itself."""
    filtered: Filtered | None = None
    """What the filter made of it, where there is one."""
    scan_m: FloatArray | None = None
    greedy: NDArray[np.int8] | None = None
    """[G, R, C] best action of every goal, NO_ARROW where the values do not say."""
    values: FloatArray | None = None
    """[G, R, C] value of that action."""
    q_values: FloatArray | None = None
    """[A] values of the current goal where the last action was chosen."""
    action: int | None = None
    action_greedy: bool = True
    action_outcome: str = ""
    td_error: float | None = None
    """Squared TD error of the current goal at the last step (Eq. 3)."""
    td_of_goals: FloatArray | None = None
    """[G] the same for every goal; the largest ones before the first step."""
    td_history: tuple[float, ...] = ()
    trial_steps: int = 0
    shortest: int | None = None
    """Actions of the shortest way from the start of the trial under way."""
    outcomes: dict[str, int] = field(default_factory=dict)
    learned: frozenset[str] = frozenset()
    last_trial: TrialEnded | None = None
    in_trial: bool = False
    kidnaps: int = 0
    log: tuple[LogLine, ...] = ()

    @property
    def maze(self) -> Maze | None:
        """The maze of the run."""
        return self.run.maze if self.run else None

    @property
    def goal_names(self) -> list[str]:
        """Names of the goals in table order."""
        return self.maze.goal_names if self.maze else []

    @property
    def maze_frame(self) -> GridFrame | None:
        """Where the maze lies; one metre a cell when the run does not say."""
        if self.run is None or self.maze is None:
            return None
        return self.run.maze_frame or GridFrame(0.0, 0.0, 1.0, self.maze.rows, self.maze.cols)

    @property
    def goal_index(self) -> int | None:
        """Index of the current goal in every table, None when there is none."""
        return self.goal_names.index(self.goal) if self.goal in self.goal_names else None


def advance(state: GameState, event: Event) -> GameState:
    """Return the state after one event; events that the game does not show change only the clock."""
    rule = RULES.get(type(event))
    state = replace(state, clock=event.clock)
    return rule(state, event) if rule is not None else state


def faster(speed: float, steps: int) -> float:
    """Return the speed factor some places further in `SPEEDS`; it stops at both ends."""
    if speed <= 0:  # no limit
        return SPEEDS[-1]
    nearest = min(range(len(SPEEDS)), key=lambda place: abs(math.log(SPEEDS[place] / speed)))
    return SPEEDS[min(max(nearest + steps, 0), len(SPEEDS) - 1)]


def headline(state: GameState) -> str:
    """Return the one sentence with the number that counts."""
    trial = state.last_trial
    if state.in_trial and state.goal:
        bound = f", shortest {state.shortest}" if state.shortest is not None else ""
        return f"to {state.goal}: {_actions(state.trial_steps)}{bound}"
    if trial is None:
        return state.ended or ("choose a goal" if state.run else "starting")
    if trial.outcome == "reached":
        return f"{trial.goal} in {_actions(trial.steps)}, shortest {trial.shortest}"
    return f"{trial.goal} missed after {_actions(trial.steps)}: {trial.cause or trial.outcome}"


def tally(state: GameState) -> str:
    """Return how many trials reached their goal, and what became of the others."""
    total = sum(state.outcomes.values())
    others = [f"{count} {outcome}" for outcome, count in state.outcomes.items() if outcome != "reached"]
    return ", ".join([f"{state.outcomes.get('reached', 0)} of {total} reached", *others])


def pose_error(state: GameState) -> tuple[float, float] | None:
    """Return the distance (metres) and the angle (radians) between the true pose and the estimate."""
    true, estimate = state.pose_true, state.pose_estimate
    if true is None or estimate is None:
        return None
    turn_rad = (true.theta_rad - estimate.theta_rad + math.pi) % (2 * math.pi) - math.pi
    return math.hypot(true.x_m - estimate.x_m, true.y_m - estimate.y_m), abs(turn_rad)


def _actions(count: int) -> str:
    return f"{count} action" if count == 1 else f"{count} actions"


def _logged(state: GameState, level: str, text: str) -> GameState:
    return replace(state, log=(*state.log[1 - LOG_LINES :], LogLine(level, text)))


def _run_started(state: GameState, event: RunStarted) -> GameState:
    fresh = GameState(run=event, clock=event.clock, log=state.log)
    return _logged(fresh, "INFO", f"{event.command} in {event.scene} ({event.stage}), seed {event.seed}")


def _goal_chosen(state: GameState, event: GoalChosen) -> GameState:
    td = event.td_errors if event.td_errors is not None else state.td_of_goals
    chosen = replace(state, goal=event.goal, reason=event.reason, td_of_goals=td)
    return _logged(chosen, "INFO", f"goal {event.goal}: {event.reason}" if event.reason else f"goal {event.goal}")


def _trial_started(state: GameState, event: TrialStarted) -> GameState:
    pose = event.pose_true or _pose_in(state, event.start, None)
    shortest = None
    if state.maze is not None and event.goal in state.maze.goals:
        distance = int(state.maze.distances_to(state.maze.goals[event.goal])[event.start])
        shortest = distance if distance != UNREACHABLE else None
    return replace(
        state,
        goal=event.goal,
        cell_true=event.start,
        cell_believed=event.start,
        pose_true=pose,
        pose_estimate=pose if event.pose_true is None else state.pose_estimate,
        trail=((pose.x_m, pose.y_m),) if pose else (),
        trial_steps=0,
        shortest=shortest,
        in_trial=True,
    )


def _tick(state: GameState, event: Tick) -> GameState:
    return replace(
        state,
        pose_true=event.pose_true,
        pose_estimate=event.pose_believed,
        trail=_longer(state.trail, event.pose_true),
        scan_m=event.scan_m,
        image=event.image if event.image is not None else state.image,
    )


def _looked(state: GameState, event: Looked) -> GameState:
    return replace(
        state,
        pose_true=event.pose_true,
        pose_estimate=event.pose_estimate or state.pose_estimate,
        image=event.image,
        belief=event.belief,
        filtered=event.filtered,
    )


def _step_taken(state: GameState, event: StepTaken) -> GameState:
    true_cell = event.true_cell or event.next_cell
    simulated = event.pose_true is not None
    pose_true = event.pose_true or _pose_in(state, true_cell, event.action)
    pose_estimate = event.pose_estimate
    if pose_estimate is None:
        pose_estimate = state.pose_estimate if simulated else _pose_in(state, event.next_cell, event.action)
    state = replace(state, goal=event.goal)
    goal = state.goal_index
    td = float(event.td_errors[goal]) if goal is not None and goal < len(event.td_errors) else None
    greedy, values = _with_step(state, event)
    return replace(
        state,
        cell_believed=event.next_cell,
        cell_true=true_cell,
        pose_true=pose_true,
        pose_estimate=pose_estimate,
        trail=_longer(state.trail, pose_true) if pose_true else state.trail,
        image=event.image if event.image is not None else state.image,
        belief=event.belief,
        filtered=event.filtered,
        greedy=greedy,
        values=values,
        q_values=event.q_values,
        action=event.action,
        action_greedy=event.greedy,
        action_outcome=event.outcome,
        td_error=td,
        td_of_goals=event.td_errors,
        td_history=(*state.td_history[1 - HISTORY_STEPS :], td) if td is not None else state.td_history,
        trial_steps=state.trial_steps + 1,
    )


def _trial_ended(state: GameState, event: TrialEnded) -> GameState:
    outcomes = {**state.outcomes, event.outcome: state.outcomes.get(event.outcome, 0) + 1}
    ended = replace(
        state,
        outcomes=outcomes,
        last_trial=event,
        in_trial=False,
        trial_steps=event.steps,
        pose_true=event.pose_true or state.pose_true,
        pose_estimate=event.pose_estimate or state.pose_estimate,
    )
    sentence = headline(ended) + (f" ({event.evidence})" if event.evidence else "")
    return _logged(ended, "INFO" if event.outcome == "reached" else "WARN", sentence)


def _q_snapshot(state: GameState, event: QSnapshot) -> GameState:
    return replace(state, greedy=greedy_actions(event.q), values=event.q.max(axis=-1))


def _goal_learned(state: GameState, event: GoalLearned) -> GameState:
    return _logged(replace(state, learned=state.learned | {event.goal}), "INFO", f"{event.goal} is learned")


def _goal_added(state: GameState, event: GoalAdded) -> GameState:
    """Give the maze its goal, and the arrows and values one more that says nothing yet."""
    if state.run is None or state.run.maze is None:
        return state
    maze = state.run.maze.with_goal(event.name, event.cell)
    unknown = np.full((1, maze.rows, maze.cols), NO_ARROW, dtype=np.int8)
    return replace(
        state,
        run=replace(state.run, maze=maze),
        greedy=np.concatenate((state.greedy, unknown)) if state.greedy is not None else None,
        values=np.concatenate((state.values, np.full(unknown.shape, np.nan))) if state.values is not None else None,
    )


def _kidnapped(state: GameState, event: Kidnapped) -> GameState:
    after = event.pose_after
    moved = replace(state, pose_true=after, trail=((after.x_m, after.y_m),), kidnaps=state.kidnaps + 1)
    gone_m = math.hypot(after.x_m - event.pose_before.x_m, after.y_m - event.pose_before.y_m)
    return _logged(moved, "WARN", f"kidnapped: carried {gone_m:.1f} m away")


def _note(state: GameState, event: Note) -> GameState:
    return _logged(state, event.level, event.text)


def _run_ended(state: GameState, event: RunEnded) -> GameState:
    return _logged(replace(state, ended=event.outcome, in_trial=False), "INFO", f"run ended: {event.outcome}")


RULES: dict[type[Event], Callable[[GameState, Any], GameState]] = {
    RunStarted: _run_started,
    GoalChosen: _goal_chosen,
    TrialStarted: _trial_started,
    Looked: _looked,
    Tick: _tick,
    StepTaken: _step_taken,
    TrialEnded: _trial_ended,
    QSnapshot: _q_snapshot,
    GoalLearned: _goal_learned,
    GoalAdded: _goal_added,
    Kidnapped: _kidnapped,
    Note: _note,
    RunEnded: _run_ended,
}


def greedy_actions(q: FloatArray) -> NDArray[np.int8]:
    """Return the best action [G, R, C] of a table [G, R, C, A], NO_ARROW where all four are equal."""
    best: NDArray[np.int8] = q.argmax(axis=-1).astype(np.int8)
    best[q.max(axis=-1) == q.min(axis=-1)] = NO_ARROW
    return best


def _with_step(state: GameState, event: StepTaken) -> tuple[NDArray[np.int8] | None, FloatArray | None]:
    """Return the arrows and values [G, R, C] with the current goal's entry of the step's cell brought up to date."""
    goal, maze = state.goal_index, state.maze
    if goal is None or maze is None:
        return state.greedy, state.values
    shape = (len(maze.goals), maze.rows, maze.cols)
    greedy = np.full(shape, NO_ARROW, dtype=np.int8) if state.greedy is None else state.greedy.copy()
    values = np.full(shape, np.nan) if state.values is None else state.values.copy()
    place = (goal, event.cell.row, event.cell.col)
    greedy[place] = greedy_actions(event.q_values[None])[0]
    values[place] = event.q_values.max()
    return greedy, values


def _longer(trail: tuple[tuple[float, float], ...], pose: Pose) -> tuple[tuple[float, float], ...]:
    """Return the trail with the pose's position added, unless it is where the trail ends."""
    point = (pose.x_m, pose.y_m)
    if trail and math.dist(trail[-1], point) < TRAIL_SPACING_M:
        return trail
    return (*trail[1 - TRAIL_POINTS :], point)


def _pose_in(state: GameState, cell: Cell, action: int | None) -> Pose | None:
    """Return the centre of a cell, facing along an action (up when None), for stages that have no poses."""
    frame = state.maze_frame
    if frame is None:
        return None
    d_row, d_col = OFFSETS[action if action is not None else 0]
    return Pose(*frame.centre_of(cell), math.atan2(-d_row, d_col))
