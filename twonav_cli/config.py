"""Settings: small frozen tables whose defaults are the paper's unless the sentence says "ours".

The sentence of a field is the command-line help; it ends in its source.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from twonav_cli.errors import unknown_name


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


@dataclass(frozen=True)
class Rewards:
    """What an action earns."""

    goal: float = _setting(100.0, "Reward for entering the goal's cell (§4.3).")
    blocked: float = _setting(-2.0, "Reward for running into a blocked cell (§4.3).")
    step: float = _setting(-0.1, "Reward of every other action (§4.3).")


@dataclass(frozen=True)
class LearningConfig:
    """How a Q-learner learns in one stage."""

    learner: str = _setting("multi", "single, multi or an explorer: a key of LEARNERS (§4.3, explorers ours).")
    learning_rate: float = _setting(1.0, "Learning rate alpha of Eq. 2 (§4.3: 1.0 maze, 0.1 2D, 0.8 3D).")
    discount: float = _setting(0.95, "Discount gamma of Eq. 2 (ours; the paper does not say).")
    initial_q: float = _setting(80.0, "Value of every Q entry at the start (§4.3).")
    exploration: str = _setting("boltzmann", "boltzmann (Eq. 6) or epsilon-greedy (§4.3).")
    temperature: float = _setting(2.0, "Boltzmann temperature T at the start (§4.3).")
    temperature_decay: float = _setting(0.998, "Factor on T after each trial (§4.3).")
    cooling: str = _setting("per-goal", "T cools per-goal, anew for each, or once, over all goals (ours).")
    epsilon: float = _setting(0.1, "Share of random actions of epsilon-greedy (§4.3.1).")
    replay_period_steps: int = _setting(500, "Actions between two sweeps of the replay buffer (ours).")
    replay_batch: int = _setting(32, "Mini-batch of a replay sweep (ours).")
    replay_learning_rate: float | None = _setting(None, "Alpha of a replay sweep; none: that of Eq. 2 (ours).")
    backups_per_step: int = _setting(20, "Backups after each action of prioritized sweeping (ours).")
    initial_td_error: float = _setting(1e4, "Entry of the TD-error table before the first visit (ours).")
    trial_limit_steps: int = _setting(500, "Actions after which a trial fails (ours).")
    goal_selection: str = _setting("td-error", "td-error, random or sequential (§3.1.2).")
    consecutive_successes: int = _setting(50, "Trials in a row that must succeed from each start (§4.3).")
    max_step_difference: float = _setting(10.0, "Mean difference in actions that still counts as learned (§4.3).")
    rewards: Rewards = field(default_factory=Rewards)

    @property
    def sweep_rate(self) -> float:
        """Alpha of a replay sweep."""
        return self.learning_rate if self.replay_learning_rate is None else self.replay_learning_rate


LEARNING_PRESETS: dict[str, LearningConfig] = {
    "maze": LearningConfig(),
    "paper-maze": LearningConfig(discount=0.99),
    "2d": LearningConfig(learning_rate=0.1, exploration="epsilon-greedy"),
    "3d": LearningConfig(
        learning_rate=0.8,
        exploration="epsilon-greedy",
        consecutive_successes=2,
        trial_limit_steps=200,
        replay_learning_rate=0.1,
    ),
}
"""Stage to settings. A sweep in 3D has the rate of 2D: with alpha 0.8 the last of a shuffled entry's experiences, which
may come of a wrong estimate, would decide almost alone (ours)."""


def learning_preset(name: str, **changes: Any) -> LearningConfig:
    """Return a preset with some fields changed.

    Raises:
        TwonavError: There is no preset of that name.
    """
    if name not in LEARNING_PRESETS:
        raise unknown_name("preset", name, LEARNING_PRESETS)
    return replace(LEARNING_PRESETS[name], **changes)


ROBOT_FOOTPRINT_M: tuple[tuple[float, float], ...] = (
    (0.21, 0.12),
    (0.13, 0.19),
    (-0.20, 0.19),
    (-0.29, 0.12),
    (-0.29, -0.12),
    (-0.20, -0.19),
    (0.13, -0.19),
    (0.21, -0.12),
)
"""Convex outline about the wheel axle, forward and left, counter-clockwise from the front left (Pioneer 3-DX: front
0.21 m, rear 0.29 m, width 0.38 m; corners cut as on the rounded top plate)."""

ROBOT_INSCRIBED_M = 0.19
"""Radius of the largest circle about the axle inside the outline."""

ROBOT_CIRCUMSCRIBED_M = 0.315
"""Radius of the smallest circle about the axle around the outline."""

ROBOT_HEIGHT_M = 0.45
"""Anything between 0.03 m and this height above the floor is an obstacle."""

OBSTACLE_FLOOR_M = 0.03
"""What is lower than this the robot drives over (the maker's climbable step is 2.5 cm)."""

MAP_RESOLUTION_M = 0.05
"""Cell of the occupancy map (§4.3)."""

MAZE_RESOLUTION_M = 0.40
"""Cell of the approximated maze (§4.3.1)."""

FRAME_SPACING_M = 0.25
"""Distance between the places where frames are collected (§4.1)."""

IMAGE_PX = 84
"""Edge of the camera image (§4.2.2)."""

BASES = ("omni", "differential")
"""What the robot drives on: it moves in any direction, or only along its heading (§3.1.3, Fig. 5)."""

LOCALIZERS = ("filtered", "raw", "truth")
"""Where the 3D stage has its pose from: the camera fused with odometry, each picture alone, or the simulator."""


@dataclass(frozen=True)
class OdometryNoise:
    """The five error terms of odometry (§3.1.3): three direct, two that couple turning and driving.

    Each is a standard deviation; the values are ours, the size of a Pioneer on a hard floor.
    """

    forward_per_m: float = _setting(0.02, "Error along the motion, metres per metre driven (§3.1.3, value ours).")
    sideways_per_m: float = _setting(0.01, "Error across the motion, metres per metre driven (§3.1.3, value ours).")
    turn_per_rad: float = _setting(0.03, "Heading error per radian turned (§3.1.3, value ours).")
    turn_per_m: float = _setting(0.02, "Heading error, radians per metre driven (§3.1.3, value ours).")
    shift_per_rad: float = _setting(0.005, "Position error, metres per radian turned (§3.1.3, value ours).")


@dataclass(frozen=True)
class MappingConfig:
    """How the map is made from scans (Rao-Blackwellized particle filter, Grisetti et al. 2007)."""

    particles: int = _setting(30, "Particles, each with a map of its own (ours; the paper does not say).")
    resolution_m: float = _setting(0.05, "Edge of a map cell, metres (§4.3).")
    max_range_m: float = _setting(20.0, "Beams are cut at this range, metres: free up to it (ours).")
    keyframe_distance_m: float = _setting(0.5, "Distance driven after which a scan goes into the map, metres (ours).")
    keyframe_turn_rad: float = _setting(0.25, "Angle turned after which a scan goes into the map, radians (ours).")
    proposal: str = _setting("gaussian", "gaussian: draw around the maximum (Grisetti et al. 2007); maximum: take it.")
    weight_gain: float = _setting(0.005, "Exponent of a particle's weight at each keyframe (ours).")
    evidence: float = _setting(6.0, "Exponent of a scan's likelihood in the proposal (ours: beams are good to 2 cm).")
    sigma_m: float = _setting(0.05, "Deviation of a beam's end from the map, metres (ours).")
    wide_sigma_m: float = _setting(0.12, "The same at the beginning of scan matching, metres (ours).")
    least_match: float = _setting(0.3, "Least share of beams that must fit; below, odometry is kept (§4.1; ours).")
    resample_share: float = _setting(0.5, "Effective share of particles below which they are drawn again (2007).")
    error_m_per_m: float = _setting(0.1, "Odometry's deviation per metre driven, metres (ours).")
    error_m_per_rad: float = _setting(0.1, "Odometry's deviation per radian turned, metres (ours).")
    error_rad_per_m: float = _setting(0.1, "Odometry's deviation per metre driven, radians (ours).")
    error_rad_per_rad: float = _setting(0.1, "Odometry's deviation per radian turned, radians (ours).")
    error_m: float = _setting(0.05, "Odometry's deviation however short the way, metres (ours).")
    error_rad: float = _setting(0.1, "Odometry's deviation however short the way, radians (ours).")


@dataclass(frozen=True)
class DriveConfig:
    """The local controller: the dynamic window approach on a local cost map."""

    tick_s: float = _setting(0.1, "Control period (ours).")
    horizon_s: float = _setting(1.0, "How far candidate motions are rolled out (ours).")
    rollout_poses: int = _setting(12, "Poses checked along a candidate (ours).")
    max_forward_mps: float = _setting(0.6, "Fastest forward speed (ours; the robot can 1.2).")
    max_sideways_mps: float = _setting(0.6, "Fastest sideways speed of the omnidirectional base (ours).")
    max_turn_radps: float = _setting(2.5, "Fastest turn (ours; the robot can 5.2).")
    acceleration_mps2: float = _setting(2.0, "Acceleration limit (ours).")
    turn_acceleration_radps2: float = _setting(8.0, "Turning acceleration limit (ours).")
    position_tolerance_m: float = _setting(0.05, "Distance to the cell's centre that counts as reached (ours).")
    timeout_s: float = _setting(8.0, "Time after which an action has timed out (ours).")
    blocked_after_s: float = _setting(1.2, "Time without progress after which an action is blocked (ours).")
    range_cut_m: float = _setting(0.5, "Range at which the range finder is cut for driving (Fig. 5).")
    inflation_m: float = _setting(0.35, "Distance at which an obstacle stops costing anything (ours).")
