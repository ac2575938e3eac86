"""Layouts of recordings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
import rerun.blueprint as rrb

from twonav_cli.grid import GridFrame
from twonav_cli.recording.blueprint import drive_blueprint, fitting_blueprint, maze_blueprint
from twonav_cli.recording.mapping_blueprint import mapping_blueprint

FRAME = GridFrame(0.0, 0.0, 0.05, 40, 60)
GOALS = ["kitchen", "sofa"]
LAYOUTS = {
    "drive": drive_blueprint(GOALS, FRAME, None),
    "drive without a camera": drive_blueprint(GOALS, FRAME, None, camera=False),
    "maze": maze_blueprint(GOALS, FRAME, 100.0, learns=True),
    "fitting": fitting_blueprint(["m", "deg"]),
    "mapping": mapping_blueprint(FRAME, truth=True),
}


def views_in(part: Any) -> Iterator[rrb.View]:
    """Go through the views of a layout, each as often as it stands there."""
    if isinstance(part, rrb.View):
        yield part
    else:
        for inner in part.contents:
            yield from views_in(inner)


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_view_stands_in_one_place(name: str) -> None:
    """The viewer leaves a view that stands in two tabs empty in one of them."""
    views = list(views_in(LAYOUTS[name].root_container))
    assert len(views) > 3
    assert [view.name for view in views if Counter(v.id for v in views)[view.id] > 1] == []
