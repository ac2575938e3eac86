"""Poses from pictures alone, and from all of them together."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, distance_m
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.belief_filter import BeliefFilter, FilterConfig
from twonav_cli.stages.localize import PARTICLES_SHOWN, STILL, FromEveryLook, FromPicture, Image, Located, thinned

IMAGE = np.zeros((84, 84, 3), dtype=np.uint8)
HERE, ELSEWHERE = Pose(2.0, 1.0, 0.0), Pose(9.0, 4.0, 1.0)


def sure_of(pose: Pose, lost: float = 0.02) -> Belief:
    """A picture that fits one place."""
    places, headings = np.array([(1.0, pose.x_m, pose.y_m, 0.05)]), np.array([(1.0, pose.theta_rad, 0.03)])
    return Belief(places, headings, lost, 60.0, np.ones((1, 1), dtype=np.float32), GridFrame(0, 0, 15, 1, 1))


class Pictures:
    """Says of each picture what comes next in a list."""

    def __init__(self, *poses: Pose) -> None:
        self.poses = list(poses)

    def __call__(self, image: Image) -> Belief:
        return sure_of(self.poses.pop(0))


def every_look(*poses: Pose) -> FromEveryLook:
    return FromEveryLook(Pictures(*poses), BeliefFilter(FilterConfig(), OdometryNoise(), np.random.default_rng(0)))


def test_a_picture_alone_is_believed_whatever_was_seen_before() -> None:
    localize = FromPicture(lambda image: Located(poses.pop(0)))
    poses = [HERE, ELSEWHERE]
    assert [localize(IMAGE, STILL).pose for _ in range(2)] == [HERE, ELSEWHERE]


def test_one_wrong_picture_among_right_ones_does_not_move_the_filtered_pose() -> None:
    localize = every_look(*[HERE] * 5, ELSEWHERE)
    for _ in range(5):
        localize(IMAGE, Pose(0.0, 0.0, 0.2))
    found = localize(IMAGE, Pose(0.0, 0.0, 0.2))
    assert distance_m(found.pose, HERE) < 0.3
    assert found.belief is not None
    assert found.belief.pose == pytest.approx(ELSEWHERE)
    assert found.filtered is not None
    assert 0.5 < found.filtered.probability < 1.0


def test_odometry_moves_the_filtered_pose_between_two_looks() -> None:
    after = Pose(2.4, 1.0, 0.0)
    localize = every_look(HERE, HERE, after)
    localize(IMAGE, STILL)
    localize(IMAGE, STILL)
    assert distance_m(localize(IMAGE, Pose(0.4, 0.0, 0.0)).pose, after) < 0.05


def test_what_is_forgotten_has_no_say_in_the_next_look() -> None:
    localize = every_look(*[HERE] * 6, ELSEWHERE)
    for _ in range(6):
        localize(IMAGE, Pose(0.0, 0.0, 0.2))
    localize.forget()
    assert distance_m(localize(IMAGE, STILL).pose, ELSEWHERE) < 0.1


def test_events_get_few_particles_of_three_numbers_each() -> None:
    filtered = every_look(HERE)(IMAGE, STILL).filtered
    assert filtered is not None
    assert filtered.particles.shape == (PARTICLES_SHOWN, 3)
    assert np.hypot(*(filtered.particles[:, :2] - HERE[:2]).T).mean() < 0.3
    assert filtered.others.shape[1] == 3
    assert filtered.probability <= filtered.placed < 1.0


def test_a_particle_is_shown_as_often_as_it_weighs() -> None:
    particles = np.arange(12.0).reshape(4, 3)
    shown = thinned(particles, np.array([0.0, 0.3, 0.0, 0.1]), 100)
    assert (shown == particles[1]).all(axis=1).sum() == 75
    assert (shown == particles[3]).all(axis=1).sum() == 25
