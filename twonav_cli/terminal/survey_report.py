"""What a survey was like, in sentences."""

from __future__ import annotations

from typing import Any


def survey_sentences(metrics: dict[str, Any], scene: str) -> list[str]:
    """Return the lines that are printed after a survey.

    Args:
        metrics: As the map's card holds them.
        scene: Its name or path, as it is typed in the next command.
    """
    hidden = f"{metrics['hidden_cells']:,} cells that no beam can reach left out"
    driven, off = f"{metrics['driven_m']:.0f} m driven", f"{metrics['pose_mean_m']:.3f} m"
    return [
        f"surveyed: {metrics['keyframes']} keyframes, {driven} in {metrics['simulated_s']:.0f} simulated seconds, "
        f"{metrics['collisions']} collisions",
        f"pose beside the simulator's: off by {off} and {metrics['pose_mean_deg']:.2f} degrees on average, "
        f"at worst {metrics['pose_worst_m']:.3f} m",
        f"map beside the geometry: {100 * metrics['agreeing']:.2f} % agree within one cell ({hidden})",
        f"maze beside the geometry's: {_difference(metrics)}",
        f"next: `twonav scenes show {scene} --map`, `twonav train --stage maze --scene {scene}`",
    ]


def _difference(metrics: dict[str, Any]) -> str:
    """Return which cells of the maze differ, (row, column)."""
    parts = []
    for kind in ("blocked", "freed"):
        count, named = metrics[f"maze_cells_{kind}_by_us"], metrics[f"maze_{kind}_by_us"]
        if count:
            more = ", ..." if count > len(named) else ""
            parts.append(
                f"{count} more {'blocked' if kind == 'blocked' else 'free'}: {', '.join(map(str, named))}{more}"
            )
    return "; ".join(parts) or "the same"
