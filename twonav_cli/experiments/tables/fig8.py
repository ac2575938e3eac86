"""Fig. 8: actions of a trial against the number of trials, in the maze, in 2D and in 3D (§4.4.2, §4.4.3).

S starts, K goals in order of training, n repeats. A round is one trial from each start. (a) and (b), the maze, are made
here; (c) to (e) show the agents of Tables 9 and 10 that are there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.statistics import rounded
from twonav_cli.experiments.tables.method_runs import Make, run_methods
from twonav_cli.experiments.tables.report import Figures, Report, report_of, settings_of, step_figures
from twonav_cli.experiments.tables.request import TableRequest

FloatArray = NDArray[np.float64]

METHODS = ("single", "multi")

FULL_ROUNDS, ROUNDS_PER_POINT = 10, 5
"""Rounds of a goal that are kept one by one, and how many of the later ones make a point (ours)."""


def fig8(request: TableRequest, make: Make) -> Report:
    """Run the paper's two learners on the scene's maze and keep what every trial took."""
    maze = request.scene_maze()
    methods = {name: request.settings(name) for name in METHODS}
    runs = run_methods(methods, [maze], request.repeats, make)
    ours, floor, excess = step_figures(runs, request.seed)
    for name in METHODS:
        ours[name]["curve"] = curve_of([run for run in runs[name][0] if run.learned], len(maze.starts))
    settings = settings_of(request, methods, "multi", on_scene=True)
    settings["stages"], further = _stages_there(request)
    settings["panels"] = f"(a) single and (b) multi in the maze; {further}"
    title = "Fig. 8: actions of a trial against the number of trials, and actions in all"
    return report_of(request, title, "actions", {}, ours, floor, excess, settings)


def _stages_there(request: TableRequest) -> tuple[Figures, str]:
    """Return the curves of (c) to (e) that can be drawn, and what is to be said of them."""
    try:
        stages = stage_curves(request)
    except TwonavError as error:
        return {}, f"without (c) to (e): {error}"
    if not stages:
        return {}, "for (c) to (e) make table9 and table10 first"
    return stages, "(c) 2D, (d) 3D and (e) 3D from nothing, of the agents that are there"


def stage_curves(request: TableRequest) -> Figures:
    """Return the curves of the agents that learned in 2D, in 3D, and in 3D from nothing; of those that are there.

    Raises:
        TwonavError: One of them is damaged, or was trained otherwise.
    """
    from twonav_cli.experiments.transfer.finished import finished_agents
    from twonav_cli.experiments.transfer.request import FROM_NOTHING, TRANSFERRED, TransferRequest
    from twonav_cli.mapping.floor import read_floor

    floor = read_floor(request.scene, request.map_from, own_first=True)  # as the agents are trained
    agents = TransferRequest("table10", seed=request.seed, scene=request.scene, map_from=request.map_from)
    found = finished_agents(agents, (TRANSFERRED, FROM_NOTHING), floor)
    groups = {"2d": found[TRANSFERRED]["2d"], "3d": found[TRANSFERRED]["3d"], FROM_NOTHING: found[FROM_NOTHING]["3d"]}
    learned = {name: [agent.run for agent in group if agent.run.learned] for name, group in groups.items()}
    return {
        name: {"agents": len(runs), "curve": curve_of(runs, len(floor.maze.starts))}
        for name, runs in learned.items()
        if runs
    }


def curve_of(runs: Sequence[LearningRun], starts: int) -> Figures:
    """Return the actions of a trial over the trials: mean over the repeats and the quartiles around it.

    The repeats need different numbers of trials for a goal, so they are laid over each other goal by goal, in order of
    training; a goal's stretch is as long as in the median repeat, and what longer repeats do after that is left out.

    Args:
        runs: [n] that learned every goal; of none the curve is empty.
        starts: S.
    """
    curve: Figures = {"trials": [], "mean": [], "q25": [], "q75": [], "goal_starts": [], "shortest": []}
    first = 0
    for rank in range(len(runs[0].goal_order) if runs else 0):
        rounds = [run.trial_steps[run.trial_goal_rank == rank].reshape(-1, starts).mean(axis=1) for run in runs]
        length = int(np.median([len(of_run) for of_run in rounds]))
        edges = point_edges(length)
        table = _points(rounds, edges)  # (n, points)
        curve["trials"] += [first + starts * (a + b) / 2 for a, b in pairwise(edges)]
        curve["mean"] += [rounded(value) for value in np.nanmean(table, axis=0)]
        low, high = np.nanquantile(table, (0.25, 0.75), axis=0)
        curve["q25"] += [rounded(value) for value in low]
        curve["q75"] += [rounded(value) for value in high]
        curve["goal_starts"].append(first)
        curve["shortest"].append(rounded(np.mean([run.shortest_of_goal[rank] for run in runs])))
        first += starts * length
    return curve


def point_edges(length: int) -> list[int]:
    """Return where the points of a goal's stretch begin and end, in rounds: single ones first, then five at a time."""
    edges = [*range(min(length, FULL_ROUNDS)), *range(FULL_ROUNDS, length, ROUNDS_PER_POINT), length]
    return edges if length else []


def _points(rounds: Sequence[FloatArray], edges: Sequence[int]) -> FloatArray:
    """Return the mean of every repeat's rounds between the edges [n, points], NaN where it has none."""
    table = np.full((len(rounds), len(edges) - 1), np.nan)
    for i, of_run in enumerate(rounds):
        for j, (begin, end) in enumerate(pairwise(edges)):
            if begin < len(of_run):
                table[i, j] = of_run[begin:end].mean()
    return table
