"""What the camera sees: all faces that share a picture form one mesh, because every drawn geom costs 10 microseconds.

Corners are listed bottom left, bottom right, top right, top left, as seen from outside. Texture coordinates are
(u, v) with v = 0 at the picture's top row.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

Point = tuple[float, float, float]
Uv = tuple[float, float]

# Direction of a side's outward normal, and of "right" for who looks at it.
NORMALS: dict[str, Point] = {"N": (0, 1, 0), "S": (0, -1, 0), "E": (1, 0, 0), "W": (-1, 0, 0)}
SLICES = 10  # corners of a cylinder or ball
STACKS = 5  # rings of a ball

ATLAS_CELLS = 8  # pictures along a side of the atlas
PICTURE_PX = 128
COLOUR_PX = 8
INSET = 2 / PICTURE_PX  # keeps a neighbour's pixels out


@dataclass
class Atlas:
    """One texture that holds a scene's pictures and, in its first cell, its plain colours."""

    colours: list[str] = field(default_factory=list)
    pictures: list[str] = field(default_factory=list)

    def colour(self, colour: str) -> list[Uv]:
        """Four times the middle of a colour's patch."""
        if colour not in self.colours:
            self.colours.append(colour)
        row, col = divmod(self.colours.index(colour), PICTURE_PX // COLOUR_PX)
        scale = COLOUR_PX / PICTURE_PX / ATLAS_CELLS
        return [((col + 0.5) * scale, (row + 0.5) * scale)] * 4

    def spot(self, picture: str, u: float, v: float) -> Uv:
        """Where (u, v) of one picture lies in the atlas."""
        if picture not in self.pictures:
            self.pictures.append(picture)
        row, col = divmod(self.pictures.index(picture) + 1, ATLAS_CELLS)
        u, v = INSET + u * (1 - 2 * INSET), INSET + v * (1 - 2 * INSET)
        return (col + u) / ATLAS_CELLS, (row + v) / ATLAS_CELLS

    def picture(self, picture: str) -> list[Uv]:
        """The four corners of a picture."""
        return [self.spot(picture, u, v) for u, v in ((0, 1), (1, 1), (1, 0), (0, 0))]

    def edge(self, picture: str) -> list[Uv]:
        """Four times the corner of a picture: the colour of its frame."""
        return [self.spot(picture, 0.01, 0.01)] * 4


@dataclass
class Surface:
    """Quadrangles that share one texture."""

    corners: list[Point] = field(default_factory=list)
    normals: list[Point] = field(default_factory=list)
    uvs: list[Uv] = field(default_factory=list)

    def quad(self, corners: Iterable[Point], normals: Iterable[Point], uvs: Iterable[Uv]) -> None:
        """Adds one quadrangle."""
        self.corners += corners
        self.normals += normals
        self.uvs += uvs

    def area_m2(self, triangle: tuple[int, int, int]) -> float:
        """The area of a triangle of corners; next to nothing where a ring shrinks to a tip."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self.corners[i] for i in triangle)
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        return math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2

    def mesh(self, name: str, texture: str) -> tuple[str, str]:
        """The MJCF of texture, material and mesh, and the geom that shows it."""
        quads = range(0, len(self.corners), 4)
        triangles = [t for i in quads for t in ((i, i + 1, i + 2), (i, i + 2, i + 3)) if self.area_m2(t) > 1e-4]
        faces = flat(triangles)
        asset = (
            f'    <texture name="{name}" type="2d" file="{texture}.png"/>\n'
            f'    <material name="{name}" texture="{name}" specular="0"/>\n'
            f'    <mesh name="{name}" inertia="shell" vertex="{flat(self.corners)}"\n'
            f'      normal="{flat(self.normals)}"\n'
            f'      texcoord="{flat(self.uvs)}"\n      face="{faces}"/>\n'
        )
        geom = (
            f'    <geom name="visible_{name}" type="mesh" mesh="{name}" material="{name}" '
            f'contype="0" conaffinity="0"/>\n'
        )
        return asset, geom


def flat(rows: Iterable[tuple[float, ...]]) -> str:
    """All numbers of some rows, parted by blanks."""
    return " ".join(f"{round(value, 5) + 0.0:g}" for row in rows for value in row)


def box_faces(low: Point, high: Point) -> dict[str, list[Point]]:
    """The corners of a box's faces N, E, S, W, top (T) and, where one can look under it, bottom (B)."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    faces = {
        "S": [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
        "E": [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
        "N": [(x1, y1, z0), (x0, y1, z0), (x0, y1, z1), (x1, y1, z1)],
        "W": [(x0, y1, z0), (x0, y0, z0), (x0, y0, z1), (x0, y1, z1)],
        "T": [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
    }
    if z0 > 0.45:
        faces["B"] = [(x0, y1, z0), (x1, y1, z0), (x1, y0, z0), (x0, y0, z0)]
    return faces


def normal_of(side: str) -> Point:
    """The outward normal of a box's face."""
    return NORMALS.get(side, (0.0, 0.0, 1.0 if side == "T" else -1.0))


def round_faces(
    middle: Point, rings: list[tuple[float, float, float]]
) -> Iterable[tuple[list[Point], list[Point], list[Uv]]]:
    """Faces of a body of revolution around an upright axis.

    Args:
        middle: A point on the axis.
        rings: Radius, height over the middle and slope of the normal (its z before scaling) of each ring, from below.
    """
    turns = [2 * math.pi * i / SLICES for i in range(SLICES + 1)]
    for k, (below, above) in enumerate(pairwise(rings)):
        for i, (first, last) in enumerate(pairwise(turns)):
            corners, normals = [], []
            for turn, (radius, height, slope) in ((first, below), (last, below), (last, above), (first, above)):
                c, s, length = math.cos(turn), math.sin(turn), math.hypot(1, slope)
                corners.append((middle[0] + radius * c, middle[1] + radius * s, middle[2] + height))
                normals.append((c / length, s / length, slope / length))
            u, v, du, dv = i / SLICES, 1 - k / (len(rings) - 1), 1 / SLICES, 1 / (len(rings) - 1)
            yield corners, normals, [(u, v), (u + du, v), (u + du, v - dv), (u, v - dv)]


def ball_rings(radius: float, height: float) -> list[tuple[float, float, float]]:
    """Rings of an ellipsoid with half axes `radius` and `height`."""
    angles = [math.pi * (i / STACKS - 0.5) for i in range(STACKS + 1)]
    slope = radius / height
    tilts = [max(-50.0, min(50.0, slope * math.tan(a))) for a in angles]
    return [(max(1e-3, radius * math.cos(a)), height * math.sin(a), t) for a, t in zip(angles, tilts, strict=True)]


def cylinder_rings(radius: float, height: float) -> list[tuple[float, float, float]]:
    """Rings of a cylinder of half height `height`, closed by a flat lid."""
    return [(radius, -height, 0.0), (radius, height, 0.0)]


def lid_rings(radius: float, height: float) -> list[tuple[float, float, float]]:
    """Rings of a cylinder's flat lid."""
    return [(radius, height, 50.0), (1e-3, height, 50.0)]
