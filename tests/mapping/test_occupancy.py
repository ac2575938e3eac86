from pathlib import Path

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap, load_map, save_map

FRAME = GridFrame(-2.4, -0.1, 0.05, 2, 3)
PIXELS = np.array([[OCCUPIED, UNKNOWN, FREE], [FREE, FREE, OCCUPIED]], dtype=np.uint8)


@pytest.fixture
def yaml_path(tmp_path: Path) -> Path:
    return save_map(OccupancyMap(FRAME, PIXELS), tmp_path / "map.yaml")


def refused(path: Path) -> str:
    with pytest.raises(TwonavError) as caught:
        load_map(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_map_comes_back_as_it_was(yaml_path: Path) -> None:
    again = load_map(yaml_path)
    assert again.frame == FRAME
    assert np.array_equal(again.pixels, PIXELS)
    assert again.digest == OccupancyMap(FRAME, PIXELS).digest


def test_the_files_are_those_of_map_server(yaml_path: Path) -> None:
    assert yaml_path.with_suffix(".pgm").read_bytes() == b"P5\n3 2\n255\n" + bytes([0, 205, 254, 254, 254, 0])
    assert yaml_path.read_text().splitlines() == [
        "image: map.pgm",
        "resolution: 0.05",
        "origin: [-2.4, -0.1, 0.0]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
    ]


def test_unknown_is_neither_free_nor_occupied() -> None:
    map_ = OccupancyMap(FRAME, PIXELS)
    assert map_.free.sum() == 3
    assert map_.occupied.sum() == 2
    assert not map_.free[0, 1]
    assert not map_.occupied[0, 1]


def test_a_known_scene_is_free_or_occupied() -> None:
    occupied = np.array([[True, False, False], [False, True, False]])
    map_ = OccupancyMap.from_occupied(occupied, FRAME)
    assert np.array_equal(map_.occupied, occupied)
    assert np.array_equal(map_.free, ~occupied)


def test_the_digest_knows_pixels_and_place() -> None:
    moved = GridFrame(-2.3, -0.1, 0.05, 2, 3)
    changed = PIXELS.copy()
    changed[0, 0] = FREE
    digests = {OccupancyMap(*pair).digest for pair in ((FRAME, PIXELS), (moved, PIXELS), (FRAME, changed))}
    assert len(digests) == 3


def test_a_map_of_another_program_with_comments_and_white_obstacles_is_read(tmp_path: Path) -> None:
    (tmp_path / "other.pgm").write_bytes(
        b"P5\n# CREATOR: somebody\n3 2\n# again\n255\n" + bytes([255, 60, 0, 0, 0, 255])
    )
    (tmp_path / "map.yaml").write_text(
        '# a map\nimage: "other.pgm"\nresolution: 0.050000 # metres\norigin: [-2.4, -0.1, 0]\nnegate: 1\n'
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    again = load_map(tmp_path / "map.yaml")
    assert again.frame == FRAME
    assert np.array_equal(again.pixels, PIXELS)


def test_a_missing_map_or_picture_is_named(yaml_path: Path) -> None:
    assert "there is no map" in refused(yaml_path.with_name("other.yaml"))
    yaml_path.with_suffix(".pgm").unlink()
    assert "map.pgm is missing" in refused(yaml_path)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"P2\n3 2\n255\n0 0 0 0 0 0", "not a binary PGM"),
        (b"", "not a binary PGM"),
        (b"P5\n3 2\n255\n" + bytes(5), "cut short"),
        (b"P5\n3 2\n65535\n" + bytes(12), "one byte per pixel"),
        (b"P5\n999999 999999\n255\n", "one byte per pixel"),
        (b"P5\n3 2\n255\n" + bytes(6), "no free pixel"),
    ],
)
def test_a_broken_picture_is_refused(yaml_path: Path, content: bytes, expected: str) -> None:
    yaml_path.with_suffix(".pgm").write_bytes(content)
    assert expected in refused(yaml_path)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("resolution: 0.05", "", "`resolution: ...` is missing"),
        ("resolution: 0.05", "resolution: five", "resolution must be a number"),
        ("resolution: 0.05", "resolution: 0", "metres per pixel"),
        ("[-2.4, -0.1, 0.0]", "[-2.4]", "origin must be"),
        ("[-2.4, -0.1, 0.0]", "[nan, 0, 0]", "origin must be"),
        ("[-2.4, -0.1, 0.0]", "[-2.4, -0.1, 0.5]", "turned"),
        ("occupied_thresh: 0.65", "occupied_thresh: 0.1", "occupied_thresh (0.1) is below free_thresh (0.196)"),
    ],
)
def test_a_broken_yaml_file_is_refused(yaml_path: Path, old: str, new: str, expected: str) -> None:
    yaml_path.write_text(yaml_path.read_text().replace(old, new))
    assert expected in refused(yaml_path)
