import numpy as np
import pytest

from twonav_cli.localizer.errors_report import error_metrics


def test_errors_are_metres_and_degrees_and_turn_the_short_way_round() -> None:
    true = np.zeros((4, 3))
    true[:, 2] = np.pi - 0.01
    estimated = true + np.array([[3.0, 4.0, 0.02], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    metrics = error_metrics(estimated, true)
    assert metrics["n"] == 4
    assert metrics["pos_mean_m"] == pytest.approx(1.5)
    assert metrics["pos_median_m"] == pytest.approx(0.5)
    assert metrics["ang_mean_deg"] == pytest.approx(np.rad2deg(0.02) / 4)
    assert set(metrics) == {
        "n", "pos_mean_m", "pos_std_m", "pos_median_m", "pos_p95_m", "pos_p99_m", "ang_mean_deg", "ang_std_deg",
        "ang_median_deg", "ang_p95_deg", "ang_p99_deg", "within_5cm_5deg", "within_25cm_2deg",
    }  # fmt: skip


def test_the_share_within_a_bound_counts_position_and_heading_together() -> None:
    true = np.zeros((5, 3))
    estimated = np.array([[0.04, 0.0, 0.0], [0.04, 0.0, 0.1], [0.2, 0.0, 0.01], [0.2, 0.0, 0.05], [0.0, 0.3, 0.0]])
    metrics = error_metrics(estimated, true)
    assert metrics["within_5cm_5deg"] == pytest.approx(1 / 5)  # 0.1 rad is 5.7 degrees
    assert metrics["within_25cm_2deg"] == pytest.approx(2 / 5)
    assert metrics["pos_std_m"] == pytest.approx(np.std([0.04, 0.04, 0.2, 0.2, 0.3]))
