"""Reading recordings back in tests: chunks by entity, and one component's values in the order of the file."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader

from twonav_cli import events
from twonav_cli.recording.recorder import Recorder


def record(path: Path, kind: str, sent: Iterable[events.Event]) -> Path:
    """Record events and close the file."""
    with Recorder(path, kind) as recorder:
        for event in sent:
            recorder(event)
    return path


def batches_of(path: Path) -> dict[str, list[Any]]:
    """Return the chunks of every entity."""
    found = defaultdict(list)
    for chunk in RrdReader(str(path)).stream():
        found[chunk.entity_path].append(chunk)
    return found


def column(chunks: list[Any], name: str, *, static: bool = False) -> list[Any]:
    """Return the values of a component or timeline."""
    batches = [chunk.to_record_batch() for chunk in chunks if chunk.is_static == static]
    return [value for batch in batches if name in batch.schema.names for value in batch[name].to_pylist()]


def pictures(chunks: list[Any], shape: tuple[int, int]) -> dict[int, np.ndarray]:
    """Return the segmentation images [R, C] of an entity by trial."""
    buffers, trials = column(chunks, "SegmentationImage:buffer"), column(chunks, "trial")
    return {t: np.array(b[0], dtype=np.uint8).reshape(shape) for t, b in zip(trials, buffers, strict=True)}
