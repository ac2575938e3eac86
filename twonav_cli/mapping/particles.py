"""The particles: where each is, how it is weighted, its map and the path it has come.

P particles, N beams that hit something. Lengths are in cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import MappingConfig
from twonav_cli.errors import unknown_name
from twonav_cli.geometry import FloatArray, wrap_angles
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cell_units import composed
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.path_tree import PathTree
from twonav_cli.mapping.proposal import COLUMNS, DRAWN, LOG_WEIGHT, POSE, PROPOSALS, SHARE, propose
from twonav_cli.mapping.resampling import effective_number, normalised, systematic
from twonav_cli.mapping.scan_match import matching_rule


class Particles:
    """Hypotheses of the path so far.

    Attributes:
        poses: [P, 3] where each believes the robot to be.
        store: Their maps.
        paths: Where each has been at every keyframe.
        best: The one whose scans have fitted best so far.
    """

    def __init__(self, config: MappingConfig, start: FloatArray, rng: np.random.Generator) -> None:
        if config.proposal not in PROPOSALS:
            raise unknown_name("proposal", config.proposal, PROPOSALS)
        self.poses: FloatArray = np.tile(start, (config.particles, 1))
        self.store = TileStore(config.particles)
        self.paths = PathTree(config.particles)
        self.best = 0
        self._config = config
        self._rng = rng
        self._rule = matching_rule(config)
        self._log_weights = np.zeros(config.particles)
        self._log_totals = np.zeros(config.particles)
        """Like the weights, but never begun anew when particles are drawn again: what the best one is chosen by."""

    @property
    def weights(self) -> FloatArray:
        """[P] normalised weights."""
        return normalised(self._log_weights)

    @property
    def effective(self) -> float:
        """Effective number of particles (Eq. 20)."""
        return effective_number(self.weights)

    @property
    def few(self) -> bool:
        """Whether so few particles carry the weight that they should be drawn again."""
        return self.effective < self._config.resample_share * len(self.poses)

    def begin(self, stamp_s: float, sensor_motion: FloatArray, points: FloatArray, hits: int | None = None) -> None:
        """Put the first scan into one map, which all share: they believe the same still."""
        self.paths.grow(stamp_s, self.poses)
        carve_scan(self.store, 0, composed(self.poses[:1], sensor_motion)[0], points, hits)
        self.store.draw_again(np.zeros(len(self.poses), dtype=np.int64))

    def move(
        self, points: FloatArray, normals: FloatArray, followed: FloatArray, driven: FloatArray, covariances: FloatArray
    ) -> int:
        """Move and weigh every particle by the improved proposal.

        Args:
            points: [N, 2] ends of the beams in the robot's frame.
            normals: [N, 2] across the surfaces.
            followed: [3] motion since the keyframe before as the scan matcher followed it.
            driven: [3] the same by odometry.
            covariances: [P, 3, 3] of where odometry says that each one is.

        Returns:
            How many scans did not fit, so that odometry was kept (§4.1).
        """
        store, config, out = self.store, self._config, np.zeros((len(self.poses), COLUMNS))
        informations = np.asarray(np.linalg.inv(covariances), dtype=np.float64)
        roots = np.asarray(np.linalg.cholesky(covariances), dtype=np.float64)
        draws = self._rng.standard_normal((len(self.poses), 3))
        propose(
            (store.cells, store.walls, store.tables, store.first_row, store.first_col), points, normals,
            composed(self.poses, followed), composed(self.poses, driven), informations, roots, draws, self._rule,
            config.least_match, config.proposal == DRAWN, out,
        )  # fmt: skip
        self.poses = np.ascontiguousarray(out[:, POSE])
        self.poses[:, 2] = wrap_angles(self.poses[:, 2])
        self._log_weights += config.weight_gain * out[:, LOG_WEIGHT]
        self._log_totals += config.weight_gain * out[:, LOG_WEIGHT]
        self.best = int(np.argmax(self._log_totals))
        return int((out[:, SHARE] < 0).sum())

    def map_scan(self, stamp_s: float, sensor_motion: FloatArray, points: FloatArray, hits: int | None = None) -> None:
        """Put a scan into every particle's map from where it believes to be.

        Args:
            stamp_s: When it was taken.
            sensor_motion: [3] pose of the range finder in the robot's frame.
            points: [N, 2] ends of the beams in the range finder's frame.
            hits: How many of them, the first ones, hit something; default: all.
        """
        self.paths.grow(stamp_s, self.poses)
        for particle, sensor in enumerate(composed(self.poses, sensor_motion)):
            carve_scan(self.store, particle, sensor, points, hits)

    def draw_again(self) -> None:
        """Go on with particles drawn by their weights, which then weigh the same."""
        parents: NDArray[np.int64] = systematic(self.weights, self._rng)
        self.store.draw_again(parents)
        self.paths.draw_again(parents)
        self.poses, self._log_totals = self.poses[parents], self._log_totals[parents]
        self._log_weights = np.zeros(len(parents))
        self.best = int(np.argmax(self._log_totals))
