"""Furniture made of boxes, cylinders and balls. Every piece fills the rectangle it is given down to the floor."""

from furniture import OPPOSITE, Rect, Scene


def sofa(scene: Scene, name: str, rect: Rect, facing: str, colour: str, arms: str) -> None:
    """A seat, a back at the side away from `facing`, and two arm rests."""
    left, right = ("W", "E") if facing in "NS" else ("S", "N")
    scene.box(f"{name}_seat", rect.shrunk(0.01, 0.01), 0.0, 0.42, colour)
    scene.box(f"{name}_back", rect.edge(OPPOSITE[facing], 0.22), 0.42, 0.85, arms)
    scene.box(f"{name}_arm_1", rect.edge(left, 0.16), 0.0, 0.6, arms)
    scene.box(f"{name}_arm_2", rect.edge(right, 0.16), 0.0, 0.6, arms)


def bed(scene: Scene, name: str, rect: Rect, facing: str, wood: str) -> None:
    """A bed whose foot end faces `facing`: frame, quilt, headboard and two pillows."""
    head = OPPOSITE[facing]
    scene.box(f"{name}_frame", rect, 0.0, 0.3, wood)
    scene.box(f"{name}_quilt", rect.shrunk(0.03, 0.03), 0.3, 0.5, "quilt")
    scene.box(f"{name}_headboard", rect.edge(head, 0.08), 0.3, 1.05, wood)
    pillows = rect.edge(head, 0.5).shrunk(0.1, 0.12)
    middle = (pillows.y0 + pillows.y1) / 2
    scene.box(f"{name}_pillow_1", pillows._replace(y1=middle - 0.05), 0.5, 0.62, "#fafaf5")
    scene.box(f"{name}_pillow_2", pillows._replace(y0=middle + 0.05), 0.5, 0.62, "#ffd9e6")


def chair(scene: Scene, name: str, rect: Rect, facing: str, colour: str) -> None:
    """A chair: a block to sit on and a back at the side away from `facing`."""
    scene.box(f"{name}_seat", rect, 0.0, 0.46, colour)
    scene.box(f"{name}_back", rect.edge(OPPOSITE[facing], 0.06), 0.46, 0.95, colour)


def table(scene: Scene, name: str, rect: Rect, height: float, top: str, foot: str, inset: float = 0.2) -> None:
    """A table on one broad foot."""
    scene.box(f"{name}_top", rect, height - 0.05, height, top)
    scene.box(f"{name}_foot", rect.shrunk(inset, inset), 0.0, height - 0.05, foot)


def counter(scene: Scene, name: str, rect: Rect, facing: str, fronts: tuple[str, ...], top: str) -> None:
    """A run of cupboards 0.9 m high, with equally wide fronts under one worktop."""
    across = facing in "NS"
    start, end = (rect.x0, rect.x1) if across else (rect.y0, rect.y1)
    width = (end - start) / len(fronts)
    for number, front in enumerate(fronts, 1):
        first, last = start + (number - 1) * width, start + number * width
        part = rect._replace(x0=first, x1=last) if across else rect._replace(y0=first, y1=last)
        scene.box(f"{name}_{number}", part, 0.0, 0.86, front, facing)
    scene.box(f"{name}_top", rect, 0.86, 0.9, top)


def plant(scene: Scene, name: str, x: float, y: float, pot: str, leaves: str, height: float) -> None:
    """A pot of 0.4 m with a crown of leaves."""
    scene.cylinder(f"{name}_pot", x, y, 0.0, 0.5, 0.18, pot)
    scene.ball(f"{name}_leaves", x, y, 0.46 + height / 2, 0.2, height / 2, leaves)


def lamp(scene: Scene, name: str, x: float, y: float, shade: str) -> None:
    """A floor lamp."""
    scene.cylinder(f"{name}_base", x, y, 0.0, 0.06, 0.14, "#303034")
    scene.cylinder(f"{name}_pole", x, y, 0.06, 1.3, 0.03, "#303034")
    scene.cylinder(f"{name}_shade", x, y, 1.3, 1.65, 0.2, shade)


def toilet(scene: Scene, name: str, rect: Rect, facing: str) -> None:
    """A toilet with its tank at the side away from `facing`."""
    tank = rect.edge(OPPOSITE[facing], 0.22)
    scene.box(f"{name}_bowl", rect.shrunk(0.04, 0.0), 0.0, 0.38, "#f4f4f2")
    scene.box(f"{name}_lid", rect.shrunk(0.02, 0.0), 0.38, 0.43, "#d98a3a")
    scene.box(f"{name}_tank", tank, 0.43, 0.85, "#f4f4f2")


def bathtub(scene: Scene, name: str, rect: Rect, outside: str) -> None:
    """A full bathtub."""
    scene.box(f"{name}_tub", rect, 0.0, 0.56, outside)
    scene.box(f"{name}_rim", rect, 0.56, 0.6, "#ffffff")
    scene.box(f"{name}_water", rect.shrunk(0.08, 0.08), 0.6, 0.605, "#58b8e8", "", False)


def armchair(scene: Scene, name: str, rect: Rect, facing: str, colour: str, cushion: str) -> None:
    """A deep chair: one block, a back and a cushion."""
    scene.box(f"{name}_seat", rect, 0.0, 0.44, colour)
    scene.box(f"{name}_back", rect.edge(OPPOSITE[facing], 0.2), 0.44, 1.0, colour)
    scene.box(f"{name}_cushion", rect.shrunk(0.2, 0.2), 0.44, 0.56, cushion)
