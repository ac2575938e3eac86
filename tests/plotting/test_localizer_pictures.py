"""The pictures of the tables of localizers and of Fig. 7: small PNG files of a page's width, without a display."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from made_up_localizers import COLS, ROWS, made_up_floor, made_up_maps, made_up_report

from twonav_cli.plotting.error_map_plot import draw_error_maps
from twonav_cli.plotting.localizer_table_plot import MARKS, draw_localizer_table
from twonav_cli.plotting.pictures import picture_of, picture_of_maps

PNG = b"\x89PNG\r\n\x1a\n"
BYTES_AT_MOST = 150_000
WIDTH_PX = 882

MAP = made_up_floor("apartment").map


def maps_drawn(**asked: Any) -> Any:
    return draw_error_maps(made_up_maps(**asked), MAP.occupied, MAP.frame)


@pytest.mark.parametrize("table", ["table3", "table4"])
@pytest.mark.parametrize("missing", [(), ("sda-3x4000", "cnn-9")])
def test_a_table_has_a_small_picture_of_a_pages_width(table: str, missing: tuple[str, ...]) -> None:
    png = picture_of(made_up_report(table, missing))
    assert png.startswith(PNG)
    assert len(png) < BYTES_AT_MOST
    assert int.from_bytes(png[16:20], "big") == WIDTH_PX
    assert int.from_bytes(png[20:24], "big") < 850
    assert picture_of(made_up_report(table, missing)) == png


def test_every_network_has_a_row_with_the_papers_mark_and_ours() -> None:
    report = made_up_report("table4", missing=("inception-pool-9",))
    left, right = draw_localizer_table(report).axes
    names = [label.get_text() for label in left.get_yticklabels()]
    assert names[0] == "kitchen, cnn-7"
    assert names[-4] == "apartment, inception-pool-9\n(not trained)"
    assert len(names) == len(report.rows)
    for axes, key in ((left, "pos_mean_m"), (right, "ang_mean_deg")):
        crosses = [float(np.asarray(line.get_xdata())[0]) for line in axes.lines if line.get_marker() == "x"]
        assert crosses == [row.paper[key] for row in report.rows if row.paper is not None]
        for mark in MARKS:
            shown = [line for line in axes.lines if line.get_marker() == mark.style["marker"]]
            values = [float(np.asarray(line.get_xdata())[0]) for line in shown]
            assert values == [row.ours[mark.trial][key] for row in report.rows if row.ours is not None]


def test_no_two_marks_look_alike() -> None:
    styles = [mark.style for mark in MARKS]
    assert len({style["marker"] for style in styles}) == len({style["color"] for style in styles}) == len(MARKS)


def test_fig_7_is_a_small_picture_of_a_pages_width() -> None:
    png = picture_of_maps(made_up_maps(), MAP.occupied, MAP.frame)
    assert png.startswith(PNG)
    assert len(png) < BYTES_AT_MOST
    assert int.from_bytes(png[16:20], "big") == WIDTH_PX
    assert png == picture_of_maps(made_up_maps(), MAP.occupied, MAP.frame)


def test_the_panels_of_fig_7_share_one_scale_from_the_least_to_the_largest_error() -> None:
    report = made_up_maps()
    heats = [axes.images[0] for axes in maps_drawn().axes if axes.images and axes.get_title(loc="left")]
    assert len(heats) == 4
    assert {heat.get_cmap().name for heat in heats} == {"viridis"}
    ends = {(heat.norm.vmin, heat.norm.vmax) for heat in heats}
    least = min(one.summary["min_m"] for one in report.maps)
    largest = max(one.summary["max_m"] for one in report.maps)
    ((low, high),) = ends
    assert math.isclose(low, least, rel_tol=1e-3)
    assert math.isclose(high, largest, rel_tol=1e-3)


def test_a_panel_of_fig_7_shows_its_cells_with_the_worst_on_top_and_names_the_papers_ends() -> None:
    first = maps_drawn().axes[0]
    assert first.get_title(loc="left") == "sda-3x4000: 0.1 to 0.21 m; paper 0.43 to 1.6 m"
    heat = np.asarray(first.images[0].get_array())
    assert heat.shape == (ROWS, COLS)
    assert np.unravel_index(heat.argmax(), heat.shape) == (0, COLS - 1)
    assert first.images[0].get_extent() == pytest.approx((0.5, 1.5, 0.75, 1.5))


def test_one_map_alone_is_drawn_too() -> None:
    titles = [axes.get_title(loc="left") for axes in maps_drawn(missing=("sda-3x4000", "inception-9", "belief")).axes]
    assert [title for title in titles if title] == ["nearest: 0.1 to 0.21 m"]
