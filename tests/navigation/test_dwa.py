import math

import numpy as np
import pytest
from kinematic_body import KinematicBody

from twonav_cli.config import DriveConfig
from twonav_cli.geometry import Pose, Twist, compose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import CostMap
from twonav_cli.navigation.dwa import DynamicWindow, Leg
from twonav_cli.navigation.dwa_costs import clearance_cost, heading_cost, path_cost, speed_cost, target_cost
from twonav_cli.navigation.rollout import braking_time_s, displacement
from twonav_cli.navigation.velocity_window import sample_into

CONFIG = DriveConfig()
FRAME = GridFrame(0.0, 0.0, 0.05, 80, 80)
FAR = np.full(180, 8.0)


def blobs(seed: int) -> np.ndarray:
    """Return a map [80, 80] with single pixels here and there."""
    return np.random.default_rng(seed).random(FRAME.shape) < 0.006


def window_at(occupied: np.ndarray, pose: Pose, leg: Leg) -> CostMap:
    window = CostMap(occupied, FRAME)
    window.begin(pose, (leg.target_x_m, leg.target_y_m))
    window.add_scan(pose, FAR, 0.5)
    return window


def test_each_cost_term_measures_what_its_name_says():
    assert target_cost(1.0, 2.0, 4.0, 6.0) == pytest.approx(5.0)
    assert heading_cost(math.pi - 0.1, -math.pi + 0.1) == pytest.approx(0.2)
    assert path_cost(3.0, 1.5, 0.0, 1.0, 1.0, 0.0) == pytest.approx(0.5)
    assert [speed_cost(v, 0.6) for v in (0.0, 0.3, 0.6)] == pytest.approx([1.0, 0.5, 0.0])
    assert [clearance_cost(d, 0.2, 0.4) for d in (0.1, 0.2, 0.3, 0.5)] == pytest.approx([1.0, 1.0, 0.5, 0.0])


def test_zero_is_among_the_samples_whenever_it_can_be_reached():
    samples = np.empty(6)
    sample_into(-0.13, 0.27, samples)
    assert 0.0 in samples
    sample_into(0.1, 0.5, samples)
    assert (samples[0], samples[-1]) == (pytest.approx(0.1), pytest.approx(0.5))
    assert samples.min() > 0


def test_braking_time_covers_a_period_and_the_braking_distance():
    speed, deceleration, tick_s = 0.6, 2.0, 0.1
    assert speed * braking_time_s(speed, deceleration, tick_s) == pytest.approx(0.06 + 0.6**2 / 4)


def test_a_curved_candidate_follows_its_arc_and_a_straight_one_does_not_bend():
    assert displacement(0.5, 0.0, math.pi, 1.0, True) == pytest.approx((0.0, 1.0 / math.pi))
    assert displacement(0.5, 0.2, 2.0, 0.5, False) == pytest.approx((0.25, 0.1))
    assert displacement(0.5, 0.0, 0.0, 1.0, True) == pytest.approx((0.5, 0.0))


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_every_candidate_can_be_reached_within_the_acceleration_limits(base):
    planner = DynamicWindow(CONFIG, base)
    pose, leg = Pose(1.0, 2.0, 0.5), Leg(1.0, 2.0, 1.4, 2.0, 0.0)
    plan = planner.plan(window_at(np.zeros(FRAME.shape, dtype=bool), pose, leg), pose, Twist(0.3, 0.0, 0.0), leg)
    now = 0.3 * np.array([math.cos(0.5), math.sin(0.5)])
    change = np.linalg.norm(plan.candidates[:, :2] - now, axis=1)
    assert change.max() <= 1.01 * CONFIG.acceleration_mps2 * CONFIG.tick_s
    assert np.abs(plan.candidates[:, 2]).max() <= CONFIG.turn_acceleration_radps2 * CONFIG.tick_s + 1e-9
    assert np.linalg.norm(plan.candidates[:, :2], axis=1).max() <= CONFIG.max_forward_mps + 1e-9
    assert len(plan.candidates) > 200


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_the_choice_is_the_same_whether_or_not_every_cost_is_complete(base):
    planner = DynamicWindow(CONFIG, base)
    rng = np.random.default_rng(7)
    chosen = set()
    for seed in range(30):
        pose = Pose(*rng.uniform(1.5, 2.5, 2), rng.uniform(-3, 3))
        leg = Leg(pose.x_m, pose.y_m, pose.x_m, pose.y_m + 0.4, math.pi / 2)
        window, twist = window_at(blobs(seed), pose, leg), Twist(rng.uniform(0, 0.6), 0.0, rng.uniform(-1, 1))
        short = planner.plan(window, pose, twist, leg)
        whole = planner.plan(window, pose, twist, leg, whole=True)
        assert short.best == whole.best
        assert short.twist == whole.twist
        if whole.best >= 0:
            assert whole.costs[whole.best] == whole.costs.min()
        chosen.add(whole.best)
    assert len(chosen) > 3


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_an_admissible_candidate_can_brake_without_touching(base):
    planner = DynamicWindow(CONFIG, base)
    rng = np.random.default_rng(8)
    admissible = blocked = 0
    for seed in range(40):
        occupied = blobs(seed)
        pose = Pose(*rng.uniform(1.5, 2.5, 2), rng.uniform(-3, 3))
        truth = KinematicBody(occupied, FRAME, pose)
        if truth.touches(pose):
            continue
        leg = Leg(pose.x_m, pose.y_m, pose.x_m + 0.4, pose.y_m, 0.0)
        plan = planner.plan(window_at(occupied, pose, leg), pose, Twist(0.4, 0.0, 0.0), leg, whole=True)
        blocked += int(np.isinf(plan.costs).sum())
        for i in rng.choice(len(plan.candidates), 10):
            if np.isinf(plan.costs[i]):
                continue
            vx, vy, turn = plan.candidates[i]
            stop_s = braking_time_s(math.hypot(vx, vy), CONFIG.acceleration_mps2, CONFIG.tick_s)
            dx, dy = displacement(vx, vy, turn, stop_s, base == "differential")
            end = compose(Pose(pose.x_m + dx, pose.y_m + dy, pose.theta_rad), Pose(0.0, 0.0, turn * stop_s))
            assert not truth.touches(end)
            admissible += 1
    assert admissible > 50
    assert blocked > 50


def test_a_robot_that_seems_to_stand_in_something_may_only_do_what_leads_no_deeper():
    occupied = np.zeros(FRAME.shape, dtype=bool)
    occupied[:, 24:30] = True
    pose, leg = Pose(1.006, 2.0, 0.0), Leg(1.006, 2.0, 1.4, 2.0, 0.0)
    window, planner = window_at(occupied, pose, leg), DynamicWindow(CONFIG, "omni")
    deep = planner.overlap_at(window, pose)
    plan = planner.plan(window, pose, Twist(0.0, 0.0, 0.0), leg, allowed_overlap=deep, whole=True)
    assert deep > 0
    assert np.isinf(plan.costs[plan.candidates[:, 0] > 0.05]).all()
    assert np.isfinite(plan.costs[plan.candidates[:, 0] < -0.05]).any()
    assert plan.twist.forward_mps < 0
