"""Which folder holds a scene's checkpoint: the one that was named, the shipped one, or one of the user's own runs."""

from __future__ import annotations

from pathlib import Path

from twonav_cli.checkpoint import CARD_FILE, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.paths import checkpoints_dir, runs_dir

OURS = "belief"
"""Our own network, as `localizer.networks` names it."""


def checkpoint_folder(
    scene: str,
    name: str,
    chosen: Path | None = None,
    own_first: bool = False,
    scene_digest: str | None = None,
    map_digest: str | None = None,
    map_source: str | None = None,
) -> Path:
    """Return the folder of a scene's checkpoint.

    Args:
        scene: Name of the scene.
        name: "maze", "2d", "3d" or "localizer".
        chosen: Folder of a scene's checkpoints that the user named; then only this one counts.
        own_first: Whether a run of the user's own goes before the shipped one (training does, playing does not).
        scene_digest: The scene it should be for: one that is for another scene of that name comes last.
        map_digest: The map it should be for: one of the same scene on another map comes after one on this.
        map_source: Where that map comes from, for the command in the message; "survey" is what training takes itself.

    Raises:
        TwonavError: There is none; the message says which command makes it.
    """
    shipped, own = checkpoints_dir() / scene / name, runs_dir() / scene / name
    candidates = [chosen / name] if chosen is not None else [own, shipped] if own_first else [shipped, own]
    found = [folder for folder in candidates if (folder / CARD_FILE).is_file()]
    if found:
        # Of several that fit equally well `max` returns the first.
        return max(found, key=lambda folder: _fit_of(folder, scene_digest, map_digest))
    where = f"in {chosen}" if chosen is not None else f"for scene {scene!r}"
    stage, _, network = name.partition("-")
    command = f"twonav train --stage {stage} --scene {scene}" + (f" --network {network}" if network else "")
    command += " --map-from geometry" if map_source == "geometry" else ""
    raise TwonavError(f"there is no {name} checkpoint {where}: make it with `{command}`")


def _fit_of(folder: Path, scene_digest: str | None, map_digest: str | None) -> int:
    """Return 2 for a checkpoint of the scene and the map, 1 for one of the scene, else 0.

    One that cannot be read is left for the loader to refuse. A localizer that says no map fits every map.
    """
    if scene_digest is None:
        return 2
    try:
        card = read_card(folder)
    except TwonavError:
        return 0
    if card.get("scene_digest") != scene_digest:
        return 0
    return 2 if map_digest is None or card.get("map_digest") in (None, map_digest) else 1


def localizer_name(network: str | None) -> str:
    """Return the checkpoint's name of a localizer: ours is "localizer", the paper's say which network they are."""
    return "localizer" if network in (None, OURS) else f"localizer-{network}"
