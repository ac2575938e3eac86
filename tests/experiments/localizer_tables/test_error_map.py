"""The mean error of every cell, and where cells lie in a picture."""

from __future__ import annotations

import numpy as np
import pytest
from made_up_localizers import COLS, FIRST_M, HEADINGS, ROWS, cell_poses, made_up_maps

from twonav_cli.experiments.localizer_tables.error_map import cell_means, error_map, heat_of
from twonav_cli.grid import Cell

POSES = cell_poses()


def errors_by_cell() -> np.ndarray:
    """Return errors [120] whose mean is the number of the cell: below and above it by turns."""
    return np.repeat(np.arange(ROWS * COLS, dtype=float), HEADINGS) + np.resize([-0.5, 0.5], len(POSES))


def test_a_cell_has_the_mean_over_its_frames_in_whatever_order_they_come() -> None:
    shuffled = np.random.default_rng(3).permutation(len(POSES))
    centres, means, counts = cell_means(errors_by_cell()[shuffled], POSES[shuffled])
    found = {tuple(centre): mean for centre, mean in zip(centres.tolist(), means, strict=True)}
    assert len(found) == ROWS * COLS
    assert counts.tolist() == [HEADINGS] * ROWS * COLS
    for row in range(ROWS):
        for col in range(COLS):
            centre = (FIRST_M[0] + 0.25 * col, FIRST_M[1] + 0.25 * row)
            assert found[centre] == pytest.approx(row * COLS + col)


def test_a_picture_has_the_highest_cells_on_top_and_nothing_where_no_cell_is() -> None:
    cells = error_map("apartment", "inception-9", errors_by_cell(), POSES, None).cells
    gone = (FIRST_M[0] + 0.25, FIRST_M[1])
    heat, frame = heat_of([cell for cell in cells if tuple(cell[:2]) != gone])
    assert heat.shape == (ROWS, COLS)
    assert heat[0, COLS - 1] == pytest.approx(ROWS * COLS - 1)
    assert heat[ROWS - 1, 0] == pytest.approx(0.0)
    assert np.argwhere(np.isnan(heat)).tolist() == [[ROWS - 1, 1]]
    assert frame.centre_of(Cell(ROWS - 1, 0)) == pytest.approx(FIRST_M)
    assert frame.resolution_m == 0.25


def test_the_summary_names_the_ends_and_the_worst_cell_beside_the_papers() -> None:
    one = error_map("apartment", "inception-9", errors_by_cell(), POSES, {"images": 1})
    assert one.paper == {"min_m": 0.12, "max_m": 0.56}
    assert one.summary["min_m"] == pytest.approx(0.0)
    assert one.summary["max_m"] == pytest.approx(11.0)
    assert one.summary["mean_m"] == pytest.approx(5.5)
    assert (one.summary["cells"], one.summary["frames"]) == (12, 120)
    assert one.summary["worst"] == pytest.approx([FIRST_M[0] + 0.75, FIRST_M[1] + 0.5])
    assert error_map("apartment", "nearest", errors_by_cell(), POSES, None).paper is None


def test_the_report_says_which_frames_and_what_contradicts_the_paper() -> None:
    report = made_up_maps()
    assert "test frames" in report.settings["frames"]
    assert [erratum["row"] for erratum in report.errata] == ["apartment inception-9"]
