"""The paintings on the walls: each differs from the others in hue and in structure. RGB, 128 px square."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Rgb = tuple[int, ...]

SIZE_PX = 128


def blank(colour: Rgb, width: int = SIZE_PX, height: int = SIZE_PX) -> Picture:
    """A picture (height, width, 3) of one colour."""
    return np.full((height, width, 3), colour, dtype=np.uint8)


def framed(image: Picture, colour: Rgb) -> Picture:
    """Puts a frame of 9 px around a painting."""
    cv2.rectangle(image, (0, 0), (127, 127), colour, 17)
    return image


def polygon(image: Picture, points: list[tuple[int, int]], colour: Rgb) -> None:
    """Fills a polygon."""
    cv2.fillPoly(image, [np.array(points)], colour)


def sunset() -> Picture:
    """The sun over a violet sea."""
    image = blank((250, 140, 40))
    image[:40] = (200, 50, 60)
    cv2.circle(image, (64, 76), 26, (255, 230, 90), -1)
    image[80:] = (70, 20, 80)
    return framed(image, (60, 30, 20))


def mountains() -> Picture:
    """Two grey peaks."""
    image = blank((160, 210, 250))
    polygon(image, [(0, 128), (44, 30), (90, 128)], (80, 90, 120))
    polygon(image, [(50, 128), (96, 50), (128, 128)], (50, 60, 90))
    polygon(image, [(32, 56), (44, 30), (56, 56)], (255, 255, 255))
    return framed(image, (230, 230, 220))


def moon() -> Picture:
    """A crescent and stars."""
    image = blank((16, 20, 70))
    cv2.circle(image, (80, 46), 24, (250, 250, 200), -1)
    cv2.circle(image, (92, 40), 20, (16, 20, 70), -1)
    for x, y in ((24, 30), (40, 90), (100, 96), (60, 104), (28, 64)):
        cv2.circle(image, (x, y), 3, (255, 255, 255), -1)
    return framed(image, (210, 180, 60))


def blocks() -> Picture:
    """Red, blue and yellow fields."""
    image = blank((245, 245, 240))
    image[8:60, 8:50] = (220, 20, 30)
    image[70:120, 60:120] = (20, 60, 180)
    image[8:40, 90:120] = (250, 220, 20)
    image[62:68] = image[:, 52:58] = image[42:46, 58:] = (10, 10, 10)
    return framed(image, (10, 10, 10))


def rings() -> Picture:
    """Red rings."""
    image = blank((250, 250, 250))
    for i, radius in enumerate(range(54, 5, -10)):
        cv2.circle(image, (64, 64), radius, ((230, 30, 40), (255, 255, 255))[i % 2], -1)
    return framed(image, (40, 40, 40))


def waves() -> Picture:
    """Blue waves."""
    y, x = np.mgrid[0:128, 0:128]
    crest = np.sin((y + 9 * np.sin(x / 11.0)) / 6.0) > 0
    return framed(np.where(crest[..., None], (20, 110, 200), (190, 240, 250)).astype(np.uint8), (240, 240, 240))


def tree() -> Picture:
    """An apple tree."""
    image = blank((250, 230, 160))
    image[100:] = (120, 170, 60)
    cv2.rectangle(image, (58, 60), (70, 104), (90, 50, 20), -1)
    cv2.circle(image, (64, 48), 32, (30, 120, 40), -1)
    for x, y in ((50, 40), (74, 36), (64, 60), (84, 54), (46, 58)):
        cv2.circle(image, (x, y), 5, (230, 30, 30), -1)
    return framed(image, (120, 70, 30))


def portrait() -> Picture:
    """A head and shoulders."""
    image = blank((30, 70, 50))
    cv2.ellipse(image, (64, 120), (44, 34), 0, 0, 360, (130, 20, 40), -1)
    cv2.ellipse(image, (64, 60), (24, 30), 0, 0, 360, (240, 200, 160), -1)
    cv2.ellipse(image, (64, 40), (28, 18), 0, 180, 360, (60, 30, 10), -1)
    for x in (54, 74):
        cv2.circle(image, (x, 58), 4, (20, 20, 20), -1)
    return framed(image, (200, 160, 60))


def flower() -> Picture:
    """A magenta flower."""
    image = blank((250, 200, 220))
    cv2.line(image, (64, 64), (64, 122), (30, 120, 30), 6)
    for angle in np.arange(0, 360, 60):
        at = (int(64 + 24 * np.cos(np.radians(angle))), int(56 + 24 * np.sin(np.radians(angle))))
        cv2.circle(image, at, 15, (210, 20, 120), -1)
    cv2.circle(image, (64, 56), 13, (250, 220, 30), -1)
    return framed(image, (110, 20, 80))


def boat() -> Picture:
    """A sailing boat."""
    image = blank((200, 230, 250))
    image[84:] = (20, 120, 130)
    polygon(image, [(28, 80), (100, 80), (86, 100), (42, 100)], (170, 70, 20))
    polygon(image, [(62, 22), (62, 76), (98, 76)], (250, 250, 240))
    polygon(image, [(56, 30), (56, 76), (34, 76)], (230, 60, 50))
    return framed(image, (20, 40, 80))


def city() -> Picture:
    """Towers at night."""
    image = blank((60, 20, 90))
    for x, top, ink in ((10, 60, (20, 20, 40)), (34, 34, (40, 30, 70)), (62, 70, (20, 20, 40)), (84, 46, (30, 20, 60))):
        cv2.rectangle(image, (x, top), (x + 24, 128), ink, -1)
        for y in range(top + 6, 120, 14):
            image[y : y + 6, x + 5 : x + 10] = image[y : y + 6, x + 14 : x + 19] = (255, 220, 80)
    return framed(image, (150, 150, 160))


def fish() -> Picture:
    """An orange fish."""
    image = blank((20, 160, 170))
    cv2.ellipse(image, (56, 64), (34, 20), 0, 0, 360, (255, 140, 20), -1)
    polygon(image, [(84, 64), (112, 42), (112, 86)], (255, 140, 20))
    image[48:81, 50:57] = (255, 255, 255)
    cv2.circle(image, (36, 58), 5, (10, 10, 10), -1)
    return framed(image, (250, 250, 230))


def heart() -> Picture:
    """A red heart."""
    image = blank((255, 240, 200))
    for x in (47, 81):
        cv2.circle(image, (x, 50), 20, (220, 20, 50), -1)
    polygon(image, [(29, 59), (99, 59), (64, 106)], (220, 20, 50))
    return framed(image, (220, 120, 130))


def rainbow() -> Picture:
    """A rainbow."""
    image = blank((220, 240, 255))
    inks = ((230, 30, 30), (250, 140, 20), (250, 230, 40), (40, 170, 60), (40, 80, 210), (130, 40, 160))
    for i, ink in enumerate(inks):
        cv2.circle(image, (64, 108), 62 - 8 * i, ink, -1)
    cv2.circle(image, (64, 108), 14, (220, 240, 255), -1)
    return framed(image, (120, 200, 90))


def chess() -> Picture:
    """A chequered field."""
    image = blank((240, 220, 180))
    for row in range(6):
        for col in range(row % 2, 6, 2):
            image[10 + row * 18 : 28 + row * 18, 10 + col * 18 : 28 + col * 18] = (30, 20, 20)
    return framed(image, (150, 20, 20))


def triangles() -> Picture:
    """Rows of triangles."""
    image = blank((250, 240, 220))
    inks = ((240, 80, 50), (40, 160, 160), (250, 190, 40), (90, 60, 150))
    for row in range(3):
        for col in range(4):
            x, y = 6 + col * 30, 10 + row * 38
            polygon(image, [(x, y + 36), (x + 15, y), (x + 30, y + 36)], inks[(row * 2 + col) % 4])
    return framed(image, (60, 60, 60))


def spiral() -> Picture:
    """A violet spiral."""
    y, x = np.mgrid[-64:64, -64:64]
    arm = np.sin(np.hypot(x, y) / 5.0 + 2.0 * np.arctan2(y, x)) > 0
    return framed(np.where(arm[..., None], (110, 30, 150), (240, 210, 60)).astype(np.uint8), (60, 10, 90))


def desert() -> Picture:
    """A cactus."""
    image = blank((250, 210, 150))
    image[84:] = (220, 150, 60)
    cv2.rectangle(image, (56, 34), (70, 100), (40, 130, 60), -1)
    cv2.rectangle(image, (34, 50), (44, 72), (40, 130, 60), -1)
    cv2.rectangle(image, (34, 66), (58, 76), (40, 130, 60), -1)
    cv2.rectangle(image, (82, 44), (92, 80), (40, 130, 60), -1)
    cv2.rectangle(image, (68, 74), (92, 84), (40, 130, 60), -1)
    return framed(image, (170, 80, 40))


def strokes() -> Picture:
    """Slanting strokes."""
    image = blank((250, 250, 250))
    for i, ink in enumerate(((230, 40, 40), (30, 30, 30), (30, 150, 90), (30, 90, 220), (240, 170, 20))):
        cv2.line(image, (-10 + 30 * i, 128), (40 + 30 * i, 0), ink, 13)
    return framed(image, (20, 90, 60))


def crosses() -> Picture:
    """Four crosses."""
    image = blank((30, 60, 130))
    for x, y, ink in (
        (36, 36, (250, 250, 250)),
        (92, 40, (250, 120, 160)),
        (40, 92, (120, 240, 180)),
        (90, 92, (250, 230, 60)),
    ):
        image[y - 18 : y + 19, x - 6 : x + 7] = image[y - 6 : y + 7, x - 18 : x + 19] = ink
    return framed(image, (240, 240, 240))


def world_map() -> Picture:
    """Six continents."""
    image = blank((90, 170, 220))
    for at, axes in (
        ((34, 46), (18, 14)),
        ((44, 88), (9, 18)),
        ((72, 40), (14, 10)),
        ((74, 74), (13, 20)),
        ((98, 46), (20, 16)),
        ((104, 92), (10, 8)),
    ):
        cv2.ellipse(image, at, axes, 0, 0, 360, (230, 200, 120), -1)
    return framed(image, (110, 60, 30))


def pear() -> Picture:
    """A green pear."""
    image = blank((120, 40, 60))
    cv2.circle(image, (64, 80), 28, (190, 220, 60), -1)
    cv2.ellipse(image, (64, 50), (15, 24), 0, 0, 360, (190, 220, 60), -1)
    cv2.line(image, (64, 28), (72, 16), (60, 40, 20), 5)
    return framed(image, (240, 220, 190))


PAINTINGS: dict[str, Callable[[], Picture]] = {
    "sunset": sunset, "mountains": mountains, "moon": moon, "blocks": blocks, "rings": rings, "waves": waves,
    "tree": tree, "portrait": portrait, "flower": flower, "boat": boat, "city": city, "fish": fish, "heart": heart,
    "rainbow": rainbow, "chess": chess, "triangles": triangles, "spiral": spiral, "desert": desert,
    "strokes": strokes, "crosses": crosses, "world_map": world_map, "pear": pear,
}  # fmt: skip
