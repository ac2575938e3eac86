"""How often an action of the 2D simulator does not end as in the maze: the paper's blocked and wrong cells (§4.4.2).

    python benchmarks/tight_corners.py [actions]

From random free cells random actions are taken, twenty from each place. Counted are those that end blocked though the
neighbouring cell is free in the maze, and those after which the robot stands in another cell than it should.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, to_nobody
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.maze import Action
from twonav_cli.navigation.outcomes import REACHED
from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage

ACTIONS, FROM_EACH_PLACE = 4000, 20


def endings(floor: Floor, base: str, actions: int) -> tuple[Counter[str], Counter[tuple[int, int]]]:
    """Return how the actions ended, and in which cells those began that ended otherwise than in the maze."""
    stage, rng = Sim2dStage(floor, 0, Sim2dOptions(base=base)), np.random.default_rng(0)
    cells, found, where = floor.maze.free_cells, Counter[str](), Counter[tuple[int, int]]()
    while found.total() < actions:
        try:
            seen = stage.place(cells[int(rng.integers(len(cells)))])
        except TwonavError:
            continue  # the outline fits there at no heading
        for action in rng.integers(len(Action), size=FROM_EACH_PLACE):
            before, should = seen.true_cell, floor.maze.moved(seen.cell, Action(action))
            result = stage.act(int(action), Clock(), to_nobody)
            seen = result.observation
            if result.outcome != REACHED and should != before:
                kind = f"{result.outcome}, though the cell is free"
            elif seen.true_cell != (should if result.outcome == REACHED else before):
                kind = "in the wrong cell"
            else:
                kind = "as in the maze"
            found[kind] += 1
            where[before] += kind != "as in the maze"
    return found, where


def main() -> None:
    """Print the counts of both scenes and both bases."""
    actions = int(sys.argv[1]) if len(sys.argv) > 1 else ACTIONS
    for scene in ("apartment", "kitchen"):
        floor = read_floor(scene)
        for base in ("omni", "differential"):
            found, where = endings(floor, base, actions)
            kinds = ", ".join(f"{kind} {number}" for kind, number in found.most_common())
            tight = ", ".join(f"({cell[0]}, {cell[1]}) {number}" for cell, number in where.most_common(5) if number)
            print(f"{scene}, {base}: of {found.total():,} random actions: {kinds}; most in cells {tight or '-'}")


if __name__ == "__main__":
    main()
