"""What a scene's XML says before MuJoCo reads it: the files it names, and what would hang or crash MuJoCo."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from twonav_cli.errors import TwonavError
from twonav_cli.files import digest_of

MAX_XML_BYTES = 64_000_000
MAX_ELEMENTS = 60_000
"""MuJoCo's reader is quadratic: 200 000 geoms took 147 s."""

MAX_COPIES = 20_000
"""Most copies that replicate elements inside each other may make."""

MAX_TEXTURE_PX = 8192
MAX_KEYFRAMES = 1000
PNG_START = b"\x89PNG\r\n\x1a\n"
TEXT_SUFFIXES = {".xml", ".mjcf", ".obj"}
SIDES = ("fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
MESH_TAGS = {"mesh", "flexcomp", "skin"}


@dataclass(frozen=True)
class XmlPart:
    """One XML file of a scene.

    Attributes:
        path: Where it is.
        root: Its parsed content.
        chain: The models it is attached or included through, itself last.
    """

    path: Path
    root: ET.Element
    chain: tuple[Path, ...]


def digest_of_scene(xml_path: Path) -> str:
    """Return the digest of a scene: its XML and every file that is named in it, the same for any line endings.

    Raises:
        TwonavError: A file is missing, not XML, too large, or would hang MuJoCo.
    """
    parts = list(xml_parts(xml_path))
    named = {path for part in parts for path in _files_named(part, parts[0])}
    others = sorted(named, key=lambda path: (path.name, path.as_posix()))
    contents = [_content(part.path) for part in parts] + [_content(path) for path in others]
    return digest_of(contents)


def xml_parts(xml_path: Path) -> Iterator[XmlPart]:
    """Yield the scene's XML and every XML it includes or attaches, each checked.

    Raises:
        TwonavError: As `digest_of_scene`.
    """
    waiting: list[tuple[Path, tuple[Path, ...]]] = [(xml_path, (xml_path.resolve(),))]
    while waiting:
        path, chain = waiting.pop(0)
        part = XmlPart(path, _parsed(path), chain)
        if len(chain) == 1 and part.root.tag != "mujoco":
            raise TwonavError(
                f"{path} is not an MJCF scene: its root element is <{part.root.tag}>, not <mujoco>; convert it first"
            )
        _refuse_floods(part)
        yield part
        for element in part.root.iter():
            named = element.get("file")
            if element.tag not in ("include", "model") or not named:
                continue
            inner = path.parent / named
            if inner.resolve() in chain:
                raise TwonavError(f"{path} takes itself in through <{element.tag} file={named!r}>: remove that line")
            waiting.append((inner, (*chain, inner.resolve())))


def _parsed(path: Path) -> ET.Element:
    """Return the root element of an XML file."""
    if not path.is_file():
        raise TwonavError(f"{path} is missing: restore the file or correct its name in the scene")
    if path.stat().st_size > MAX_XML_BYTES:
        raise TwonavError(
            f"{path} is too large ({path.stat().st_size // 1_000_000} MB): keep meshes in files of their own"
        )
    try:
        return ET.fromstring(path.read_bytes())
    except ET.ParseError as error:
        line = error.position[0]
        raise TwonavError(
            f"{path} is not well-formed XML, line {line}: {str(error).split(':')[0]}; correct that line"
        ) from error
    except (OSError, ValueError, LookupError) as error:
        raise TwonavError(f"{path} cannot be read: {error}") from error


def _number(text: str | None) -> float:
    """Return an attribute's first number, 0 where there is none."""
    try:
        return float((text or "0").split()[0])
    except (ValueError, IndexError):
        return 0.0


def _refuse_floods(part: XmlPart) -> None:
    """Refuse what MuJoCo would work on for minutes or until the memory is full."""
    elements = sum(1 for _ in part.root.iter())
    if elements > MAX_ELEMENTS:
        raise TwonavError(f"{part.path} is too large: {elements} elements, at most {MAX_ELEMENTS}; merge or split it")
    _refuse_copies(part, part.root, 1.0)
    for size in part.root.iter("size"):
        if _number(size.get("nkey")) > MAX_KEYFRAMES:
            raise TwonavError(f"{part.path} asks for {size.get('nkey')} keyframes: remove nkey from <size>")
    for flex in part.root.iter("flexcomp"):
        points = 1.0
        for count in (flex.get("count") or "1").split():
            points *= max(1.0, _number(count))
        if points > MAX_COPIES:
            raise TwonavError(f"{part.path} has a flexcomp of {points:.0f} points: at most {MAX_COPIES}")
    for texture in part.root.iter("texture"):
        if max(_number(texture.get("width")), _number(texture.get("height"))) > MAX_TEXTURE_PX * 6:
            raise TwonavError(f"{part.path} has a texture that is too large: at most {MAX_TEXTURE_PX} pixels wide")


def _refuse_copies(part: XmlPart, element: ET.Element, copies: float) -> None:
    """Refuse replicate elements that multiply to too many copies."""
    waiting = [(element, copies)]
    while waiting:
        outer, times = waiting.pop()
        if outer.tag == "replicate":
            times *= max(1.0, _number(outer.get("count")))
        if times > MAX_COPIES:
            raise TwonavError(f"{part.path} replicates something {times:.0f} times: at most {MAX_COPIES}")
        waiting += [(inner, times) for inner in outer]


def _files_named(part: XmlPart, top: XmlPart) -> Iterator[Path]:
    """Yield the texture, mesh and height field files that an XML names; each is checked."""
    for element in part.root.iter():
        if element.tag in ("include", "model", "plugin"):
            continue
        for key in ("file", *SIDES):
            named = element.get(key)
            if named:
                places = [folder / named for folder in _folders(part, top, element.tag)]
                found = next((place for place in places if place.is_file()), places[0])
                yield _checked(found, part.path, element.tag)


def _folders(part: XmlPart, top: XmlPart, tag: str) -> Iterator[Path]:
    """Yield the folders that a file may lie in, the likeliest first: the compiler's, then the XML's own."""
    kinds = ("meshdir", "assetdir", "texturedir") if tag in MESH_TAGS else ("texturedir", "assetdir", "meshdir")
    for xml in (part, top):
        compiler = xml.root.find("compiler")
        for kind in kinds:
            folder = compiler.get(kind) if compiler is not None else None
            if folder:
                yield top.path.parent / folder
                yield xml.path.parent / folder
    yield part.path.parent
    yield top.path.parent


def _checked(path: Path, xml_path: Path, tag: str) -> Path:
    """Return the path of a file that is there and is not too large to be loaded."""
    if not path.is_file():
        raise TwonavError(f"{xml_path} names the {tag} file {path.name}, which is missing: put it at {path}")
    with path.open("rb") as file:
        start = file.read(24)
    if start.startswith(PNG_START) and len(start) == 24:
        width, height = struct.unpack(">II", start[16:24])
        if max(width, height) > MAX_TEXTURE_PX:
            raise TwonavError(
                f"{path} is too large: {width} x {height} pixels, at most {MAX_TEXTURE_PX}; scale it down"
            )
    return path


def _content(path: Path) -> bytes:
    """Return a file's content, text with line feeds only."""
    content = path.read_bytes()
    return content.replace(b"\r\n", b"\n") if path.suffix.lower() in TEXT_SUFFIXES else content
