"""A made-up run of the mapper is recorded and read back value by value."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mapped_run import (
    BEAMS,
    ERROR_M,
    PARTICLES,
    best_pose,
    clock_of,
    drawing,
    keyframe,
    mapped_run,
    odometry,
    started,
)
from recorded_rows import batches_of, column, record

from twonav_cli.events import Event, KeyframeMapped, MapDrawn, Note
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.recording.mapping_columns import weight_colours
from twonav_cli.recording.mapping_figures import figures_of, moved_most, spread
from twonav_cli.recording.mapping_picture import FREE_GREY, OCCUPIED_GREY, UNKNOWN_GREY, holds, without_border
from twonav_cli.recording.mapping_rows import KEYFRAMES_PER_SHIPMENT
from twonav_cli.recording.reader import summarize
from twonav_cli.recording.recorder import Recorder


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


@pytest.fixture(scope="module")
def mapped(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """Return what was recorded of a run with a truth."""
    path = record(tmp_path_factory.mktemp("mapped") / "run.rrd", "map", mapped_run(25, truth=True))
    return batches_of(path)


def said(path: Path, sent: list[Event]) -> dict[str, str]:
    """Return the lines of the log and their levels."""
    chunks = batches_of(record(path, "map", [started(), *sent])).get("/log", [])
    texts, levels = (np.ravel(column(chunks, f"TextLog:{name}")) for name in ("text", "level"))
    return dict(zip(texts.tolist(), levels.tolist(), strict=True))


def moved(event: KeyframeMapped, pose: Pose) -> KeyframeMapped:
    return replace(event, pose=pose)


# Where everything is


@pytest.mark.parametrize(("entity", "expected"), [("best", best_pose), ("odometry", odometry)])
def test_a_keyframe_has_its_pose_in_metres_with_y_up(mapped: dict[str, list[Any]], entity: str, expected: Any) -> None:
    chunks = mapped[f"/mapping/map/{entity}"]
    assert column(chunks, "keyframe") == list(range(1, 26))
    origins = np.array(column(chunks, "Arrows2D:origins"))[:, 0]
    assert np.allclose(origins, [expected(number)[:2] for number in range(1, 26)], atol=1e-5)
    (flip,) = column(mapped["/mapping/map"], "Transform3D:scale", static=True)
    assert flip == [[1.0, -1.0, 1.0]]


def test_every_moving_row_is_on_both_timelines_and_no_other(mapped: dict[str, list[Any]]) -> None:
    for entity, chunks in mapped.items():
        for chunk in chunks:
            if not chunk.is_static and not entity.startswith("/__properties"):
                assert set(chunk.timeline_names) == {"keyframe", "time"}, entity


def test_the_time_is_that_since_the_first_scan(mapped: dict[str, list[Any]]) -> None:
    times = column(mapped["/mapping/map/best"], "time")
    assert [time.total_seconds() for time in times[:3]] == [0.0, 2.0, 4.0]


def test_the_scan_lies_where_the_best_particle_believes(mapped: dict[str, list[Any]]) -> None:
    scans = column(mapped["/mapping/map/scan"], "Points2D:positions")
    assert [len(scan) for scan in scans] == [BEAMS] * 25
    assert np.allclose(scans[4], keyframe(5).hits, atol=1e-5)


def test_the_heaviest_particle_is_the_brightest(mapped: dict[str, list[Any]]) -> None:
    chunks = mapped["/mapping/map/particles"]
    colours = column(chunks, "Arrows2D:colors")[0]
    assert len(colours) == PARTICLES
    assert np.argmax(colours) == 2
    assert colours[0] == colours[3] == weight_colours(np.array([1.0, 6.0]))[0]
    assert np.allclose(np.array(column(chunks, "Arrows2D:origins")[2])[:, 1], [0.25, 0.26, 0.27, 0.28], atol=1e-6)


def test_the_truth_has_its_place_and_the_error_reaches_from_there_to_the_belief(mapped: dict[str, list[Any]]) -> None:
    strips = np.array(column(mapped["/mapping/map/error"], "LineStrips2D:strips"))[:, 0]
    assert np.allclose(strips[7], [(3.5, 0.25 - ERROR_M), (3.5, 0.25)], atol=1e-5)
    assert np.allclose(np.ravel(column(mapped["/curves/error_m"], "Scalars:scalars")), ERROR_M)


def test_without_a_truth_there_is_no_row_of_it(tmp_path: Path) -> None:
    found = batches_of(record(tmp_path / "run.rrd", "map", mapped_run(3)))
    for entity in ("/curves/error_m", "/mapping/map/error", "/mapping/map/truth"):
        assert all(chunk.is_static for chunk in found[entity])


# The map


def picture(chunks: list[Any], index: int) -> np.ndarray:
    blob = column(chunks, "EncodedImage:blob")[index][0]
    decoded = cv2.imdecode(np.frombuffer(np.array(blob, dtype=np.uint8).tobytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    return np.asarray(decoded)


def canvases_of(found: dict[str, list[Any]], keyframe: int) -> list[tuple[float, GridFrame, np.ndarray]]:
    """Return the pictures that are drawn at a keyframe, in that order, and where they lie."""
    drawn = []
    for entity, chunks in found.items():
        if entity.startswith("/mapping/map/picture/"):
            so_far = [number for number in column(chunks, "keyframe") if number <= keyframe]
            if so_far:
                pixels = picture(chunks, len(so_far) - 1)
                ((x_m, top_m, _),) = column(chunks, "Transform3D:translation", static=True)[0]
                ((width_m, height_m, _),) = column(chunks, "Transform3D:scale", static=True)[0]
                ((order,),) = column(chunks, "EncodedImage:draw_order", static=True)
                assert width_m == pytest.approx(-height_m)
                frame = GridFrame(x_m, top_m + height_m * len(pixels), width_m, *pixels.shape)
                drawn.append((order, frame, pixels))
    return sorted(drawn, key=lambda canvas: canvas[0])


@pytest.mark.parametrize("number", [1, 5, 11, 21, 25])
def test_the_growing_map_is_on_top_and_its_pixels_lie_where_they_are(mapped: dict[str, list[Any]], number: int) -> None:
    _, frame, pixels = canvases_of(mapped, number)[-1]
    drawn = drawing((number - 1) // 10 * 10 + 1)
    greys = {0: OCCUPIED_GREY, 205: UNKNOWN_GREY, 254: FREE_GREY}
    for row in range(0, drawn.frame.rows, 3):
        for col in range(0, drawn.frame.cols, 7):
            x_m, y_m = drawn.frame.centre_of(Cell(row, col))
            assert pixels[frame.cell_at(x_m, y_m)] == greys[drawn.pixels[row, col]]
    assert np.count_nonzero(pixels != UNKNOWN_GREY) == np.count_nonzero(drawn.pixels != 205)


def test_every_canvas_covers_the_one_before_it(tmp_path: Path) -> None:
    left = replace(drawing(11), frame=GridFrame(-30.0, -1.0, 0.1, 40, 75))
    path = record(tmp_path / "run.rrd", "map", [started(), keyframe(1), drawing(1), left, drawing(21)])
    frames = [frame for _, frame, _ in canvases_of(batches_of(path), 30)]
    assert len(frames) == 3
    assert all(holds(outer, inner) for inner, outer in pairwise(frames))


def test_the_pictures_of_one_canvas_are_of_one_size(mapped: dict[str, list[Any]]) -> None:
    """The viewer takes them for a film, which cannot change its size."""
    canvases = [chunks for entity, chunks in mapped.items() if entity.startswith("/mapping/map/picture/")]
    assert len(canvases) > 1
    for chunks in canvases:
        images = [c for c in chunks if "EncodedImage:blob" in c.to_record_batch().schema.names]
        assert len({picture(images, i).shape for i in range(len(column(images, "EncodedImage:blob")))}) == 1


def test_the_view_is_of_what_is_known() -> None:
    pixels = np.full((10, 20), 205, dtype=np.uint8)
    assert without_border(GridFrame(-1.0, -2.0, 0.5, 10, 20), pixels)[0] == GridFrame(-1.0, -2.0, 0.5, 10, 20)
    pixels[2, 3] = pixels[6, 4] = 0
    frame, part = without_border(GridFrame(-1.0, -2.0, 0.5, 10, 20), pixels)
    assert frame == GridFrame(0.5, -0.5, 0.5, 5, 2)
    assert part.tolist() == pixels[2:7, 3:5].tolist()


def test_free_occupied_and_unknown_are_told_apart() -> None:
    assert len({OCCUPIED_GREY, UNKNOWN_GREY, FREE_GREY}) == 3


def test_the_way_is_drawn_whole_with_the_map_and_goes_on_from_there(mapped: dict[str, list[Any]]) -> None:
    whole = column(mapped["/mapping/map/best/way"], "LineStrips2D:strips")
    assert [len(strips[0]) for strips in whole] == [1, 11, 21]
    latest = column(mapped["/mapping/map/best/latest"], "LineStrips2D:strips")
    assert np.allclose(latest[12][0], [best_pose(number)[:2] for number in (11, 12, 13)], atol=1e-5)
    assert len(latest[11][0]) == 2


def test_in_a_long_run_pictures_become_rarer_but_the_last_one_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("twonav_cli.recording.mapping_rows.FIRST_DRAWINGS", 2)
    monkeypatch.setattr("twonav_cli.recording.mapping_rows.GROWTH", 2.0)
    monkeypatch.setattr("twonav_cli.recording.mapping_rows.MAX_WAY", 5)
    path = record(tmp_path / "run.rrd", "map", mapped_run(95))
    ways = batches_of(path)["/mapping/map/best/way"]
    assert column(ways, "keyframe") == [1, 11, 31, 71, 91]
    strips = [strips[0] for strips in column(ways, "LineStrips2D:strips")]
    assert [len(strip) for strip in strips] == [1, 5, 5, 5, 5]
    assert np.allclose([strip[-1] for strip in strips[1:]], [best_pose(n)[:2] for n in (11, 31, 71, 91)])
    summary = summarize(path).mapping
    assert summary is not None
    assert summary.cols == drawing(91).frame.cols


def test_the_layout_is_written_again_only_when_the_map_has_outgrown_it(tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    def layouts(name: str, drawings: list[MapDrawn]) -> int:
        path = record(tmp_path / name, "map", [started(), keyframe(1), *drawings])
        return len(RrdReader(str(path)).blueprints())

    same = [replace(drawing(1), clock=clock_of(number)) for number in range(1, 9)]
    grown = [drawing(number) for number in (1, 11, 21, 31)]
    assert layouts("same.rrd", same) == 2, "at the first drawing and at the end"
    assert layouts("grown.rrd", grown) == 5


# What went wrong


def test_a_run_without_trouble_says_only_how_it_ended(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    assert said(path, mapped_run(12)[1:]) == {"run ended: mapped": "INFO"}
    assert all(chunk.is_static for chunk in batches_of(path)["/mapping/map/trouble"])


@pytest.mark.parametrize(("unmatched", "level"), [(1, "WARN"), (PARTICLES, "ERROR")])
def test_scan_matching_that_failed_is_said_and_marked_on_the_map(tmp_path: Path, unmatched: int, level: str) -> None:
    path = tmp_path / "run.rrd"
    lines = said(path, [keyframe(1), keyframe(2, unmatched=unmatched), keyframe(3)])
    assert lines == {f"scan matching failed for {unmatched} of 4 particles: they keep odometry": level}
    found = batches_of(path)
    assert np.allclose(column(found["/mapping/map/trouble"], "Points2D:positions"), [[best_pose(2)[:2]]])
    assert column(found["/mapping/map/trouble/latest"], "Points2D:labels") == [["2: no match"]]
    assert np.ravel(column(found["/filter/unmatched"], "Scalars:scalars")).tolist() == [0, unmatched, 0]


def test_troubles_accumulate_and_only_the_latest_have_names(tmp_path: Path) -> None:
    path = record(tmp_path / "run.rrd", "map", [started(), *(keyframe(n, unmatched=1) for n in range(1, 8))])
    found = batches_of(path)
    assert [len(points) for points in column(found["/mapping/map/trouble"], "Points2D:positions")] == [*range(1, 8)]
    labels = column(found["/mapping/map/trouble/latest"], "Points2D:labels")[-1]
    assert labels == [f"{n}: no match" for n in (4, 5, 6, 7)]


@pytest.mark.parametrize(
    ("pose", "said_so"),
    [
        (Pose(0.5, 0.25 + 0.7, 0.0), "the pose jumped 0.69 m, 0 deg"),
        (Pose(0.5, 0.25, 0.6), "the pose jumped 0.02 m, 34 deg"),
    ],
)
def test_a_jump_away_from_odometry_is_said(tmp_path: Path, pose: Pose, said_so: str) -> None:
    # Odometry drifts 2 cm to the left, so that 0.7 m to the left are 0.68 m away from its guess.
    pose = pose._replace(y_m=pose.y_m + 0.01 * (pose.theta_rad == 0.0))
    lines = said(tmp_path / "run.rrd", [keyframe(1), moved(keyframe(2), pose)])
    assert [line for line in lines if line.startswith(said_so)]
    assert set(lines.values()) == {"WARN"}


@pytest.mark.parametrize(
    ("pose", "said_so"),
    [
        (Pose(0.5, 0.25 + 0.4, 0.0), "odometry's guess was corrected by 0.38 m, 0 deg"),
        (Pose(0.5, 0.25, 0.3), "odometry's guess was corrected by 0.02 m, 17 deg"),
    ],
)
def test_a_large_correction_is_said_but_is_no_trouble(tmp_path: Path, pose: Pose, said_so: str) -> None:
    assert said(tmp_path / "run.rrd", [keyframe(1), moved(keyframe(2), pose)]) == {said_so: "INFO"}
    assert all(chunk.is_static for chunk in batches_of(tmp_path / "run.rrd")["/mapping/map/trouble"])


def test_drawing_particles_again_is_a_diamond_and_a_warning_only_when_few_were_left(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    collapsed = replace(keyframe(3, resampled=True), effective=0.3)
    lines = said(path, [keyframe(1), keyframe(2, resampled=True), collapsed])
    assert lines["particles drawn again: 2.4 of 4 were effective"] == "DEBUG"
    assert lines["particles drawn again: 0.3 of 4 were effective"] == "WARN"
    chunks = batches_of(path)["/filter/resampled"]
    assert column(chunks, "keyframe") == [2, 3]
    assert np.ravel(column(chunks, "Scalars:scalars")) == pytest.approx([keyframe(1).effective, 0.3])


def test_being_lost_is_said_once_and_so_is_being_found_again(tmp_path: Path) -> None:
    far = [replace(keyframe(n, truth=True), pose_true=Pose(9.0, 9.0, 0.0)) for n in (2, 3)]
    lines = said(tmp_path / "run.rrd", [keyframe(1, truth=True), *far, keyframe(4, truth=True)])
    assert [level for line, level in lines.items() if line.startswith("lost: believes to be")] == ["ERROR"]
    assert lines[f"found again: {ERROR_M:.2f} m from where it is"] == "INFO"


def test_another_way_than_before_is_said(tmp_path: Path) -> None:
    other = drawing(11)
    other.path[4, 1] += 0.8
    lines = said(tmp_path / "run.rrd", [keyframe(1), drawing(6), other])
    assert lines == {"the way was redrawn: keyframe 5 moved by 0.80 m (another particle is the best)": "INFO"}


def test_notes_are_in_the_log(tmp_path: Path) -> None:
    assert said(tmp_path / "run.rrd", [Note(clock_of(0), "WARN", "the log is cut off")])["the log is cut off"] == "WARN"


def test_what_the_run_warned_of_is_read_back(tmp_path: Path) -> None:
    notes = [Note(clock_of(0), "WARN", "odometry jumps"), Note(clock_of(0), "INFO", "all is well")]
    sent = [started(), *notes, keyframe(1), keyframe(2, unmatched=1), Note(clock_of(2), "WARN", "it is cut off")]
    assert summarize(record(tmp_path / "run.rrd", "map", sent)).warnings == ("odometry jumps", "it is cut off")
    assert summarize(record(tmp_path / "calm.rrd", "map", mapped_run(2))).warnings == ()


# The numbers


def test_the_numbers_of_a_keyframe_are_what_they_say() -> None:
    before = replace(keyframe(1), pose=Pose(1.0, 1.0, math.pi / 2), pose_odom=Pose(0.0, 0.0, 0.0))
    after = replace(keyframe(2), pose=Pose(1.0, 2.3, math.pi), pose_odom=Pose(1.0, 0.0, 0.0))
    figures = figures_of(after, before)
    assert figures.correction_m == pytest.approx(0.3)  # odometry: one metre ahead, which is up
    assert figures.correction_deg == pytest.approx(90.0)
    assert figures.from_odometry_m == pytest.approx(2.3)
    assert math.isnan(figures.error_m)
    assert figures_of(before, None).correction_m == 0.0


def test_the_spread_is_the_weighted_deviation_also_across_the_back() -> None:
    poses = np.array([(0.0, 0.0, math.pi - 0.1), (2.0, 0.0, 0.1 - math.pi), (99.0, 99.0, 0.0)])
    spread_m, spread_rad = spread(poses, np.array([0.5, 0.5, 0.0]))
    assert (spread_m, spread_rad) == (pytest.approx(1.0), pytest.approx(0.1))


def test_the_keyframe_that_moved_most_is_looked_for_where_both_ways_are() -> None:
    before = np.zeros((3, 3))
    now = np.array([(0.0, 0.1, 0.0), (0.3, 0.4, 0.0), (0.0, 0.2, 0.0), (9.0, 9.0, 0.0)])
    assert moved_most(before, now) == (1, pytest.approx(0.5))
    assert moved_most(np.empty((0, 3)), now) == (0, 0.0)


# The file


def test_a_summary_tells_how_the_mapping_went(tmp_path: Path) -> None:
    sent = mapped_run(25, truth=True)
    at = [index for index, event in enumerate(sent) if isinstance(event, KeyframeMapped)]
    sent[at[6]] = keyframe(7, truth=True, unmatched=2)
    sent[at[8]] = keyframe(9, truth=True, unmatched=PARTICLES, resampled=True)
    sent[at[19]] = moved(keyframe(20, truth=True), Pose(9.5, 1.25, 0.0))
    summary = summarize(record(tmp_path / "run.rrd", "map", sent))
    assert (summary.kind, summary.scene, summary.seed, summary.ending) == ("map", "corridor", 3, "mapped")
    mapping = summary.mapping
    assert mapping is not None
    assert (mapping.keyframes, mapping.particles, mapping.duration_s) == (25, PARTICLES, 48.0)
    assert (mapping.unmatched, mapping.lost, mapping.resampled) == ((7, 9), (9,), 1)
    assert (mapping.rows, mapping.cols, mapping.resolution_m) == (40, 125, 0.1)
    assert (mapping.jump_m.keyframe, mapping.jump_m.value) == (21, pytest.approx(1.02))
    assert mapping.error_m is not None
    assert (mapping.error_m.keyframe, mapping.error_m.value) == (20, pytest.approx(1.1))
    assert mapping.last_error_m == pytest.approx(ERROR_M)


def test_a_run_without_a_keyframe_has_no_summary_of_the_mapping(tmp_path: Path) -> None:
    assert summarize(record(tmp_path / "run.rrd", "map", [started()])).mapping is None


KILLED = """
import os, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from mapped_run import mapped_run
from twonav_cli.recording.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), "map")
for event in mapped_run(50):
    recorder(event)
os.kill(os.getpid(), 9)
"""


def test_a_killed_run_keeps_all_but_the_latest_keyframes(tmp_path: Path) -> None:
    path, here = tmp_path / "run.rrd", Path(__file__).parent
    code = subprocess.run([sys.executable, "-c", KILLED, str(path), str(here)], cwd=here.parents[1]).returncode
    assert code == -9
    summary = summarize(path)
    assert not summary.whole
    assert summary.mapping is not None
    assert summary.mapping.keyframes == 50 // KEYFRAMES_PER_SHIPMENT * KEYFRAMES_PER_SHIPMENT
    assert summary.mapping.rows == 40


def test_beyond_the_budget_only_the_numbers_are_written(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    with Recorder(path, "map", budget_mb=0.0) as recorder:
        for event in mapped_run(25):
            recorder(event)
    found = batches_of(path)
    assert all(chunk.is_static for chunk in found.get("/mapping/map/scan", []))
    assert [frame for _, frame, _ in canvases_of(found, 20)] == []
    assert len(canvases_of(found, 21)) == 1, "the last picture is written all the same"
    summary = summarize(path)
    assert summary.mapping is not None
    assert summary.mapping.keyframes == 25


def test_a_keyframe_of_a_large_map_takes_a_few_kilobytes(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frame = GridFrame(-30.0, -20.0, 0.05, 800, 1200)
    pixels = np.full(frame.shape, 205, dtype=np.uint8)
    pixels[200:600, 200:900] = 254
    pixels[200:600:50, 200:900] = 0

    def grown(number: int) -> KeyframeMapped:
        noise = rng.normal(0.0, 0.02, (30, 3))
        return replace(
            keyframe(number), poses=np.array(best_pose(number)) + noise, weights=np.full(30, 1 / 30),
            hits=rng.uniform(-20.0, 20.0, (361, 2)),
        )  # fmt: skip

    sent: list[Event] = [started()]
    for number in range(1, 201):
        sent.append(grown(number))
        if number % 10 == 1:
            path = np.array([best_pose(n) for n in range(1, number + 1)])
            sent.append(MapDrawn(clock_of(number), pixels, frame, path))
    size = record(tmp_path / "run.rrd", "map", sent).stat().st_size
    assert size / 200 < 8_000
