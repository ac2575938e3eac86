"""How Gymnasium comes to know the environments."""

from __future__ import annotations

import subprocess
import sys

import gymnasium
import pytest

from twonav_cli.environments.registration import ENVIRONMENTS, MAZE_ID, register

ONE_LINE = """
import sys, gymnasium
env = gymnasium.make("twonav_cli.environments:twonav/Maze-v0", maze="random")
env.reset(seed=0)
print(env.spec.id, *(name for name in ("mujoco", "torch", "rerun", "numba") if name in sys.modules))
"""


def test_one_line_makes_the_environment_in_a_fresh_interpreter_without_heavy_imports() -> None:
    done = subprocess.run([sys.executable, "-W", "error", "-c", ONE_LINE], capture_output=True, text=True, check=False)
    assert done.stdout.split() == [MAZE_ID], done.stderr


@pytest.mark.filterwarnings("error")
def test_registering_twice_changes_nothing() -> None:
    register()
    before = {name: gymnasium.registry[name] for name in ENVIRONMENTS}
    register()
    assert all(gymnasium.registry[name] is spec for name, spec in before.items())


def test_three_worlds_are_registered() -> None:
    assert set(ENVIRONMENTS) == {"twonav/Maze-v0", "twonav/Sim2D-v0", "twonav/Apartment-v0"}
