"""The belief filter: particles that follow odometry (Eq. 4) and are weighed by what pictures say (Eq. 5).

Beside the particles the filter keeps one number: how likely the robot is somewhere else altogether, because it was
carried off or because no look has placed it yet. From there every look draws new particles, which outweigh the old ones
only when the looks after it agree (mixture proposals, Thrun et al. 2001; sensor resetting, Lenser and Veloso 2000).

P particles, S seeds, K places, J headings. A particle is x_m, y_m, theta_rad in the map frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import FloatArray, Pose, wrap_angles
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.particle_clusters import clusters_of
from twonav_cli.mapping.resampling import effective_number, systematic

NEAR_M, NEAR_RAD = 0.15, 0.15
"""Deviations within which particles are near a place that a look names, so that its bell orders them (ours)."""

LEAST_MEAN = 0.2
"""Particles that stand only at the edge of what a look names, below this share of its height on their mean, become less
than `evidence` times likelier (ours)."""

TINY = 1e-300

MOST_PARTICLES = 1.5
"""Particles are drawn again when looks have added so many that there are this many times the usual number (ours)."""


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


@dataclass(frozen=True)
class FilterConfig:
    """How odometry and looks are fused. The paper gives Eq. 4 and 5 and leaves them out, so every value is ours."""

    particles: int = _setting(1000, "Particles after each drawing (ours).")
    seeds: int = _setting(60, "Particles that each look adds from its own belief (ours).")
    carried_off: float = _setting(0.004, "Probability that the robot was carried off between two looks (ours).")
    doubt: float = _setting(0.1, "Least probability that a look names none of the right places (ours).")
    evidence: float = _setting(3.5, "How much likelier a look makes a place that it is sure of (ours).")
    widening: float = _setting(1.5, "Factor on a bell's deviation: looks near each other err alike (ours).")
    least_sigma_m: float = _setting(0.03, "Deviation of a place on top of the bell's own, metres (ours).")
    least_sigma_rad: float = _setting(0.015, "Deviation of a heading on top of the bell's own, radians (ours).")
    tail_share: float = _setting(0.02, "Height of a bell's wide tail, as a share: large errors are frequent (ours).")
    tail_width: float = _setting(3.0, "Factor on the deviation of that tail (ours).")
    fresh_m: float = _setting(0.1, "Distance from the last look at which a look tells something new, metres (ours).")
    fresh_rad: float = _setting(0.15, "Turn since the last look at which a look tells something new, radians (ours).")
    stale: float = _setting(0.3, "Exponent of a look from where the last one was taken (ours).")
    inflation: float = _setting(1.5, "Factor on odometry's deviations (ours).")
    jitter_m: float = _setting(0.004, "Deviation between particles drawn from the same one, metres (ours).")
    jitter_rad: float = _setting(0.003, "Deviation between particles drawn from the same one, radians (ours).")
    resample_share: float = _setting(0.5, "Effective share of particles below which they are drawn again (ours).")
    off_floor: float = _setting(0.2, "Factor, above 0, on the weight of a particle where the robot cannot be (ours).")


@dataclass(frozen=True)
class FreeFloor:
    """Where the robot can be: [rows, cols] bool, and where that grid lies."""

    free: NDArray[np.bool_]
    frame: GridFrame

    def holds(self, poses: FloatArray) -> NDArray[np.bool_]:
        """Return which poses [P, 3] stand on free floor; outside of the grid there is none."""
        rows, cols, inside = self.frame.cells_at(poses[:, 0], poses[:, 1])
        return np.asarray(inside & self.free[rows, cols])


@dataclass(frozen=True)
class FilteredPose:
    """Where the filter believes the robot to be.

    Attributes:
        pose: Mean of the likeliest cluster of particles.
        spread_m: Deviation of that cluster's positions, root of the mean squared distance to the mean.
        spread_rad: Deviation of its headings.
        probability: Probability of that cluster.
        particles: [P, 3] all particles.
        weights: [P] their probabilities.
        others: [C, 4] the other clusters, the likeliest first: probability, x_m, y_m, theta_rad.
    """

    pose: Pose
    spread_m: float
    spread_rad: float
    probability: float
    particles: FloatArray
    weights: FloatArray
    others: FloatArray


def predict(particles: FloatArray, motion: Pose, noise: OdometryNoise, rng: np.random.Generator) -> FloatArray:
    """Return particles [P, 3] drawn from where a motion leads to (Eq. 4).

    The errors are those of `twonav_cli.motion`. Each particle turns a little wrong somewhere on the way, so half of
    its turning error turns the way as well.

    Args:
        particles: [P, 3] drawn from the belief before.
        motion: What odometry reports, in the robot's frame before it.
        noise: Deviations after one metre or one radian.
        rng: Six numbers are drawn for each particle.
    """
    along, across, turning, veering, skid_x, skid_y = rng.standard_normal((6, len(particles)))
    driven_m, turned_rad = math.hypot(motion.x_m, motion.y_m), abs(motion.theta_rad)
    root_m, root_rad = math.sqrt(driven_m), math.sqrt(turned_rad)
    turn_error_rad = noise.turn_per_rad * root_rad * turning + noise.turn_per_m * root_m * veering
    along_m = driven_m + noise.forward_per_m * root_m * along
    across_m = noise.sideways_per_m * root_m * across
    direction_rad = particles[:, 2] + math.atan2(motion.y_m, motion.x_m) + 0.5 * turn_error_rad
    cos, sin = np.cos(direction_rad), np.sin(direction_rad)
    shift_m = noise.shift_per_rad * root_rad
    return np.column_stack(
        [
            particles[:, 0] + cos * along_m - sin * across_m + shift_m * skid_x,
            particles[:, 1] + sin * along_m + cos * across_m + shift_m * skid_y,
            wrap_angles(particles[:, 2] + motion.theta_rad + turn_error_rad),
        ]
    )


def correct(weights: FloatArray, likelihood: FloatArray) -> FloatArray:
    """Return the weights [P] of predicted particles after a look (Eq. 5).

    The belief on the right of Eq. 5 is the prediction of Eq. 4, from which the particles are drawn; eta is what makes
    the weights add up to 1.

    Args:
        weights: [P] before the look, the weights of Eq. 4's particles.
        likelihood: [P] p(z | x) at each, up to a common factor.
    """
    unscaled = likelihood * weights
    eta = 1.0 / unscaled.sum()
    return np.asarray(eta * unscaled)


def look_likelihood(belief: Belief, particles: FloatArray, weights: FloatArray, config: FilterConfig) -> FloatArray:
    """Return how much likelier a look makes each particle [P, 3] than one that is far from what it names.

    The particles around a place that the look is sure of become `evidence` times likelier, on their weighted mean;
    around one of several, less, in proportion to its probability. Which particles there more and which less, the shape
    of the belief's bells says, widened. Their height says nothing: a wrong look is often followed by more of the same,
    so looks in a row must not multiply as if each were a witness of its own.
    """
    squared = (particles[:, :1] - belief.places[:, 1]) ** 2 + (particles[:, 1:2] - belief.places[:, 2]) ** 2
    away_rad = wrap_angles(particles[:, 2:] - belief.headings[:, 1])
    place = _around(squared, belief.places, config.least_sigma_m, NEAR_M, config)
    heading = _around(away_rad**2, belief.headings, config.least_sigma_rad, NEAR_RAD, config)
    shape, named, near = place * heading
    mean = max(float(weights @ (near * shape)) / max(float(weights @ near), TINY), LEAST_MEAN)
    gain = near * (shape / mean - 1.0) + (config.evidence - 1.0) * named / mean
    return np.asarray(1.0 + (1.0 - belief.lost) * gain)


def _around(squared: FloatArray, bells: FloatArray, least: float, near: float, config: FilterConfig) -> FloatArray:
    """Return how particles lie to bells [K, 3 or 4] (weight first, deviation last) at squared distances [P, K].

    Returns:
        [3, P]: height of the widened bells, each 1 in its middle; the same with each as high as its weight; and how
        near one is, 0 to 1, where one that is not the likeliest counts less.
    """
    share = bells[:, 0] / bells[:, 0].max()
    broad = np.hypot(config.widening * bells[:, -1], least)
    scaled = squared / (-2.0 * broad**2)
    heights = (1.0 - config.tail_share) * np.exp(scaled) + config.tail_share * np.exp(scaled / config.tail_width**2)
    closeness = np.exp(squared / (-2.0 * (broad**2 + near**2))) @ share
    return np.stack([heights.sum(axis=1), heights @ bells[:, 0], np.minimum(closeness, 1.0)])


MOST_DOUBT = 0.99
"""A look that names no place at all still begins a belief: some pose must be told (ours)."""


class BeliefFilter:
    """Follows the robot: `predict` with every motion, `correct` with every look."""

    def __init__(
        self,
        config: FilterConfig,
        noise: OdometryNoise,
        rng: np.random.Generator,
        floor: FreeFloor | None = None,
    ) -> None:
        """Know nothing yet.

        Args:
            config: Settings.
            noise: The odometry's own deviations; `config` says how much they are rounded up.
            rng: A stream of its own; the same stream, motions and looks give the same poses.
            floor: Where the robot can be; None if that is not known.
        """
        self.config = config
        self._noise = OdometryNoise(**{name: config.inflation * value for name, value in vars(noise).items()})
        self._rng = rng
        self._floor = floor
        self.forget()

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw from another stream from here on."""
        self._rng = rng

    def forget(self) -> None:
        """Know nothing: the next look says where the robot may be."""
        self._particles: FloatArray = np.zeros((0, 3))
        self._weights: FloatArray = np.zeros(0)
        self._elsewhere = 1.0
        self._news = 1.0

    def predict(self, motion: Pose) -> None:
        """Move the belief by what odometry reports, in the robot's frame before it (Eq. 4)."""
        self._particles = predict(self._particles, motion, self._noise, self._rng)
        driven_m, turned_rad = math.hypot(motion.x_m, motion.y_m), abs(motion.theta_rad)
        self._news += driven_m / self.config.fresh_m + turned_rad / self.config.fresh_rad

    def correct(self, belief: Belief) -> FilteredPose:
        """Weigh the belief by what a picture says (Eq. 5) and return where the robot is now."""
        config = self.config
        exponent = min(1.0, max(config.stale, self._news))
        self._news = 0.0
        carried = config.carried_off * exponent
        self._elsewhere += carried * (1.0 - self._elsewhere)
        self._weights *= 1.0 - carried
        likelihood = look_likelihood(belief, self._particles, self._weights, config) ** exponent
        likelihood *= self._on_floor(self._particles)
        seeds, seed_weights = self._seeds(belief)
        self._particles = np.concatenate([self._particles, seeds])
        before = np.concatenate([self._weights, seed_weights, [self._elsewhere - seed_weights.sum()]])
        after = correct(before, np.concatenate([likelihood, np.ones(len(seeds) + 1)]))
        self._weights, self._elsewhere = after[:-1], float(after[-1])
        estimate = self._estimate()
        self._draw_again_if_few()
        return estimate

    def _on_floor(self, poses: FloatArray) -> FloatArray:
        """Return the factor [P] on the weight of poses [P, 3] for where they stand."""
        if self._floor is None:
            return np.ones(len(poses))
        return np.where(self._floor.holds(poses), 1.0, self.config.off_floor)

    def _seeds(self, belief: Belief) -> tuple[FloatArray, FloatArray]:
        """Return poses [S, 3] drawn from a look, and the weight [S] that moves to them from elsewhere."""
        config = self.config
        count = max(config.seeds, round(self._elsewhere * config.particles))
        poses = belief.sample(count, self._rng)
        shares = self._on_floor(poses)
        placed = self._elsewhere * (1.0 - min(max(belief.lost, config.doubt), MOST_DOUBT))
        return poses, placed * shares / shares.sum()

    def _draw_again_if_few(self) -> None:
        """Draw the particles again when few carry the weight, or when the looks have added too many."""
        config, weights = self.config, self._weights
        shares = weights / weights.sum()
        few = effective_number(shares) < config.resample_share * len(weights)
        if not few and len(weights) <= MOST_PARTICLES * config.particles:
            return
        drawn = self._particles[systematic(shares, self._rng, config.particles)]
        jitter = (config.jitter_m, config.jitter_m, config.jitter_rad)
        self._particles = drawn + jitter * self._rng.standard_normal(drawn.shape)
        self._particles[:, 2] = wrap_angles(self._particles[:, 2])
        self._weights = np.full(len(drawn), weights.sum() / len(drawn))

    def _estimate(self) -> FilteredPose:
        best, *rest = clusters_of(self._particles, self._weights)
        others = [(c.weight, *c.pose) for c in rest]
        return FilteredPose(
            best.pose, best.spread_m, best.spread_rad, best.weight, self._particles, self._weights,
            np.array(others).reshape(-1, 4),
        )  # fmt: skip
