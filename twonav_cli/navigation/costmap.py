"""The local cost map: what stands around the robot, as the map and the range finder say (§3.1.3).

A window of h x w cells around one action, half a map pixel each, on the map's pixel grid. Map pixels mark it; a beam
clears the cells it passes and marks the one it ends in. The window stays where it is during an action, in which the
believed pose moves by odometry only, so what was seen a moment ago stays right.
"""

from __future__ import annotations

import math

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
) -> int:
    """Mark the cells [h, w] that beams [180] end in, nearer than the cut; laser is (x_m, y_m, theta_rad).

    Returns how many cells were free before.
    """
    rows, cols = marks.shape
    added = 0
    for beam in range(scan_m.shape[0]):
        if scan_m[beam] >= cut_m:
            continue
        angle = laser[2] - 0.5 * np.pi + np.pi * beam / (scan_m.shape[0] - 1)
        range_m = scan_m[beam] + BEAM_DEPTH_M
        u = (laser[0] + range_m * math.cos(angle) - grid.x_min_m) / grid.resolution_m
        v = (laser[1] + range_m * math.sin(angle) - grid.y_min_m) / grid.resolution_m
        if u >= 0.0 and v >= 0.0 and u < cols and v < rows:
            row, col = rows - 1 - int(v), int(u)
            added += marks[row, col] == 0
            marks[row, col] = FROM_BEAM
    return added


@compiled
def _clear_passed(
    marks: NDArray[np.uint8],
    to_hit_m: FloatArray,
    grid: WindowGrid,
    laser: tuple[float, float, float],
    scan_m: FloatArray,
    cut_m: float,
) -> tuple[int, int]:
    """Clear the cells [h, w] that beams [180] pass up to the cut; a map pixel only near something that was hit.

    Returns how many were cleared, and how many passes left a map pixel standing.
    """
    rows, cols = marks.shape
    cleared = kept = 0
    step_m = 0.5 * grid.resolution_m
    u = (laser[0] - grid.x_min_m) / grid.resolution_m
    v = (laser[1] - grid.y_min_m) / grid.resolution_m
    for beam in range(scan_m.shape[0]):
        angle = laser[2] - 0.5 * np.pi + np.pi * beam / (scan_m.shape[0] - 1)
        du, dv = 0.5 * math.cos(angle), 0.5 * math.sin(angle)
        for k in range(int(min(scan_m[beam] - step_m, cut_m) / step_m) + 1):
            cu, cv = u + k * du, v + k * dv
            if cu < 0.0 or cv < 0.0 or cu >= cols or cv >= rows:
                break
            row, col = rows - 1 - int(cv), int(cu)
            if marks[row, col] == FROM_BEAM or (marks[row, col] == FROM_MAP and to_hit_m[row, col] <= SAME_THING_M):
                marks[row, col] = 0
                cleared += 1
            elif marks[row, col] == FROM_MAP:
                kept += 1
    return cleared, kept


class CostMap:
    """The window around one action.

    Attributes:
        marks: [h, w] 0 free, FROM_MAP or FROM_BEAM.
        distance_m: [h, w] from each cell's centre to the nearest marked cell's centre.
        grid: Where the window lies.
    """

    def __init__(self, occupied: NDArray[np.bool_], map_frame: GridFrame) -> None:
        self._occupied = np.ascontiguousarray(occupied, dtype=np.bool_)
        self._frame = map_frame
        self._pixels = max(2, round(WINDOW_M / map_frame.resolution_m))
        side = self._pixels * SUBDIVISION
        self.marks = np.zeros((side, side), dtype=np.uint8)
        self.distance_m = np.zeros((side, side), dtype=np.float64)
        self._hits = np.zeros((side, side), dtype=np.uint8)
        self._to_hit_m = np.zeros((side, side), dtype=np.float64)
        self._nowhere_m = np.full((side, side), np.inf)
        self._stale = True
        self.grid = WindowGrid(map_frame.x_min_m, map_frame.y_min_m, map_frame.resolution_m / SUBDIVISION)
        self._body = grown_outline(np.array(ROBOT_FOOTPRINT_M), -STANDING_INSET_M)

    @property
    def frame(self) -> GridFrame:
        """Where the window lies, in map pixels."""
        return GridFrame(self.grid.x_min_m, self.grid.y_min_m, self._frame.resolution_m, self._pixels, self._pixels)

    def begin(self, pose: Pose, target_xy: tuple[float, float]) -> None:
        """Lay the window around an action from a believed pose to a target and copy the map into it."""
        pixel = self._frame.resolution_m
        half = self._pixels // 2
        col0 = round((0.5 * (pose.x_m + target_xy[0]) - self._frame.x_min_m) / pixel) - half
        up0 = round((0.5 * (pose.y_m + target_xy[1]) - self._frame.y_min_m) / pixel) - half
        self.grid = WindowGrid(
            self._frame.x_min_m + col0 * pixel, self._frame.y_min_m + up0 * pixel, pixel / SUBDIVISION
        )
        self._stale = True
        _copy_map(self._occupied, self._frame.rows - up0 - self._pixels, col0, self.marks)
        cos, sin = math.cos(pose.theta_rad), math.sin(pose.theta_rad)
        outline = self._body @ np.array([[cos, sin], [-sin, cos]]) + np.array([pose.x_m, pose.y_m])
        _clear_outline(self.marks, self.grid, outline)

    def add_scan(self, pose: Pose, scan_m: FloatArray, cut_m: float) -> None:
        """Clear and mark by a scan [180] taken at the believed pose, cut at a range, and update the distances."""
        cos, sin = math.cos(pose.theta_rad), math.sin(pose.theta_rad)
        laser = (pose.x_m + LASER_X_M * cos, pose.y_m + LASER_X_M * sin, pose.theta_rad)
        changed, passed = _clear_passed(self.marks, self._nowhere_m, self.grid, laser, scan_m, cut_m)
        if passed > 0:
            self._hits.fill(0)
            _mark_ends(self._hits, self.grid, laser, scan_m, cut_m + SAME_THING_M)
            fill_distances(self._hits, self.grid.resolution_m, self._to_hit_m)
            changed += _clear_passed(self.marks, self._to_hit_m, self.grid, laser, scan_m, cut_m)[0]
        changed += _mark_ends(self.marks, self.grid, laser, scan_m, cut_m)
        if changed or self._stale:
            fill_distances(self.marks, self.grid.resolution_m, self.distance_m)
            self._stale = False

    def inflated(self, inscribed_m: float, inflation_m: float) -> NDArray[np.float32]:
        """Return the cost [h / 2, w / 2] of each map pixel: 1 where the robot's circle touches, 0 when far."""
        side = self._pixels
        near = self.distance_m.reshape(side, SUBDIVISION, side, SUBDIVISION).min(axis=(1, 3))
        cost = np.clip((inflation_m - near) / (inflation_m - inscribed_m), 0.0, 1.0)
        return np.asarray(cost, dtype=np.float32)
