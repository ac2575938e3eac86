"""Maps that are kept: the one the robot made in a survey, and the one that the scene's geometry gives.

A folder holds `map.pgm`, `map.yaml` and `card.json`; the card's "source" says which of the two it is. A card without
one is of the geometry. Beside a survey's map lie the points on its walls, `walls.npy`, float32 [K, 2], map frame,
metres: they are finer than its pixels. `track.txt` is the way of the survey, `timestamp x y theta` a line.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from twonav_cli.checkpoint import FORMAT, signed, versions
from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.occupancy import OccupancyMap, load_map, save_map
from twonav_cli.mapping.scan import StampedPose
from twonav_cli.mapping.trajectory import write_trajectory
from twonav_cli.paths import checkpoints_dir, runs_dir

if TYPE_CHECKING:
    from twonav_cli.scene.catalog import Scene

SURVEY, GEOMETRY = "survey", "geometry"
SOURCES = (SURVEY, GEOMETRY)
"""Where a map can come from: the robot's own survey, or the simulator's geometry."""

MAP_FILE, IMAGE_FILE = "map.yaml", "map.pgm"
CARD_FILE = "card.json"
WALLS_FILE = "walls.npy"
TRACK_FILE = "track.txt"
FOLDER = "map"
GEOMETRY_FOLDER = "map-geometry"


@dataclass(frozen=True)
class KnownMap:
    """A map that was found.

    Attributes:
        map: On the scene's map frame.
        source: "survey" or "geometry".
        folder: Where it lies.
        walls: [K, 2] points on the walls, metres, where they were kept.
    """

    map: OccupancyMap
    source: str
    folder: Path
    walls: FloatArray | None = None


def find_map(scene: Scene, source: str | None, own_first: bool = False, chosen: Path | None = None) -> KnownMap | None:
    """Return the map of this very scene that is kept; None where there is none.

    Args:
        scene: Name and digest count.
        source: "survey" or "geometry"; None takes a survey's, or whatever is in the chosen folder.
        own_first: Whether a map of the user's own goes before the shipped one (training does, playing does not).
        chosen: A folder of a scene's checkpoints whose map goes before both.
    """
    shipped, own = checkpoints_dir() / scene.name / FOLDER, runs_dir() / scene.name / FOLDER
    folders = [own, shipped] if own_first else [shipped, own]
    if source == GEOMETRY:
        folders.append(runs_dir() / scene.name / GEOMETRY_FOLDER)
    in_chosen = _map_in(chosen / FOLDER, scene, source) if chosen is not None else None
    if in_chosen is not None:
        return in_chosen
    found = (_map_in(folder, scene, source or SURVEY) for folder in folders)
    return next((known for known in found if known is not None), None)


def _map_in(folder: Path, scene: Scene, source: str | None) -> KnownMap | None:
    """Return the map in a folder if it is whole, of this scene and, unless that is None, from this source."""
    try:
        card = card_in(folder)
        its_source = card.get("source", GEOMETRY)
        if card["scene_digest"] != scene.digest or its_source not in SOURCES or source not in (None, its_source):
            return None
        occupancy = load_map(folder / MAP_FILE)
    except (KeyError, TypeError, TwonavError):
        return None  # a map can always be made again
    if occupancy.digest != card.get("map_digest"):
        return None
    return KnownMap(occupancy, its_source, folder, _walls_in(folder) if its_source == SURVEY else None)


def _walls_in(folder: Path) -> FloatArray | None:
    """Return the points on the walls [K, 2]; None where there are none that can be read."""
    try:
        walls = np.load(folder / WALLS_FILE, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    whole = walls.ndim == 2 and walls.shape[1] == 2 and np.issubdtype(walls.dtype, np.floating)
    return walls.astype(np.float64) if whole and len(walls) and np.isfinite(walls).all() else None


def card_in(folder: Path) -> dict[str, Any]:
    """Return the card of a folder as it stands there, empty where there is none that can be read."""
    try:
        card = json.loads((folder / CARD_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return card if isinstance(card, dict) else {}


def holds_another(folder: Path, key: str, named: bool) -> bool:
    """Return whether a folder holds something else than a map of a kind, which must not be written over.

    Args:
        folder: Where a map is to be written.
        key: What the cards of that kind have: "scene", or "log".
        named: Whether the user named the folder; in the usual one a map without a card was left by a kill.
    """
    card = card_in(folder)
    if card:
        return card.get("kind") != "map" or key not in card
    return named and any((folder / name).exists() for name in (MAP_FILE, IMAGE_FILE))


def make_map(scene: Scene, folder: Path) -> OccupancyMap:
    """Make the occupancy map from the scene's geometry and write it as PGM, YAML and a card into `folder`."""
    from twonav_cli.scene.geometry_map import occupied_from_geometry

    occupied = occupied_from_geometry(scene, scene.map_frame)
    occupancy = OccupancyMap.from_occupied(occupied, scene.map_frame)
    save_known_map(scene, occupancy, folder, {"source": GEOMETRY})
    return occupancy


def save_known_map(
    scene: Scene,
    occupancy: OccupancyMap,
    folder: Path,
    card: dict[str, Any],
    walls: FloatArray | None = None,
    track: Iterable[StampedPose] | None = None,
) -> Path:
    """Write a map of a scene with its card, the card last, and return the folder.

    Args:
        scene: What it is a map of.
        occupancy: On the scene's map frame.
        folder: Where to.
        card: At least "source"; of a survey also "command", "seed" and "metrics".
        walls: [K, 2] points on the walls, metres.
        track: The way of the survey.

    Raises:
        TwonavError: The folder cannot be written.
    """
    # Without the old card, what is written next is no map of anything until the new card is there.
    for name in (CARD_FILE, MAP_FILE, WALLS_FILE, TRACK_FILE):
        with contextlib.suppress(OSError):
            (folder / name).unlink()
    if track is not None:
        write_trajectory(folder / TRACK_FILE, track)
    if walls is not None:
        content = BytesIO()
        np.save(content, walls.astype(np.float32), allow_pickle=False)
        write_whole(folder / WALLS_FILE, content.getvalue())
    save_map(occupancy, folder / MAP_FILE)
    full = {
        "kind": "map",
        **card,
        "scene": scene.name,
        "scene_digest": scene.digest,
        "map_digest": occupancy.digest,
        "format": FORMAT,
        "sha256": hashlib.sha256((folder / MAP_FILE).with_suffix(".pgm").read_bytes()).hexdigest(),
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "versions": versions(),
    }
    write_whole(folder / CARD_FILE, json.dumps(signed(full), indent=2) + "\n")
    return folder
