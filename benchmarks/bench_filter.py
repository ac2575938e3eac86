"""Milliseconds of the belief filter: one prediction (Eq. 4) and one correction (Eq. 5), by number of particles.

Run: python benchmarks/bench_filter.py. Timed by the CPU time of one thread.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, compose
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.belief_filter import BeliefFilter, FilterConfig

FRAME = GridFrame(0.0, 0.0, 0.2, 45, 70)
MOTION = Pose(0.2, 0.0, 0.1)
LOOKS = 300
ROUNDS = 5


def look(pose: Pose, rng: np.random.Generator) -> Belief:
    """Return a belief in five places and three headings, as many as the network names."""
    x_m, y_m = (rng.uniform(0.0, end, size=5) for end in (14.0, 9.0))
    x_m[0], y_m[0] = pose.x_m + 0.03 * rng.standard_normal(), pose.y_m + 0.03 * rng.standard_normal()
    places = np.column_stack([[0.8, 0.08, 0.06, 0.04, 0.02], x_m, y_m, np.full(5, 0.05)])
    angles = np.array([pose.theta_rad, *rng.uniform(-np.pi, np.pi, size=2)])
    headings = np.column_stack([[0.9, 0.06, 0.04], angles, np.full(3, 0.03)])
    return Belief(places, headings, 0.02, 60.0, np.zeros(FRAME.shape, dtype=np.float32), FRAME)


def milliseconds(particles: int) -> tuple[float, float]:
    """Return the CPU milliseconds of one prediction and of one correction, the least of some rounds."""
    predicted, corrected = [], []
    for number in range(ROUNDS):
        rng = np.random.default_rng(number)
        following = BeliefFilter(replace(FilterConfig(), particles=particles), OdometryNoise(), rng)
        pose, predict_s, correct_s = Pose(7.0, 4.0, 0.0), 0.0, 0.0
        for _ in range(LOOKS):
            pose, belief = compose(pose, MOTION), look(pose, rng)
            begin = time.process_time()
            following.predict(MOTION)
            middle = time.process_time()
            following.correct(belief)
            predict_s, correct_s = predict_s + middle - begin, correct_s + time.process_time() - middle
        predicted.append(1e3 * predict_s / LOOKS)
        corrected.append(1e3 * correct_s / LOOKS)
    return min(predicted), min(corrected)


def main() -> None:
    """Print both for each number of particles."""
    for particles in (500, 1000, 2000, 4000):
        predict_ms, correct_ms = milliseconds(particles)
        print(f"{particles} particles: predict {predict_ms:.2f} ms, correct {correct_ms:.2f} ms")


if __name__ == "__main__":
    main()
