"""The local cost map: what stands around the robot, as the map and the range finder say (§3.1.3).

A window of h x w cells around one action, half a map pixel each, on the map's pixel grid. Map pixels mark it; a beam
clears the cells it passes and marks the one it ends in. The window stays where it is during an action, in which the
believed pose moves by odometry only, so what was seen a moment ago stays right.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import ROBOT_FOOTPRINT_M
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.distance import fill_distances
from twonav_cli.navigation.footprint import FloatArray, WindowGrid, grown_outline

SUBDIVISION = 2
"""Cells of the window per map pixel and axis: at 5 cm one beam's end would cost half a doorway's play (ours)."""

WINDOW_M = 1.6
"""Edge of the window: an action, the footprint at both ends and the cut range (ours)."""

LASER_X_M = 0.02
"""The range finder stands this far in front of the axle."""

BEAM_DEPTH_M = 0.01
"""A beam's end is moved this far on before it marks: a surface on a cell's border marks the cell behind it (ours)."""

STANDING_INSET_M = 0.01
"""Marks this deep inside the robot's own outline cannot be true: it stands there (ours)."""

SAME_THING_M = 0.2
"""A map pixel that a beam passes is cleared only when something was hit this near: then it is that thing, believed to
stand a little elsewhere. What no beam hits at all may be lower or higher than the laser's plane and stays (ours)."""

FROM_MAP = 1
FROM_BEAM = 2


ByteArray = NDArray[np.uint8]


class Window(NamedTuple):
    """The arrays [h, w] of a window, written in place."""

    marks: ByteArray
    """0 free, FROM_MAP or FROM_BEAM."""
    distance_m: FloatArray
    """From each cell's centre to the nearest marked cell's centre."""
    before: ByteArray
    """The marks before the last scan."""
    hits: ByteArray
    to_hit_m: FloatArray
    """From each cell's centre to the nearest end of a beam of the last scan; only where it was needed."""
    nowhere_m: FloatArray
    """Infinite everywhere: nothing was hit."""


def new_window(side: int) -> Window:
    """Return a window of [side, side] cells."""
    bytes_, floats = (np.zeros((3, side, side), dtype=np.uint8), np.zeros((2, side, side), dtype=np.float64))
    nowhere_m = np.full((side, side), np.inf)
    return Window(bytes_[0], floats[0], bytes_[1], bytes_[2], floats[1], nowhere_m)


@compiled
def _copy_map(occupied: NDArray[np.bool_], row0: int, col0: int, marks: NDArray[np.uint8]) -> None:
    """Write the occupied pixels [rows, cols] that lie under the window [h, w], each as a square of cells."""
    rows, cols = occupied.shape
    for row in range(marks.shape[0]):
        map_row = row0 + row // SUBDIVISION
        for col in range(marks.shape[1]):
            map_col = col0 + col // SUBDIVISION
            inside = 0 <= map_row < rows and 0 <= map_col < cols
            marks[row, col] = FROM_MAP if inside and occupied[map_row, map_col] else 0


@compiled
def _clear_outline(marks: NDArray[np.uint8], grid: WindowGrid, outline: FloatArray) -> None:
    """Clear the cells whose centres lie inside a convex counter-clockwise polygon [N, 2] of the map frame."""
    rows = marks.shape[0]
    for row in range(rows):
        y = grid.y_min_m + (rows - row - 0.5) * grid.resolution_m
        for col in range(marks.shape[1]):
            if marks[row, col] == 0:
                continue
            x = grid.x_min_m + (col + 0.5) * grid.resolution_m
            inside = True
            for i in range(outline.shape[0]):
                ax, ay = outline[i - 1, 0], outline[i - 1, 1]
                bx, by = outline[i, 0], outline[i, 1]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0.0:
                    inside = False
                    break
            if inside:
                marks[row, col] = 0


@compiled
def _mark_ends(
    marks: NDArray[np.uint8], grid: WindowGrid, laser: tuple[float, float, float], scan_m: FloatArray, cut_m: float
) -> None:
    """Mark the cells [h, w] that beams [180] end in, nearer than the cut; laser is (x_m, y_m, theta_rad)."""
    rows, cols = marks.shape
    for beam in range(scan_m.shape[0]):
        if scan_m[beam] >= cut_m:
            continue
        angle = laser[2] - 0.5 * np.pi + np.pi * beam / (scan_m.shape[0] - 1)
        range_m = scan_m[beam] + BEAM_DEPTH_M
        u = (laser[0] + range_m * math.cos(angle) - grid.x_min_m) / grid.resolution_m
        v = (laser[1] + range_m * math.sin(angle) - grid.y_min_m) / grid.resolution_m
        if u >= 0.0 and v >= 0.0 and u < cols and v < rows:
            marks[rows - 1 - int(v), int(u)] = FROM_BEAM


@compiled
def _clear_passed(
    window: Window,
    to_hit_m: FloatArray,
    grid: WindowGrid,
    laser: tuple[float, float, float],
    scan_m: FloatArray,
    cut_m: float,
) -> int:
    """Clear the cells [h, w] that beams [180] pass up to the cut; a map pixel only near something that was hit.

    Returns how many passes left a map pixel standing. The distances tell how far a beam is from everything that was
    marked before: so much of it is skipped.
    """
    marks, distance_m = window.marks, window.distance_m
    rows, cols = marks.shape
    kept = 0
    step_m = 0.5 * grid.resolution_m
    # Point and mark may lie half a diagonal from their cells' centres.
    slack_m = 1.4143 * grid.resolution_m
    u = (laser[0] - grid.x_min_m) / grid.resolution_m
    v = (laser[1] - grid.y_min_m) / grid.resolution_m
    for beam in range(scan_m.shape[0]):
        angle = laser[2] - 0.5 * np.pi + np.pi * beam / (scan_m.shape[0] - 1)
        du, dv = 0.5 * math.cos(angle), 0.5 * math.sin(angle)
        k, steps = 0, int(min(scan_m[beam] - step_m, cut_m) / step_m) + 1
        while k < steps:
            cu, cv = u + k * du, v + k * dv
            if cu < 0.0 or cv < 0.0 or cu >= cols or cv >= rows:
                break
            row, col = rows - 1 - int(cv), int(cu)
            if marks[row, col] == FROM_BEAM or (marks[row, col] == FROM_MAP and to_hit_m[row, col] <= SAME_THING_M):
                marks[row, col] = 0
            elif marks[row, col] == FROM_MAP:
                kept += 1
            k += max(1, int((distance_m[row, col] - slack_m) / step_m))
    return kept


@compiled
def _same_places(a: ByteArray, b: ByteArray) -> bool:
    """Whether the same cells [h, w] are marked, by map or beam."""
    x, y, i = a.reshape(-1), b.reshape(-1), 0
    while i < x.shape[0] and (x[i] == 0) == (y[i] == 0):
        i += 1
    return i == x.shape[0]


@compiled
def lay_window(
    window: Window,
    occupied: NDArray[np.bool_],
    frame: WindowGrid,
    body: FloatArray,
    pose: Pose,
    target_x_m: float,
    target_y_m: float,
) -> WindowGrid:
    """Lay a window around an action and copy the map into it; return where it lies.

    Args:
        window: Written.
        occupied: [rows, cols] the map's pixels.
        frame: Where the map lies.
        body: Corners [N, 2] of the robot in its own frame, within which nothing can be.
        pose: Where the robot believes to be.
        target_x_m, target_y_m: Where it is to go.
    """
    pixel, half = frame.resolution_m, window.marks.shape[0] // (2 * SUBDIVISION)
    pixels = window.marks.shape[0] // SUBDIVISION
    col0 = round((0.5 * (pose[0] + target_x_m) - frame.x_min_m) / pixel) - half
    up0 = round((0.5 * (pose[1] + target_y_m) - frame.y_min_m) / pixel) - half
    grid = WindowGrid(frame.x_min_m + col0 * pixel, frame.y_min_m + up0 * pixel, pixel / SUBDIVISION)
    _copy_map(occupied, occupied.shape[0] - up0 - pixels, col0, window.marks)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    outline = np.empty_like(body)
    for i in range(body.shape[0]):
        outline[i, 0] = pose[0] + cos * body[i, 0] - sin * body[i, 1]
        outline[i, 1] = pose[1] + sin * body[i, 0] + cos * body[i, 1]
    _clear_outline(window.marks, grid, outline)
    fill_distances(window.marks, grid.resolution_m, window.distance_m)
    return grid


@compiled
def see_scan(window: Window, grid: WindowGrid, pose: Pose, scan_m: FloatArray, cut_m: float) -> None:
    """Clear and mark by a scan [180] taken at the believed pose, cut at a range, and update the distances."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    laser = (pose[0] + LASER_X_M * cos, pose[1] + LASER_X_M * sin, pose[2])
    window.before[:] = window.marks
    if _clear_passed(window, window.nowhere_m, grid, laser, scan_m, cut_m) > 0:
        window.hits[:] = 0
        _mark_ends(window.hits, grid, laser, scan_m, cut_m + SAME_THING_M)
        fill_distances(window.hits, grid.resolution_m, window.to_hit_m)
        _clear_passed(window, window.to_hit_m, grid, laser, scan_m, cut_m)
    _mark_ends(window.marks, grid, laser, scan_m, cut_m)
    # What a beam passes and another hits is cleared and marked again in every scan.
    if not _same_places(window.marks, window.before):
        fill_distances(window.marks, grid.resolution_m, window.distance_m)


class CostMap:
    """The window around one action.

    Attributes:
        window: Marks and distances [h, w].
        grid: Where the window lies.
    """

    def __init__(self, occupied: NDArray[np.bool_], map_frame: GridFrame) -> None:
        self.occupied = np.ascontiguousarray(occupied, dtype=np.bool_)
        self.map_grid = WindowGrid(map_frame.x_min_m, map_frame.y_min_m, map_frame.resolution_m)
        self.window = new_window(window_pixels(map_frame.resolution_m) * SUBDIVISION)
        self.grid = WindowGrid(map_frame.x_min_m, map_frame.y_min_m, map_frame.resolution_m / SUBDIVISION)
        self.body = standing_outline()

    @property
    def marks(self) -> ByteArray:
        """[h, w] 0 free, FROM_MAP or FROM_BEAM."""
        return self.window.marks

    @property
    def distance_m(self) -> FloatArray:
        """[h, w] from each cell's centre to the nearest marked cell's centre."""
        return self.window.distance_m

    @property
    def frame(self) -> GridFrame:
        """Where the window lies, in map pixels."""
        pixels = self.marks.shape[0] // SUBDIVISION
        return GridFrame(self.grid.x_min_m, self.grid.y_min_m, self.map_grid.resolution_m, pixels, pixels)

    def begin(self, pose: Pose, target_xy: tuple[float, float]) -> None:
        """Lay the window around an action from a believed pose to a target and copy the map into it."""
        self.grid = WindowGrid(
            *lay_window(self.window, self.occupied, self.map_grid, self.body, pose, *(float(v) for v in target_xy))
        )

    def add_scan(self, pose: Pose, scan_m: FloatArray, cut_m: float) -> None:
        """Clear and mark by a scan [180] taken at the believed pose, cut at a range, and update the distances."""
        see_scan(self.window, self.grid, pose, scan_m, cut_m)

    def inflated(self, inscribed_m: float, inflation_m: float) -> NDArray[np.float32]:
        """Return the cost [h / 2, w / 2] of each map pixel: 1 where the robot's circle touches, 0 when far."""
        return inflated(self.distance_m, inscribed_m, inflation_m)


def inflated(distance_m: FloatArray, inscribed_m: float, inflation_m: float) -> NDArray[np.float32]:
    """Return the cost [h / 2, w / 2] of each map pixel: 1 where the robot's circle touches, 0 when far."""
    side = distance_m.shape[0] // SUBDIVISION
    near = distance_m.reshape(side, SUBDIVISION, side, SUBDIVISION).min(axis=(1, 3))
    cost = np.clip((inflation_m - near) / (inflation_m - inscribed_m), 0.0, 1.0)
    return np.asarray(cost, dtype=np.float32)


def window_pixels(resolution_m: float) -> int:
    """Return how many map pixels a window is wide."""
    return max(2, round(WINDOW_M / resolution_m))


def standing_outline() -> FloatArray:
    """Return the corners [N, 2] of the robot within which nothing can be, because it stands there."""
    return grown_outline(np.array(ROBOT_FOOTPRINT_M), -STANDING_INSET_M)
