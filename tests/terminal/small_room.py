"""A scene of one room for tests of the command line: a plugin with its fixture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from room_texts import ROOM


@pytest.fixture
def room(tmp_path: Path) -> Callable[[str], Path]:
    """Return a function that writes a scene of one room with the given sites."""

    def write(sites: str) -> Path:
        path = tmp_path / "room.xml"
        path.write_text(ROOM.format(sites=sites))
        return path

    return write
