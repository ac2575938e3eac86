"""Draws every texture of the two scenes: `python scenes/make_textures.py` rewrites the identical PNG files.
Run scenes/build_scenes.py afterwards: it gathers the pictures of a scene into its atlas.

Pictures are (H, W, 3) uint8 in RGB, drawn with OpenCV. Noise comes from a generator seeded by the texture's name.
"""

import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from paintings import PAINTINGS, Picture, blank

FOLDER = Path(__file__).parent / "textures"
Rgb = tuple[int, int, int]

LINEN: Rgb = (240, 240, 230)
WALL_HEIGHT_PX = 256  # one wall, floor to top, 2.5 m
WALL_WIDTH_PX = 128  # repeats about every 1.25 m

# name: (wall colour, skirting colour, pattern, pattern colour)
WALLS: dict[str, tuple[Rgb, Rgb, str, Rgb]] = {
    "wall_cream": ((238, 222, 184), (120, 72, 40), "plain", (0, 0, 0)),
    "wall_terracotta": ((196, 106, 74), (245, 235, 220), "plain", (0, 0, 0)),
    "wall_gold_stripes": ((226, 190, 110), (120, 72, 40), "stripes", (240, 218, 160)),
    "wall_olive_dado": ((222, 212, 160), (70, 60, 30), "dado", (124, 128, 60)),
    "wall_red_brick": ((170, 78, 60), (60, 40, 36), "bricks", (214, 190, 176)),
    "wall_yellow_tiles": ((248, 226, 130), (150, 60, 40), "tiles", (250, 250, 235)),
    "wall_orange_dado": ((250, 236, 200), (150, 60, 40), "dado", (236, 140, 50)),
    "wall_checks": ((244, 240, 226), (40, 60, 110), "checks", (206, 60, 56)),
    "wall_lemon": ((250, 232, 140), (150, 60, 40), "plain", (0, 0, 0)),
    "wall_lavender": ((190, 172, 224), (84, 56, 130), "plain", (0, 0, 0)),
    "wall_violet_dots": ((168, 140, 210), (240, 236, 250), "dots", (244, 214, 240)),
    "wall_blue_stripes": ((120, 150, 214), (240, 236, 250), "stripes", (174, 198, 240)),
    "wall_rose": ((232, 176, 190), (150, 70, 96), "diamonds", (246, 214, 220)),
    "wall_aqua_tiles": ((120, 206, 206), (20, 90, 110), "tiles", (236, 250, 250)),
    "wall_navy_tiles": ((44, 84, 150), (230, 240, 245), "tiles", (190, 214, 236)),
    "wall_mint_band": ((206, 240, 228), (20, 90, 110), "band", (20, 130, 140)),
    "wall_white_tiles": ((236, 240, 240), (20, 90, 110), "tiles", (120, 170, 176)),
    "wall_forest": ((78, 120, 80), (232, 220, 190), "plain", (0, 0, 0)),
    "wall_green_panels": ((140, 176, 120), (60, 44, 30), "dado", (96, 60, 36)),
    "wall_sage": ((190, 208, 170), (60, 44, 30), "plain", (0, 0, 0)),
    "wall_moss_diamonds": ((160, 186, 110), (60, 44, 30), "diamonds", (206, 220, 160)),
    "wall_grey": ((206, 206, 204), (70, 74, 82), "plain", (0, 0, 0)),
    "wall_grey_band": ((212, 208, 200), (190, 40, 40), "band", (214, 60, 50)),
    "wall_slate_stripes": ((120, 132, 150), (240, 200, 60), "stripes", (150, 162, 180)),
    "wall_mustard": ((214, 168, 56), (70, 74, 82), "plain", (0, 0, 0)),
    "wall_teal_tiles": ((40, 140, 130), (240, 240, 230), "tiles", (220, 240, 230)),
    "wall_peach": ((250, 206, 170), (40, 110, 100), "plain", (0, 0, 0)),
    "wall_mint_stripes": ((170, 222, 190), (200, 80, 60), "stripes", (226, 244, 226)),
    "wall_sky": ((150, 200, 232), (40, 110, 100), "plain", (0, 0, 0)),
}


def noise(image: Picture, name: str, strength: float) -> Picture:
    """Adds grain of `strength` grey levels to a picture (H, W, 3)."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    grain: NDArray[np.float64] = rng.normal(0.0, strength, image.shape[:2])[..., None]
    return np.clip(image + grain, 0, 255).astype(np.uint8)


def wall(name: str) -> Picture:
    """One wall from floor to top, (256, 128, 3): pattern, then the skirting board."""
    colour, skirting, pattern, accent = WALLS[name]
    image = blank(colour, WALL_WIDTH_PX, WALL_HEIGHT_PX)
    draw_pattern(image, pattern, accent)
    image = noise(image, name, 3.0)
    image[-14:] = skirting
    image[-16:-14] = np.array(skirting) // 2
    return image


def draw_pattern(image: Picture, pattern: str, accent: Rgb) -> None:
    """Draws one wallpaper pattern onto a wall (256, 128, 3), tileable from left to right."""
    h, w = image.shape[:2]
    if pattern == "stripes":
        for x in range(0, w, 32):
            image[:, x : x + 14] = accent
    elif pattern == "dado":
        image[150:] = accent
        image[146:152] = np.array(accent) // 2
        image[156:236, 6:8] = np.array(accent) * 3 // 4
        image[156:236, 118:120] = np.array(accent) * 3 // 4
    elif pattern == "band":
        image[186:212] = accent
        image[178:182] = accent
    elif pattern == "bricks":
        for row, y in enumerate(range(0, h, 16)):
            image[y : y + 2] = accent
            image[y : y + 16, 16 * (row % 2) :: 32] = accent
    elif pattern == "tiles":
        image[::32] = image[1::32] = accent
        image[:, ::32] = image[:, 1::32] = accent
    elif pattern == "checks":
        for row, y in enumerate(range(160, h, 16)):
            for x in range(16 * (row % 2), w, 32):
                image[y : y + 16, x : x + 16] = accent
    elif pattern == "dots":
        for row, y in enumerate(range(16, h, 32)):
            for x in range(16 + 16 * (row % 2), w, 32):
                cv2.circle(image, (x, y), 6, accent, -1)
    elif pattern == "diamonds":
        for y in range(0, h + 1, 64):
            for x in range(0, w + 1, 64):
                points = np.array([[x, y - 28], [x + 28, y], [x, y + 28], [x - 28, y]])
                cv2.polylines(image, [points], True, accent, 4)


def planks(name: str, colour: Rgb, rows: int) -> Picture:
    """A floor of planks running left to right, joints shifted from row to row."""
    image, height = blank(colour, 128, 128), 128 // rows
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    for row in range(rows):
        shade = rng.uniform(0.82, 1.08)
        y = row * height
        image[y : y + height] = np.clip(np.array(colour) * shade, 0, 255)
        image[y : y + 2] = np.array(colour) // 2
        image[y : y + height, int(rng.integers(0, 126)) :][:, :2] = np.array(colour) // 2
    return noise(image, name, 4.0)


def chequered(name: str, first: Rgb, second: Rgb, tiles: int, grout: Rgb) -> Picture:
    """A floor of square tiles in two colours, `tiles` along a side."""
    image, size = blank(first, 128, 128), 128 // tiles
    for row in range(tiles):
        for col in range(tiles):
            if (row + col) % 2:
                image[row * size : (row + 1) * size, col * size : (col + 1) * size] = second
    image[::size] = grout
    image[:, ::size] = grout
    return noise(image, name, 3.0)


def herringbone(name: str, colour: Rgb) -> Picture:
    """A dark floor of slanting strips."""
    image = blank(colour, 128, 128)
    y, x = np.mgrid[0:128, 0:128]
    slant = np.where((x // 32) % 2 == 0, x + y, y - x) % 32
    image[slant < 3] = np.array(colour) // 2
    image[(slant > 16)] = np.array(colour) * 9 // 8
    return noise(image, name, 3.0)


def rug(name: str, colour: Rgb, border: Rgb, accent: Rgb, rings: bool) -> Picture:
    """A rug with a border and rings or lozenges in it, 128 px square."""
    image = blank(border, 128, 128)
    image[10:118, 10:118] = colour
    for size in (46, 30, 14):
        ink = accent if size != 30 else border
        if rings:
            cv2.circle(image, (64, 64), size, ink, -1)
        else:
            cv2.fillConvexPoly(
                image, np.array([[64 - size, 64], [64, 64 - size], [64 + size, 64], [64, 64 + size]]), ink
            )
    return noise(image, name, 6.0)


def quilt(name: str, colours: tuple[Rgb, ...]) -> Picture:
    """A patchwork of squares."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    image = blank(colours[0], 128, 128)
    for y in range(0, 128, 32):
        for x in range(0, 128, 32):
            image[y : y + 30, x : x + 30] = colours[int(rng.integers(len(colours)))]
    return noise(image, name, 5.0)


def books(name: str, wood: Rgb, shelves: int) -> Picture:
    """A bookcase front: rows of coloured spines, (128, 256, 3)."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    image, height = blank(wood, 256, 128), 128 // shelves
    for shelf in range(shelves):
        x, bottom = 6, (shelf + 1) * height - 4
        image[shelf * height + 4 : bottom, 6:250] = np.array(wood) // 3
        while x < 238:
            width, tall = int(rng.integers(6, 13)), int(height * rng.uniform(0.6, 0.85))
            hsv = np.array([[[rng.integers(180), rng.integers(120, 255), rng.integers(120, 255)]]], dtype=np.uint8)
            colour = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)
            if rng.random() < 0.9:
                image[bottom - tall : bottom, x : x + width - 1] = colour[0, 0]
            x += width
    return image


def doors(colour: Rgb, columns: int, rows: int, knob: Rgb) -> Picture:
    """A cupboard front of doors or drawers with knobs, (128, 128, 3)."""
    image = blank(colour, 128, 128)
    w, h = 128 // columns, 128 // rows
    dark = tuple(int(c * 0.6) for c in colour)
    for row in range(rows):
        for col in range(columns):
            x, y = col * w, row * h
            cv2.rectangle(image, (x + 1, y + 1), (x + w - 2, y + h - 2), dark, 3)
            at = (x + w // 2, y + h // 4) if rows > columns else (x + (w - 12 if col % 2 == 0 else 12), y + h // 2)
            cv2.circle(image, at, 5, knob, -1)
    return image


def stove() -> Picture:
    """An oven front: knobs above, a dark glowing window below."""
    image = blank((214, 214, 218), 128, 128)
    image[4:28, 4:124] = (60, 60, 66)
    for x in range(18, 124, 23):
        cv2.circle(image, (x, 16), 7, (230, 60, 40), -1)
    cv2.rectangle(image, (12, 44), (116, 112), (24, 24, 28), -1)
    cv2.rectangle(image, (24, 60), (104, 104), (250, 140, 30), -1)
    cv2.rectangle(image, (24, 82), (104, 86), (60, 30, 10), -1)
    image[34:39, 12:116] = (120, 120, 128)
    return image


def hob() -> Picture:
    """The top of a stove: four rings."""
    image = blank((30, 30, 34), 128, 128)
    for at, radius in (((36, 36), 22), ((92, 36), 16), ((36, 92), 16), ((92, 92), 24)):
        cv2.circle(image, at, radius, (200, 50, 30), 4)
    return image


def fridge(colour: Rgb) -> Picture:
    """A fridge front: two doors, handles and notes on it."""
    image = blank(colour, 128, 256)
    image[88:92] = (60, 60, 66)
    image[30:80, 10:15] = image[100:170, 10:15] = (70, 74, 80)
    for x, y, ink in (
        (60, 30, (250, 220, 60)),
        (86, 50, (240, 90, 110)),
        (56, 120, (90, 200, 110)),
        (84, 140, (80, 140, 240)),
    ):
        cv2.rectangle(image, (x, y), (x + 20, y + 22), ink, -1)
    return image


def window(sky: Rgb, land: Rgb, kind: str) -> Picture:
    """A window with a white frame: hills, a city or the sea outside, 128 px square."""
    image = blank(sky, 128, 128)
    if kind == "hills":
        cv2.circle(image, (30, 104), 44, land, -1)
        cv2.circle(image, (100, 118), 50, tuple(c * 3 // 4 for c in land), -1)
        cv2.circle(image, (96, 30), 12, (255, 240, 120), -1)
    elif kind == "city":
        for x, top in ((8, 60), (30, 84), (48, 40), (74, 70), (96, 52)):
            cv2.rectangle(image, (x, top), (x + 20, 128), land, -1)
            for y in range(top + 6, 124, 12):
                image[y : y + 5, x + 4 : x + 8] = image[y : y + 5, x + 12 : x + 16] = (255, 230, 120)
    else:
        image[80:] = land
        cv2.fillConvexPoly(image, np.array([[60, 30], [60, 82], [96, 82]]), (250, 250, 250))
        cv2.rectangle(image, (46, 84), (100, 94), (180, 50, 40), -1)
    cv2.rectangle(image, (0, 0), (127, 127), (250, 250, 250), 14)
    image[:, 61:67] = (250, 250, 250)
    image[60:65] = (250, 250, 250)
    return image


def screen(kind: str) -> Picture:
    """What a television or a monitor shows, 128 px square with a black rim."""
    image = blank((16, 30, 60), 128, 128)
    if kind == "tv":
        image[70:] = (30, 130, 50)
        cv2.circle(image, (46, 80), 14, (240, 240, 240), -1)
        cv2.rectangle(image, (80, 34), (100, 100), (220, 40, 40), -1)
        cv2.circle(image, (90, 26), 10, (250, 200, 160), -1)
    else:
        for row, length in enumerate((50, 80, 64, 30, 90, 72, 44, 60)):
            image[14 + row * 13 : 20 + row * 13, 14 + 8 * (row % 3) :][:, :length] = (
                (90, 230, 120),
                (240, 190, 70),
                (110, 180, 250),
            )[row % 3]
    cv2.rectangle(image, (0, 0), (127, 127), (10, 10, 12), 12)
    return image


def front_door() -> Picture:
    """The front door from inside: red, four panels, a brass knob and a peephole."""
    image = blank((150, 30, 34), 128, 256)
    for x, y, h in ((16, 16, 96), (70, 16, 96), (16, 140, 96), (70, 140, 96)):
        cv2.rectangle(image, (x, y), (x + 42, y + h), (96, 14, 20), 5)
    cv2.circle(image, (112, 128), 9, (240, 200, 80), -1)
    cv2.circle(image, (64, 60), 5, (240, 240, 240), -1)
    cv2.rectangle(image, (0, 0), (127, 255), (60, 10, 14), 6)
    return image


def washer() -> Picture:
    """A washing machine front."""
    image = blank((240, 240, 244), 128, 128)
    image[6:26, 8:120] = (170, 176, 190)
    cv2.circle(image, (64, 76), 42, (90, 96, 110), -1)
    cv2.circle(image, (64, 76), 32, (40, 110, 190), -1)
    cv2.ellipse(image, (64, 86), (26, 14), 0, 0, 360, (230, 120, 160), -1)
    return image


def mirror() -> Picture:
    """A mirror: pale blue with slanting lights and a brass frame."""
    image = blank((176, 206, 224), 128, 128)
    for x in (-10, 40):
        cv2.fillConvexPoly(image, np.array([[x + 30, 0], [x + 60, 0], [x + 20, 128], [x - 10, 128]]), (216, 234, 244))
    cv2.rectangle(image, (0, 0), (127, 127), (196, 150, 60), 12)
    return image


def bands(colours: tuple[Rgb, ...], count: int, upright: bool) -> Picture:
    """Stripes in turn, upright (a curtain, a piano's keys) or lying (towels)."""
    image = blank(colours[0], 128, 128)
    for i in range(count):
        part = slice(i * 128 // count, (i + 1) * 128 // count)
        if upright:
            image[:, part] = colours[i % len(colours)]
        else:
            image[part] = colours[i % len(colours)]
    return image


def foliage(name: str, colour: Rgb) -> Picture:
    """Leaves: slanting strokes in greens."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    image = blank(tuple(c // 2 for c in colour), 64, 64)
    for _ in range(90):
        x, y, dx, shade = *rng.integers(0, 64, 2), rng.integers(-8, 9), rng.uniform(0.6, 1.2)
        cv2.line(image, (int(x), int(y)), (int(x + dx), int(y) - 10), [int(min(255, c * shade)) for c in colour], 2)
    return image


FURNISHINGS: dict[str, Callable[[], Picture]] = {
    "floor_oak": lambda: planks("floor_oak", (190, 134, 80), 8),
    "floor_walnut": lambda: herringbone("floor_walnut", (104, 66, 42)),
    "floor_kitchen": lambda: chequered("floor_kitchen", (240, 232, 214), (190, 96, 70), 2, (150, 140, 130)),
    "floor_bath": lambda: chequered("floor_bath", (150, 214, 220), (226, 244, 246), 8, (110, 170, 180)),
    "floor_carpet": lambda: noise(blank((112, 118, 168), 128, 128), "floor_carpet", 10.0),
    "floor_hall": lambda: chequered("floor_hall", (150, 148, 142), (136, 136, 132), 2, (90, 90, 88)),
    "floor_blue": lambda: chequered("floor_blue", (60, 90, 140), (236, 236, 226), 4, (120, 120, 120)),
    "rug_red": lambda: rug("rug_red", (160, 30, 40), (240, 200, 120), (30, 50, 110), False),
    "rug_round": lambda: rug("rug_round", (30, 130, 140), (250, 240, 210), (240, 150, 40), True),
    "rug_runner": lambda: bands(((30, 110, 90), (230, 200, 90), (30, 110, 90), (190, 60, 50)), 16, True),
    "rug_pink": lambda: rug("rug_pink", (240, 160, 190), (150, 60, 120), (250, 230, 120), True),
    "rug_green": lambda: rug("rug_green", (70, 110, 50), (220, 210, 150), (180, 90, 40), False),
    "quilt": lambda: quilt("quilt", ((200, 50, 80), (250, 200, 80), (60, 110, 190), (240, 240, 230), (90, 170, 120))),
    "wood": lambda: planks("wood", (176, 120, 70), 4),
    "books_many": lambda: books("books_many", (110, 64, 34), 5),
    "books_office": lambda: books("books_office", (60, 66, 76), 4),
    "books_low": lambda: books("books_low", (240, 236, 226), 3),
    "doors_teal": lambda: doors((40, 130, 130), 2, 1, (240, 220, 120)),
    "doors_white": lambda: doors((240, 236, 226), 2, 1, (60, 60, 60)),
    "doors_walnut": lambda: doors((120, 74, 44), 3, 1, (230, 200, 120)),
    "doors_pine": lambda: doors((222, 170, 100), 2, 1, (90, 50, 20)),
    "doors_blue": lambda: doors((60, 90, 170), 2, 1, (250, 250, 250)),
    "drawers_red": lambda: doors((190, 50, 50), 1, 3, (250, 240, 200)),
    "drawers_yellow": lambda: doors((240, 190, 50), 1, 3, (70, 50, 20)),
    "drawers_grey": lambda: doors((140, 150, 160), 1, 3, (30, 30, 34)),
    "stove": stove,
    "hob": hob,
    "fridge_mint": lambda: fridge((170, 220, 200)),
    "fridge_red": lambda: fridge((200, 50, 50)),
    "window_hills": lambda: window((140, 200, 250), (70, 150, 60), "hills"),
    "window_city": lambda: window((240, 180, 130), (90, 80, 110), "city"),
    "window_sea": lambda: window((170, 220, 250), (30, 90, 160), "sea"),
    "screen_tv": lambda: screen("tv"),
    "screen_code": lambda: screen("code"),
    "front_door": front_door,
    "washer": washer,
    "mirror": mirror,
    "curtain": lambda: bands(((240, 90, 110), (250, 240, 230), (250, 180, 60), (250, 240, 230)), 12, True),
    "towels": lambda: bands((LINEN, (40, 110, 170), LINEN, (230, 120, 50), LINEN, (60, 150, 90)), 6, False),
    "piano": lambda: bands(((250, 250, 245), (20, 20, 20), (250, 250, 245)), 21, True),
    "leaves": lambda: foliage("leaves", (70, 170, 60)),
    "leaves_blue": lambda: foliage("leaves_blue", (60, 150, 130)),
}  # fmt: skip


def squared(image: Picture) -> Picture:
    """Stretches a picture to a square, as the faces of a cube texture must be."""
    side = max(image.shape[:2])
    return np.asarray(cv2.resize(image, (side, side), interpolation=cv2.INTER_NEAREST), dtype=np.uint8)


def main() -> None:
    """Writes all textures into scenes/textures."""
    FOLDER.mkdir(exist_ok=True)
    pictures = {name: wall(name) for name in WALLS}
    pictures |= {name: squared(draw()) for name, draw in FURNISHINGS.items()}
    pictures |= {f"painting_{name}": draw() for name, draw in PAINTINGS.items()}
    for name, picture in pictures.items():
        cv2.imwrite(str(FOLDER / f"{name}.png"), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))


if __name__ == "__main__":
    main()
