"""Writes the two scenes: `python scenes/build_scenes.py` rewrites scenes/*/scene.xml.

Walls stand on lines of maze cells: in the apartment cell (col, row) has its centre at (0.2 + 0.4 col, 0.1 + 0.4 row),
in the kitchen at (0.1 + 0.4 col, 0.1 + 0.4 row). Letters N E S W name sides; a piece faces the side it is used from.
"""

from pathlib import Path

import cv2
import numpy as np
from furniture import Rect, Room, Scene
from numpy.typing import NDArray
from pieces import armchair, bathtub, bed, chair, counter, lamp, plant, sofa, table, toilet
from surface import ATLAS_CELLS, COLOUR_PX, PICTURE_PX, Atlas

FOLDER = Path(__file__).parent
DOOR = 0.55  # half width of a doorway: one row of free cells passes it
OPENING = 0.95  # half width of a wide opening: three rows of free cells

LIVING = Room("living_room", Rect(0.2, 8.15, 4.95, 8.9), 0.2, 0.1)
KITCHEN = Room("kitchen", Rect(8.25, 13.8, 4.95, 8.9), 0.2, 0.1)
HALL = Room("hallway", Rect(0.2, 9.75, 3.35, 4.85), 0.2, 0.1)
BEDROOM = Room("bedroom", Rect(0.2, 5.75, 0.1, 3.25), 0.2, 0.1)
BATH = Room("bathroom", Rect(5.85, 9.75, 0.1, 3.25), 0.2, 0.1)
STUDY = Room("study", Rect(9.85, 13.8, 0.1, 4.85), 0.2, 0.1)
SMALL = Room("kitchen", Rect(0.1, 6.9, 0.1, 4.9), 0.1, 0.1)

# name: (middle of the opening, the wall runs along x or y, half width, colour of the frame)
DOORWAYS = {
    "door_living_west": ((1.8, 4.9), "x", DOOR, "#8a2f2f"),
    "door_living_wide": ((6.2, 4.9), "x", OPENING, "#e8b23a"),
    "door_kitchen_hall": ((9.0, 4.9), "x", DOOR, "#2f8a86"),
    "door_kitchen_study": ((12.2, 4.9), "x", DOOR, "#3a5a2a"),
    "door_bedroom": ((3.8, 3.3), "x", DOOR, "#6a3fa0"),
    "door_bathroom": ((8.2, 3.3), "x", DOOR, "#1f6fb0"),
    "door_ensuite": ((5.8, 1.7), "y", DOOR, "#f0f0f0"),
    "door_study": ((9.8, 4.1), "y", DOOR, "#5a3a20"),
    "door_kitchen_wide": ((8.2, 6.5), "y", OPENING, "#d8602a"),
}


def ground(scene: Scene, width: float, depth: float) -> None:
    """The hard floor, a plane of the scene's outer size."""
    size = f"{width / 2:g} {depth / 2:g} 0.1"
    scene.lines.append(
        f'    <geom name="floor" type="plane" size="{size}" pos="{width / 2:g} {depth / 2:g} 0" group="3"/>\n'
    )


def living_room(scene: Scene) -> None:
    """Sofa before the television, bookcase, piano and a reading corner."""
    room = LIVING
    scene.floor(room, "floor_oak")
    scene.wall(room, "N", "wall_cream", thickness=0.1)
    scene.wall(room, "W", "wall_terracotta", thickness=0.2)
    scene.wall(room, "S", "wall_olive_dado", ((1.8, DOOR), (6.2, OPENING)))
    scene.wall(room, "E", "wall_red_brick", ((6.5, OPENING),))
    scene.rug("living_rug_red", Rect(1.2, 3.25, 6.3, 8.2), "rug_red")
    scene.rug("living_rug_round", Rect(5.7, 7.4, 5.7, 7.4), "rug_round")
    sofa(scene, "sofa", room.block(8, 10, 16, 20), "W", "#2f5fb3", "#24498c")
    scene.box("sofa_cushion", Rect(3.75, 3.9, 7.5, 7.95), 0.42, 0.75, "#f2b632")
    table(scene, "coffee_table", room.block(5, 6, 17, 18), 0.4, "wood", "#5a3a20", 0.06)
    scene.box("tv_console", room.block(1, 1, 16, 19), 0.0, 0.5, "doors_walnut@#784a2c", "E")
    scene.box("tv_screen", Rect(0.35, 0.43, 6.55, 7.75), 0.55, 1.3, "screen_tv@#101012", "E")
    scene.box("bookshelf", room.block(6, 11, 13, 13), 0.0, 1.9, "books_many@#6e4022", "N")
    scene.box("piano_body", room.block(12, 15, 21, 21), 0.0, 1.15, "#3a1a12")
    scene.box("piano_keys", Rect(5.05, 6.2, 8.42, 8.5), 0.62, 0.74, "piano", "S")
    scene.box("divider_shelf", room.block(13, 13, 16, 18), 0.0, 1.25, "books_low@#f0782a", "W")
    armchair(scene, "armchair", room.block(18, 19, 20, 21), "W", "#2e8b57", "#f6e27a")
    lamp(scene, "living_lamp", 0.45, 8.65, "#ffe9a0")
    plant(scene, "living_plant", 7.95, 5.15, "#d0603a", "leaves", 1.2)
    scene.hang("living_window", room, "N", 2.2, 1.4, (2.2, 1.2), "window_hills")
    scene.hang("painting_sunset", room, "N", 4.4, 1.35, (0.9, 0.9), "painting_sunset")
    scene.hang("painting_blocks", room, "N", 6.9, 1.4, (0.8, 0.8), "painting_blocks")
    scene.hang("painting_boat", room, "W", 5.7, 1.25, (0.8, 0.8), "painting_boat")
    scene.hang("painting_rings", room, "E", 8.2, 1.35, (0.8, 0.8), "painting_rings")
    scene.hang("painting_portrait", room, "S", 0.7, 1.2, (0.6, 0.8), "painting_portrait")


def kitchen(scene: Scene) -> None:
    """Fridge, stove and sink along two walls, a dining table with four chairs."""
    room = KITCHEN
    scene.floor(room, "floor_kitchen")
    scene.wall(room, "N", "wall_yellow_tiles", thickness=0.1)
    scene.wall(room, "E", "wall_lemon", thickness=0.2)
    scene.wall(room, "S", "wall_orange_dado", ((9.0, DOOR), (12.2, DOOR)))
    scene.wall(room, "W", "wall_checks", ((6.5, OPENING),))
    scene.box("kitchen_fridge", room.block(21, 22, 20, 21), 0.0, 1.85, "fridge_mint@#aadcc8", "S")
    north = room.block(21, 33, 21, 21)
    counter(scene, "kitchen_counter_left", north._replace(x0=9.1, x1=10.7), "S",
            ("drawers_red@#be3232", "doors_teal@#288282"), "#5b4636")  # fmt: skip
    counter(scene, "kitchen_counter_right", north._replace(x0=11.4, x1=13.3), "S",
            ("doors_teal@#288282", "doors_white@#f0ece2"), "#5b4636")  # fmt: skip
    scene.box("kitchen_stove", north._replace(x0=10.7, x1=11.4), 0.0, 0.9, "stove@#d6d6da", "S")
    scene.box("kitchen_hob", north._replace(x0=10.7, x1=11.4), 0.9, 0.915, "hob")
    scene.box("kitchen_hood", Rect(10.7, 11.4, 8.5, 8.9), 1.5, 1.9, "#8c929a")
    scene.box("kitchen_upper_left", Rect(9.2, 10.5, 8.6, 8.9), 1.4, 2.1, "doors_teal@#288282", "S")
    scene.box("kitchen_upper_right", Rect(11.7, 12.6, 8.6, 8.9), 1.4, 2.1, "doors_pine@#dea664", "S")
    counter(scene, "kitchen_sink_counter", room.block(33, 33, 17, 21), "W",
            ("drawers_yellow@#f0be32", "doors_white@#f0ece2"), "#c8ccd0")  # fmt: skip
    scene.box("kitchen_sink", Rect(13.4, 13.75, 7.3, 7.9), 0.9, 0.94, "#6e8ca8")
    scene.cylinder("kitchen_faucet", 13.7, 7.6, 0.94, 1.2, 0.03, "#404448")
    scene.hang("kitchen_window", room, "E", 7.6, 1.6, (1.5, 1.0), "window_city")
    eat = room.block(25, 28, 14, 18)
    table(scene, "dining_table", Rect(eat.x0, eat.x1, 6.05, 6.95), 0.76, "wood", "#6a4426")
    for name, x0, y0, facing, colour in (
        ("dining_chair_1", eat.x0, eat.y0, "N", "#d23c3c"),
        ("dining_chair_2", eat.x1 - 0.42, eat.y0, "N", "#f0b428"),
        ("dining_chair_3", eat.x0 + 0.1, eat.y1 - 0.4, "S", "#3c78d2"),
        ("dining_chair_4", eat.x1 - 0.5, eat.y1 - 0.4, "S", "#46a050"),
    ):
        chair(scene, name, Rect(x0, x0 + 0.42, y0, y0 + 0.4), facing, colour)
    scene.ball("fruit_bowl", 10.8, 6.5, 0.82, 0.16, 0.08, "#e8502a")
    plant(scene, "kitchen_plant", 13.6, 5.15, "#f0f0f0", "leaves_blue", 0.9)
    scene.box("wine_rack", room.block(33, 33, 14, 15), 0.0, 0.8, "#7a2430")
    scene.hang("painting_pear", room, "E", 5.9, 1.4, (0.8, 0.8), "painting_pear")
    scene.hang("painting_fish", room, "S", 10.6, 1.25, (0.9, 0.9), "painting_fish")
    scene.hang("painting_rainbow", room, "W", 7.9, 1.3, (0.7, 0.7), "painting_rainbow")
    scene.hang("painting_chess", room, "S", 13.2, 1.3, (0.6, 0.6), "painting_chess")


def hallway(scene: Scene) -> None:
    """Front door at the west end, shoe cabinet, console and bench; one long plain wall."""
    room = HALL
    scene.floor(room, "floor_hall")
    scene.wall(room, "W", "wall_mustard", thickness=0.2)
    scene.wall(room, "N", "wall_grey_band", ((1.8, DOOR), (6.2, OPENING), (9.0, DOOR)))
    scene.wall(room, "S", "wall_grey", ((3.8, DOOR), (8.2, DOOR)), plain=True)
    scene.wall(room, "E", "wall_slate_stripes", ((4.1, DOOR),))
    scene.hang("front_door", room, "W", 4.1, 1.0, (1.0, 2.0), "front_door")
    scene.rug("hall_runner", Rect(0.4, 3.2, 3.75, 4.45), "rug_runner")
    scene.box("shoe_cabinet", room.block(7, 9, 11, 11), 0.0, 0.9, "doors_blue@#3c5aaa", "S")
    scene.box("hall_console", room.block(12, 13, 9, 9), 0.0, 0.8, "drawers_yellow@#f0be32", "N")
    scene.hang("hall_mirror", room, "S", 5.2, 1.4, (0.7, 0.9), "mirror")
    scene.box("hall_bench", room.block(18, 19, 11, 11), 0.0, 0.45, "#a0482a")
    scene.hang("painting_moon", room, "N", 7.75, 1.35, (0.8, 0.8), "painting_moon")
    scene.hang("painting_strokes", room, "N", 4.6, 1.35, (0.7, 0.7), "painting_strokes")
    scene.hang("painting_waves", room, "N", 0.75, 1.3, (0.7, 0.7), "painting_waves")
    scene.hang("painting_tree", room, "S", 9.25, 1.35, (0.7, 0.7), "painting_tree")


def bedroom(scene: Scene) -> None:
    """A double bed, wardrobe and dresser; the wall beside the bathroom door is plain."""
    room = BEDROOM
    scene.floor(room, "floor_carpet")
    scene.wall(room, "N", "wall_violet_dots", ((3.8, DOOR),))
    scene.wall(room, "W", "wall_blue_stripes", thickness=0.2)
    scene.wall(room, "S", "wall_rose", thickness=0.1)
    scene.wall(room, "E", "wall_lavender", ((1.7, DOOR),), plain=True)
    scene.rug("bedroom_rug", Rect(2.7, 4.3, 0.9, 2.5), "rug_pink")
    bed(scene, "bed", room.block(1, 5, 2, 6), "E", "#b4783c")
    scene.box("nightstand", Rect(0.2, 0.65, 2.58, 2.98), 0.0, 0.5, "drawers_grey@#8c96a0", "E")
    scene.cylinder("night_lamp", 0.42, 2.8, 0.5, 0.8, 0.1, "#ffd24a")
    scene.box("wardrobe", room.block(9, 12, 1, 1), 0.0, 2.1, "doors_pine@#dea664", "N")
    scene.box("dresser", room.block(12, 13, 7, 7), 0.0, 0.9, "drawers_red@#be3232", "S")
    scene.hang("dresser_mirror", room, "N", 5.35, 1.4, (0.6, 0.8), "mirror")
    scene.hang("bedroom_window", room, "S", 2.6, 1.45, (1.4, 1.1), "window_sea")
    scene.hang("painting_heart", room, "W", 1.7, 1.55, (0.8, 0.8), "painting_heart")
    scene.hang("painting_flower", room, "N", 1.6, 1.35, (0.8, 0.8), "painting_flower")


def bathroom(scene: Scene) -> None:
    """Bathtub with a curtain, toilet, wash basin and washing machine."""
    room = BATH
    scene.floor(room, "floor_bath")
    scene.wall(room, "N", "wall_mint_band", ((8.2, DOOR),))
    scene.wall(room, "W", "wall_white_tiles", ((1.7, DOOR),))
    scene.wall(room, "S", "wall_navy_tiles", thickness=0.1)
    scene.wall(room, "E", "wall_aqua_tiles")
    bathtub(scene, "bathtub", room.block(22, 23, 1, 4), "#e8eef0")
    scene.box("shower_curtain", Rect(8.98, 9.72, 1.68, 1.73), 0.605, 2.1, "curtain")
    toilet(scene, "toilet", room.block(18, 19, 1, 2), "N")
    scene.box("washing_machine", room.block(15, 16, 1, 1), 0.0, 0.88, "washer@#f0f0f4", "N")
    scene.box("basin_cabinet", room.block(16, 17, 7, 7), 0.0, 0.8, "doors_blue@#3c5aaa", "S")
    scene.box("basin", Rect(6.6, 7.0, 2.88, 3.2), 0.8, 0.88, "#ffffff")
    scene.hang("basin_mirror", room, "N", 6.8, 1.4, (0.7, 0.8), "mirror")
    scene.box("towel_shelf", room.block(23, 23, 6, 7), 0.0, 1.5, "towels@#d8d0c0", "W")
    scene.rug("bath_mat", Rect(8.1, 8.85, 0.8, 1.7), "#f08c3c")
    scene.hang("painting_crosses", room, "S", 7.0, 1.45, (0.7, 0.7), "painting_crosses")
    scene.hang("painting_spiral", room, "W", 2.75, 1.35, (0.7, 0.7), "painting_spiral")


def study(scene: Scene) -> None:
    """Desk with monitor and office chair, binders, a globe; the south wall is plain."""
    room = STUDY
    scene.floor(room, "floor_walnut")
    scene.wall(room, "N", "wall_sage", ((12.2, DOOR),))
    scene.wall(room, "W", "wall_moss_diamonds", ((4.1, DOOR),))
    scene.wall(room, "S", "wall_forest", thickness=0.1, plain=True)
    scene.wall(room, "E", "wall_green_panels", thickness=0.2)
    desk = room.block(32, 33, 4, 7)
    scene.box("desk_top", desk, 0.68, 0.74, "wood")
    scene.box("desk_drawers", desk.edge("S", 0.42), 0.0, 0.68, "drawers_grey@#8c96a0", "W")
    scene.box("desk_computer", desk.edge("N", 0.36), 0.0, 0.68, "#5a3a20")
    scene.box("desk_modesty_panel", desk.edge("E", 0.1), 0.0, 0.68, "#8a5c34")
    scene.box("desk_monitor", Rect(13.45, 13.52, 1.9, 2.7), 0.84, 1.34, "screen_code@#101012", "W")
    scene.cylinder("desk_monitor_foot", 13.5, 2.3, 0.74, 0.84, 0.08, "#101012")
    chair_at = room.block(31, 31, 5, 6)
    scene.box("office_chair_seat", chair_at._replace(x0=12.55, x1=12.95), 0.0, 0.5, "#d03030")
    scene.box("office_chair_back", chair_at._replace(x0=12.55, x1=12.63), 0.5, 1.0, "#d03030")
    scene.box("binder_shelf", room.block(25, 25, 2, 6), 0.0, 1.6, "books_office@#3c424c", "E")
    globe_x, globe_y = room.at(28.5, 7.5)
    scene.cylinder("globe_stand", globe_x, globe_y, 0.0, 0.5, 0.25, "#c87828")
    scene.ball("globe", globe_x, globe_y, 0.75, 0.26, 0.26, "painting_world_map")
    scene.box("file_cabinet", room.block(29, 30, 1, 1), 0.0, 1.1, "drawers_yellow@#f0be32", "N")
    plant(scene, "study_plant", 13.6, 0.3, "#3a5aa0", "leaves", 1.4)
    lamp(scene, "study_lamp", 13.55, 4.6, "#ff8c5a")
    scene.rug("study_rug", Rect(10.9, 12.3, 0.8, 2.6), "rug_green")
    scene.hang("painting_world_map", room, "W", 1.7, 2.05, (1.2, 0.7), "painting_world_map")
    scene.hang("study_window", room, "E", 3.7, 1.4, (1.0, 1.0), "window_hills")
    scene.hang("painting_mountains", room, "N", 10.7, 1.3, (0.9, 0.9), "painting_mountains")
    scene.hang("painting_triangles", room, "E", 1.0, 1.4, (0.8, 0.8), "painting_triangles")


APARTMENT_GOALS = {
    "kitchen": (KITCHEN, (27, 20), "N"), "table": (KITCHEN, (24, 16), "E"), "sofa": (LIVING, (7, 18), "E"),
    "tv": (LIVING, (2, 17), "W"), "bed": (BEDROOM, (6, 4), "W"), "wardrobe": (BEDROOM, (10, 2), "S"),
    "bath": (BATH, (21, 3), "E"), "desk": (STUDY, (30, 5), "E"), "bookshelf": (LIVING, (9, 14), "S"),
    "door": (HALL, (1, 10), "W"),
}  # fmt: skip
APARTMENT_STARTS = {
    "s1": (LIVING, (17, 19), "W"), "s2": (LIVING, (2, 14), "N"), "s3": (KITCHEN, (31, 14), "N"),
    "s4": (KITCHEN, (23, 19), "E"), "s5": (HALL, (7, 10), "E"), "s6": (HALL, (18, 10), "W"),
    "s7": (BEDROOM, (12, 5), "W"), "s8": (BATH, (16, 4), "E"), "s9": (STUDY, (27, 2), "N"),
    "s10": (STUDY, (32, 9), "S"),
}  # fmt: skip


def apartment() -> Scene:
    """The apartment of 14 x 9 m: six rooms, nine doorways, ten goals, ten starts."""
    scene = Scene("apartment", "-2.4 -0.1 16.4 9.5")
    ground(scene, 14.0, 9.0)
    for furnish in (living_room, kitchen, hallway, bedroom, bathroom, study):
        furnish(scene)
    for name, (middle, along, half, colour) in DOORWAYS.items():
        scene.doorway(name, middle, along, half, colour)
    for name, (room, cell, heading) in APARTMENT_GOALS.items():
        scene.place("goal", name, room, cell, heading)
    for name, (room, cell, heading) in APARTMENT_STARTS.items():
        scene.place("start", name, room, cell, heading)
    return scene


def small_kitchen() -> Scene:
    """One kitchen of 7 x 5 m with a table in the middle; five goals, five starts."""
    scene, room = Scene("kitchen", "-0.5 -0.5 7.5 5.5"), SMALL
    ground(scene, 7.0, 5.0)
    scene.floor(room, "floor_blue")
    scene.wall(room, "N", "wall_teal_tiles", thickness=0.1)
    scene.wall(room, "E", "wall_mint_stripes", thickness=0.1)
    scene.wall(room, "S", "wall_peach", thickness=0.1)
    scene.wall(room, "W", "wall_sky", thickness=0.1, plain=True)
    north = room.block(3, 10, 11, 11)
    scene.box("fridge", room.block(1, 2, 10, 11), 0.0, 1.9, "fridge_red@#c83232", "S")
    counter(scene, "counter_left", north._replace(x0=0.95, x1=2.1), "S", ("doors_white@#f0ece2",), "#8a5c34")
    scene.box("stove", north._replace(x0=2.1, x1=2.8), 0.0, 0.9, "stove@#d6d6da", "S")
    scene.box("stove_hob", north._replace(x0=2.1, x1=2.8), 0.9, 0.915, "hob")
    scene.box("stove_hood", Rect(2.1, 2.8, 4.5, 4.9), 1.5, 1.9, "#8c929a")
    counter(scene, "counter_right", north._replace(x0=2.8), "S",
            ("drawers_yellow@#f0be32", "doors_blue@#3c5aaa"), "#8a5c34")  # fmt: skip
    scene.box("upper_cabinet", Rect(2.95, 4.1, 4.6, 4.9), 1.4, 2.1, "doors_blue@#3c5aaa", "S")
    scene.box("sink", Rect(3.2, 3.8, 4.5, 4.85), 0.9, 0.94, "#6e8ca8")
    scene.cylinder("faucet", 3.5, 4.82, 0.94, 1.2, 0.03, "#404448")
    eat = room.block(8, 12, 4, 6)
    table(scene, "table", eat.shrunk(0.3, 0.0), 0.76, "wood", "#6a4426")
    chair(scene, "chair_west", Rect(eat.x0, eat.x0 + 0.4, 1.7, 2.35), "E", "#d23c3c")
    chair(scene, "chair_east", Rect(eat.x1 - 0.4, eat.x1, 1.7, 2.35), "W", "#f0b428")
    scene.box("shelf", room.block(3, 6, 1, 1), 0.0, 1.5, "books_low@#f0ece2", "N")
    scene.box("cart", room.block(4, 5, 6, 7), 0.0, 0.8, "drawers_red@#be3232", "S")
    scene.rug("rug", Rect(4.9, 6.4, 3.2, 4.4), "rug_round")
    plant(scene, "plant", 6.7, 0.3, "#d0603a", "leaves", 1.2)
    scene.hang("window", room, "E", 2.5, 1.4, (1.6, 1.2), "window_hills")
    scene.hang("painting_desert", room, "N", 5.6, 1.35, (0.9, 0.9), "painting_desert")
    scene.hang("painting_city", room, "S", 4.4, 1.3, (0.8, 0.8), "painting_city")
    scene.hang("painting_rings", room, "S", 5.8, 1.3, (0.7, 0.7), "painting_rings")
    scene.hang("painting_flower", room, "E", 4.3, 1.3, (0.7, 0.7), "painting_flower")
    for name, cell, heading in (("stove", (6, 10), "N"), ("fridge", (2, 9), "N"), ("table", (10, 3), "N"),
                                ("window", (15, 6), "E"), ("shelf", (4, 2), "S")):  # fmt: skip
        scene.place("goal", name, room, cell, heading)
    for name, cell, heading in (("s1", (1, 1), "N"), ("s2", (14, 10), "W"), ("s3", (14, 2), "W"),
                                ("s4", (7, 8), "S"), ("s5", (2, 5), "E")):  # fmt: skip
        scene.place("start", name, room, cell, heading)
    return scene


def draw_atlas(atlas: Atlas) -> NDArray[np.uint8]:
    """The picture of an atlas, (1024, 1024, 3) BGR, from the textures on disk."""
    image = np.zeros((ATLAS_CELLS * PICTURE_PX, ATLAS_CELLS * PICTURE_PX, 3), dtype=np.uint8)
    for number, colour in enumerate(atlas.colours):
        row, col = (COLOUR_PX * part for part in divmod(number, PICTURE_PX // COLOUR_PX))
        image[row : row + COLOUR_PX, col : col + COLOUR_PX] = [int(colour[i : i + 2], 16) for i in (5, 3, 1)]
    for number, name in enumerate(atlas.pictures, 1):
        row, col = (PICTURE_PX * part for part in divmod(number, ATLAS_CELLS))
        picture = np.asarray(cv2.imread(str(FOLDER / "textures" / f"{name}.png")), dtype=np.uint8)
        image[row : row + PICTURE_PX, col : col + PICTURE_PX] = cv2.resize(
            picture, (PICTURE_PX, PICTURE_PX), interpolation=cv2.INTER_AREA
        )
    return image


def main() -> None:
    """Writes both scenes."""
    for scene in (apartment(), small_kitchen()):
        scene.write(FOLDER / scene.title)
        cv2.imwrite(str(FOLDER / "textures" / f"atlas_{scene.title}.png"), draw_atlas(scene.atlas))


if __name__ == "__main__":
    main()
