"""The recording of Fig. 7, read back: a heat map and the numbers of every network, over the floor plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column

from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame
from twonav_cli.recording.error_maps import (
    APPLICATION_ID,
    LEVELS,
    ErrorPanel,
    error_levels,
    level_classes,
    record_error_maps,
)
from twonav_cli.recording.reader import summarize

FRAME = GridFrame(1.0, 2.0, 0.25, 2, 3)
MAP_FRAME = GridFrame(0.0, 0.0, 0.05, 60, 80)
HEAT = np.array([[0.1, 0.2, np.nan], [0.4, 0.8, 1.6]])


def recorded(path: Path) -> Path:
    panels = [
        ErrorPanel("inception-9", HEAT, FRAME, (0.12, 0.56)),
        ErrorPanel("nearest", HEAT / 2, FRAME, None),
    ]
    occupied = np.zeros(MAP_FRAME.shape, dtype=bool)
    occupied[0] = True
    return record_error_maps(path, "apartment", 3, "twonav reproduce fig7 --seed 3", panels, occupied, MAP_FRAME)


def levels_of(path: Path, network: str) -> np.ndarray:
    (buffer,) = column(batches_of(path)[f"/errors/map/{network}/heat"], "SegmentationImage:buffer", static=True)
    return np.array(buffer[0], dtype=np.uint8).reshape(HEAT.shape)


def test_every_network_has_its_picture_on_one_scale(tmp_path: Path) -> None:
    path = recorded(tmp_path / "fig7.rrd")
    inception, nearest = levels_of(path, "inception-9"), levels_of(path, "nearest")
    assert inception[0, 2] == nearest[0, 2] == 0
    assert inception[1, 2] == LEVELS
    assert nearest[0, 0] == 1
    assert inception[0, 0] == nearest[0, 1]
    assert inception[1, 0] == nearest[1, 1] < inception[1, 1]


def test_every_cell_has_its_number_where_it_lies(tmp_path: Path) -> None:
    chunks = batches_of(recorded(tmp_path / "fig7.rrd"))["/errors/map/inception-9/cells"]
    (places,) = column(chunks, "Points2D:positions", static=True)
    (labels,) = column(chunks, "Points2D:labels", static=True)
    (errors,) = column(chunks, "error_m", static=True)
    found = dict(zip(((round(x, 3), round(y, 3)) for x, y in places), labels, strict=True))
    assert found[1.125, 2.375] == "0.100 m"
    assert found[1.625, 2.125] == "1.600 m"
    assert len(found) == 5
    assert errors == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6])


def test_the_numbers_stand_beside_the_papers(tmp_path: Path) -> None:
    ((text,),) = column(batches_of(recorded(tmp_path / "fig7.rrd"))["/numbers"], "TextDocument:text", static=True)
    assert "| inception-9 | 0.100 | 0.620 | 1.600 | 0.12 to 0.56 |" in text
    assert "| nearest | 0.050 | 0.310 | 0.800 |  |" in text
    assert "twonav reproduce fig7 --seed 3" in text


def test_the_floor_plan_lies_under_the_maps(tmp_path: Path) -> None:
    chunks = batches_of(recorded(tmp_path / "fig7.rrd"))["/errors/map/floor"]
    (buffer,) = column(chunks, "SegmentationImage:buffer", static=True)
    assert np.array(buffer[0]).reshape(MAP_FRAME.shape).sum(axis=1).tolist() == [80, *[0] * 59]


def test_inspect_knows_the_recording(tmp_path: Path) -> None:
    summary = summarize(recorded(tmp_path / "fig7.rrd"))
    assert (summary.command, summary.stage, summary.scene, summary.seed) == ("reproduce", "fig7", "apartment", 3)
    assert summary.whole
    assert APPLICATION_ID == "twonav_cnn_errors"


def test_a_level_is_an_equal_factor_and_says_its_error() -> None:
    errors_m = np.geomspace(0.01, 1.0, LEVELS)
    assert error_levels(errors_m[None], 0.01, 1.0)[0].tolist() == list(range(1, LEVELS + 1))
    classes = level_classes(0.01, 1.0)
    assert [number for number, _, _ in classes] == list(range(LEVELS + 1))
    assert classes[0][1:] == ("no cell", (0, 0, 0, 0))
    assert (classes[1][1], classes[LEVELS][1]) == ("about 0.01 m", "about 1 m")
    assert classes[1][2] == (68, 1, 84, 255)


def test_a_recording_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match=r"must end in \.rrd"):
        recorded(tmp_path / "fig7.png")
