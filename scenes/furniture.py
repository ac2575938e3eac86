"""Writes MuJoCo scenes from rooms and pieces of furniture that are placed by maze cell.

A piece covers the cells (col, row) of a rectangle. Its faces lie 5 cm beyond the outermost cell centres, or at the
room's wall where that is nearer than a cell: so a free neighbour's centre keeps 0.35 m to it. Rows count upwards.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from surface import Atlas, Point, Surface, Uv, ball_rings, box_faces, cylinder_rings, lid_rings, normal_of, round_faces

CELL_M = 0.4
OVERHANG_M = 0.05  # how far a face lies beyond the centre of a blocked cell
WALL_HEIGHT_M = 2.5
WALLPAPER_M = 1.25  # width of one wallpaper repeat

FLOOR_PER_M = 0.75  # repeats of a floor texture
REPEATING = ("wall_", "floor_")

HEADING_RAD = {"E": 0.0, "N": math.pi / 2, "W": math.pi, "S": -math.pi / 2}
OPPOSITE = {"N": "S", "S": "N", "E": "W", "W": "E"}

HEADER = """<!-- Written by scenes/build_scenes.py: change that file, then run it. -->
<mujoco model="{title}">
  <compiler angle="radian" texturedir="../textures"/>
  <option timestep="0.002" integrator="implicitfast" gravity="0 0 -9.81"/>
  <visual>
    <quality shadowsize="0" offsamples="0" numquads="1" numslices="8" numstacks="4"/>
    <headlight ambient="0.58 0.58 0.58" diffuse="0.1 0.1 0.1" specular="0 0 0"/>
    <global offwidth="640" offheight="480"/>
    <map znear="0.005"/>
  </visual>
  <custom>
    <numeric name="twonav.map" data="{area}"/>
  </custom>
"""
LIGHTS = """    <light name="sun" directional="true" castshadow="false" specular="0 0 0"
      dir="0.5 0.25 -0.8" diffuse="0.42 0.42 0.40"/>
    <light name="sky" directional="true" castshadow="false" specular="0 0 0"
      dir="-0.2 -0.6 -0.4" diffuse="0.24 0.24 0.28"/>
"""


class Rect(NamedTuple):
    """A rectangle on the floor, in metres."""

    x0: float
    x1: float
    y0: float
    y1: float

    def edge(self, side: str, depth_m: float) -> "Rect":
        """The strip of `depth_m` along the side N, E, S or W."""
        x0, x1, y0, y1 = self
        strips = {
            "N": Rect(x0, x1, y1 - depth_m, y1),
            "S": Rect(x0, x1, y0, y0 + depth_m),
            "E": Rect(x1 - depth_m, x1, y0, y1),
            "W": Rect(x0, x0 + depth_m, y0, y1),
        }
        return strips[side]

    def shrunk(self, dx_m: float, dy_m: float) -> "Rect":
        """The rectangle made smaller by dx and dy on either side."""
        return Rect(self.x0 + dx_m, self.x1 - dx_m, self.y0 + dy_m, self.y1 - dy_m)


@dataclass(frozen=True)
class Room:
    """A room: its floor between the walls, and where the centre of maze cell (0, 0) lies."""

    name: str
    floor: Rect
    cell_x_m: float
    cell_y_m: float

    def at(self, col: float, row: float) -> tuple[float, float]:
        """The centre of a maze cell in metres."""
        return self.cell_x_m + CELL_M * col, self.cell_y_m + CELL_M * row

    def block(self, col0: int, col1: int, row0: int, row1: int) -> Rect:
        """The rectangle of a piece that blocks the cells col0..col1, row0..row1; snaps to walls nearby."""
        (x0, y0), (x1, y1) = self.at(col0, row0), self.at(col1, row1)
        x0, x1, y0, y1 = x0 - OVERHANG_M, x1 + OVERHANG_M, y0 - OVERHANG_M, y1 + OVERHANG_M
        wall = self.floor
        return Rect(
            wall.x0 if x0 - wall.x0 < CELL_M else x0,
            wall.x1 if wall.x1 - x1 < CELL_M else x1,
            wall.y0 if y0 - wall.y0 < CELL_M else y0,
            wall.y1 if wall.y1 - y1 < CELL_M else y1,
        )


@dataclass
class Scene:
    """Collects solid geoms, what the camera sees of them, and sites, and writes them as one MJCF text.

    Solid geoms are named boxes and cylinders in group 3, which no camera draws; their faces are drawn as meshes.
    A look is a colour "#rrggbb", a texture's name, or "front@#rrggbb": a texture on the face that the box turns to
    its facing side and the colour on the other faces. Textures of walls and floors repeat.
    """

    title: str
    area: str
    atlas: Atlas = field(default_factory=Atlas)
    surfaces: dict[str, Surface] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def geom(self, name: str, shape: str, size: str, pos: str) -> None:
        """Adds one solid geom."""
        self.lines.append(f'    <geom name="{name}" type="{shape}" size="{size}" pos="{pos}" group="3"/>\n')

    def surface(self, look: str) -> Surface:
        """The mesh that holds a look's faces."""
        repeats = look.startswith(REPEATING)
        return self.surfaces.setdefault(look if repeats else f"atlas_{self.title}", Surface())

    def box(
        self, name: str, rect: Rect, z0: float, z1: float, look: str, facing: str = "", solid: bool = True,
    ) -> None:  # fmt: skip
        """Adds a box over `rect` from z0 to z1; with a facing side its texture stands upright on that side."""
        x0, x1, y0, y1 = rect
        if solid:
            middle = numbers((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)
            self.geom(name, "box", numbers((x1 - x0) / 2, (y1 - y0) / 2, (z1 - z0) / 2), middle)
        flat_on_wall = facing and "@" not in look and not look.startswith("#")
        for side, corners in box_faces((x0, y0, z0), (x1, y1, z1)).items():
            if flat_on_wall and side == OPPOSITE[facing] and thin(rect):
                continue  # nobody looks at the back of a picture or of a wall's half
            self.surface(look).quad(corners, [normal_of(side)] * 4, self.uvs(look, facing, side, corners))

    def uvs(self, look: str, facing: str, side: str, corners: list[Point]) -> list[Uv]:
        """Texture coordinates of one face of a box."""
        front, _, colour = look.partition("@")
        if look.startswith("#"):
            return self.atlas.colour(look)
        if look.startswith("floor_"):
            return [(x * FLOOR_PER_M, -y * FLOOR_PER_M) for x, y, _ in corners]
        if look.startswith("wall_"):
            wide = 0.0 if side in "TB" else math.dist(corners[0], corners[1]) / WALLPAPER_M
            wide = max(0.25, round(wide * 4) / 4) if side == facing else wide
            return [(0, 1), (wide, 1), (wide, 0), (0, 0)] if wide else [(0.01, 0.01)] * 4
        if colour and side != facing:
            return self.atlas.colour(colour)
        return self.atlas.edge(front) if facing and side != facing else self.atlas.picture(front)

    def turned(self, look: str, middle: Point, rings: list[tuple[float, float, float]]) -> None:
        """Shows a body of revolution."""
        for corners, normals, uvs in round_faces(middle, rings):
            spots = self.atlas.colour(look) if look.startswith("#") else [self.atlas.spot(look, u, v) for u, v in uvs]
            self.surface(look).quad(corners, normals, spots)

    def cylinder(self, name: str, x: float, y: float, z0: float, z1: float, radius: float, look: str) -> None:
        """Adds an upright cylinder."""
        middle, half = (x, y, (z0 + z1) / 2), (z1 - z0) / 2
        self.geom(name, "cylinder", numbers(radius, half), numbers(*middle))
        self.turned(look, middle, cylinder_rings(radius, half))
        self.turned(look, middle, lid_rings(radius, half))

    def ball(self, name: str, x: float, y: float, z: float, radius: float, height: float, look: str) -> None:
        """Adds an upright ellipsoid around (x, y, z)."""
        self.geom(name, "ellipsoid", numbers(radius, radius, height), numbers(x, y, z))
        self.turned(look, (x, y, z), ball_rings(radius, height))

    def floor(self, room: Room, look: str) -> None:
        """Lays a room's floor (4 mm over the hard plane, only seen) and declares the room."""
        rect = room.floor
        self.box(f"{room.name}_floor", rect.shrunk(-0.05, -0.05), 0.0, 0.004, look, "", False)
        middle = numbers((rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2, WALL_HEIGHT_M / 2)
        half = numbers((rect.x1 - rect.x0) / 2, (rect.y1 - rect.y0) / 2, WALL_HEIGHT_M / 2)
        self.lines.append(
            f'    <site name="room/{room.name}" type="box" group="4" pos="{middle}" size="{half}" rgba="1 1 1 0.1"/>\n'
        )

    def wall(
        self, room: Room, side: str, look: str, gaps: tuple[tuple[float, float], ...] = (),
        thickness: float = 0.05, plain: bool = False,
    ) -> None:  # fmt: skip
        """Builds one wall outside a room's floor, open at the gaps (middle, half width) along it."""
        rect = room.floor
        start, end = (rect.x0 - 0.05, rect.x1 + 0.05) if side in "NS" else (rect.y0, rect.y1)
        stops = [start, *(stop for middle, half in gaps for stop in (middle - half, middle + half)), end]
        for number, (first, last) in enumerate(zip(stops[::2], stops[1::2], strict=True), 1):
            strip = {
                "N": Rect(first, last, rect.y1, rect.y1 + thickness),
                "S": Rect(first, last, rect.y0 - thickness, rect.y0),
                "E": Rect(rect.x1, rect.x1 + thickness, first, last),
                "W": Rect(rect.x0 - thickness, rect.x0, first, last),
            }[side]
            name = f"{'plain' if plain else 'wall'}_{room.name}_{SIDES[side]}_{number}"
            self.box(name, strip, 0.0, WALL_HEIGHT_M, look, OPPOSITE[side])

    def doorway(self, name: str, middle: tuple[float, float], along: str, half: float, colour: str) -> None:
        """Frames an opening in a wall that runs along x or y: two jambs and the panel above."""
        x, y = middle

        def across(first: float, last: float, depth: float) -> Rect:
            if along == "x":
                return Rect(x + first, x + last, y - depth, y + depth)
            return Rect(x - depth, x + depth, y + first, y + last)

        self.box(f"{name}_jamb_1", across(-half, -half + 0.06, 0.065), 0.0, 2.1, colour)
        self.box(f"{name}_jamb_2", across(half - 0.06, half, 0.065), 0.0, 2.1, colour)
        self.box(f"{name}_lintel", across(-half, half, 0.06), 2.1, WALL_HEIGHT_M, colour)

    def hang(
        self, name: str, room: Room, side: str, along: float, z: float, size: tuple[float, float], look: str
    ) -> None:
        """Hangs a thin picture, window or mirror of (width, height) on a wall, its middle at height z."""
        wide = size[0] / 2
        rect, deep = room.floor, 0.03
        strip = {
            "N": Rect(along - wide, along + wide, rect.y1 - deep, rect.y1),
            "S": Rect(along - wide, along + wide, rect.y0, rect.y0 + deep),
            "E": Rect(rect.x1 - deep, rect.x1, along - wide, along + wide),
            "W": Rect(rect.x0, rect.x0 + deep, along - wide, along + wide),
        }[side]
        self.box(name, strip, z - size[1] / 2, z + size[1] / 2, look, OPPOSITE[side], False)

    def rug(self, name: str, rect: Rect, look: str) -> None:
        """Lays a rug of 12 mm that is only seen."""
        self.box(name, rect, 0.0, 0.012, look, "", False)

    def place(self, kind: str, name: str, room: Room, cell: tuple[int, int], heading: str) -> None:
        """Declares a goal or a start at the centre of a maze cell, looking N, E, S or W."""
        turn = HEADING_RAD[heading]
        quat = numbers(math.cos(turn / 2), 0, 0, math.sin(turn / 2))
        rgba = "1 0.3 0.2 1" if kind == "goal" else "0.2 0.5 1 1"
        pos = numbers(*room.at(*cell), 0.05)
        self.lines.append(
            f'    <site name="{kind}/{name}" group="4" size="0.05" pos="{pos}" quat="{quat}" rgba="{rgba}"/>\n'
        )

    def text(self) -> str:
        """The scene as MJCF."""
        sky = '    <texture name="sky" type="skybox" builtin="flat" rgb1="0.94 0.93 0.90" width="8" height="48"/>\n'
        meshes = [surface.mesh(name, name) for name, surface in self.surfaces.items()]
        return (
            HEADER.format(title=self.title, area=self.area)
            + f"  <asset>\n{sky}{''.join(asset for asset, _ in meshes)}  </asset>\n"
            + f"  <worldbody>\n{LIGHTS}{''.join(self.lines)}{''.join(geom for _, geom in meshes)}  </worldbody>\n"
            + "</mujoco>\n"
        )

    def write(self, folder: Path) -> None:
        """Writes scene.xml into a folder."""
        folder.mkdir(exist_ok=True)
        (folder / "scene.xml").write_text(self.text(), encoding="utf-8")


SIDES = {"N": "north", "E": "east", "S": "south", "W": "west"}


def rgb(colour: str) -> str:
    """ "#rrggbb" as three numbers from 0 to 1."""
    return " ".join(f"{int(colour[i : i + 2], 16) / 255:.3g}" for i in (1, 3, 5))


def thin(rect: Rect) -> bool:
    """Whether a rectangle is at most 5 cm wide, as a picture and half of an inner wall are."""
    return min(rect.x1 - rect.x0, rect.y1 - rect.y0) < 0.051


def numbers(*values: float) -> str:
    """Numbers with at most four decimals, parted by blanks."""
    return " ".join(f"{round(value, 4) + 0.0:g}" for value in values)
