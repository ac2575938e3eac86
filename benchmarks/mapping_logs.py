"""Maps of real laser logs, scored against their references, with any number of particles and seeds.

    python benchmarks/mapping_logs.py FOLDER [--particles 30] [--seeds 5] [--proposal gaussian] [--memory]

FOLDER holds the two public logs (they are not shipped): fr079_flirtseq.clf.gz with fr079.relations and
fr079.relgraph.txt, mit-csail.clf.gz with mit-csail.flirt_graph.txt. One thread, time by the process's own clock;
compilation is done before it runs. A run has failed when its error after alignment (ATE) is a quarter of a metre or
more.
"""

from __future__ import annotations

import argparse
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.experiments.trajectory_errors import aligned_errors, relation_errors
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.mapping.carmen import LaserLog, read_carmen
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.scan import StampedPose

FAILED_M = 0.25
WARM_UP_READINGS = 60


class KnownLog(NamedTuple):
    """A log and what it is scored with."""

    file: str
    reference: str
    relations: str | None
    mount: Pose | None
    keyframe_distance_m: float
    """The relations of fr079 name single scans: every scan must be a keyframe to be scored."""


LOGS = {
    "fr079": KnownLog("fr079_flirtseq.clf.gz", "fr079.relgraph.txt", "fr079.relations", Pose(-0.04, 0.0, 0.0), 0.0),
    "csail": KnownLog("mit-csail.clf.gz", "mit-csail.flirt_graph.txt", None, None, 0.5),
}


def rows_of(poses: list[StampedPose]) -> FloatArray:
    """Return a trajectory [N, 4] of stamps and poses."""
    return np.array([(stamped.stamp_s, *stamped.pose) for stamped in poses])


def scores(folder: Path, known: KnownLog, trajectory: FloatArray) -> tuple[str, float]:
    """Return the errors in words, and the error after alignment."""
    found = aligned_errors(trajectory, np.loadtxt(folder / known.reference))
    text = f"pairs {found.pairs_m:.3f} m  ATE {found.position_rms_m:.3f} m"
    if known.relations:
        relations = np.loadtxt(folder / known.relations)[:, [0, 1, 2, 3, 7]]
        errors = relation_errors(trajectory, relations)
        text = f"relations {errors.translation_m:.4f} m {errors.rotation_deg:.2f} deg ({errors.used})  {text}"
    return text, found.position_rms_m


def mapped(log: LaserLog, config: MappingConfig, seed: int) -> tuple[GridMapper, float]:
    """Return the mapper after a whole log, and the seconds it took."""
    mapper = GridMapper(config, log.sensor, seed)
    begun_s = time.process_time()
    for reading in log.readings:
        mapper.add(reading)
    return mapper, time.process_time() - begun_s


def peak_mb(log: LaserLog, config: MappingConfig) -> float:
    """Return the most memory that the filter holds at a time (numpy's arrays and Python's objects)."""
    tracemalloc.start()
    mapped(log, config, 0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main() -> None:
    """Print odometry's own scores, then a line for every run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--logs", nargs="+", choices=LOGS, default=list(LOGS))
    parser.add_argument("--particles", nargs="+", type=int, default=[MappingConfig().particles])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--proposal", default="gaussian")
    parser.add_argument("--keyframe-distance", type=float, help="metres; default: 0.5, fr079 every scan")
    parser.add_argument("--keyframe-turn", type=float, help="radians", default=MappingConfig().keyframe_turn_rad)
    parser.add_argument("--memory", action="store_true", help="also measure the peak memory, in a run of its own")
    asked = parser.parse_args()
    for name in asked.logs:
        known = LOGS[name]
        log = read_carmen(asked.folder / known.file, known.mount)
        odometry = rows_of([StampedPose(r.stamp_s, r.pose_odom) for r in log.readings])
        print(f"{name}  odometry alone  {scores(asked.folder, known, odometry)[0]}")
        distance_m = known.keyframe_distance_m if asked.keyframe_distance is None else asked.keyframe_distance
        settings = MappingConfig(
            keyframe_distance_m=distance_m, keyframe_turn_rad=asked.keyframe_turn, proposal=asked.proposal
        )
        mapped(log.first(WARM_UP_READINGS), settings, 0)
        for particles in asked.particles:
            config = replace(settings, particles=particles)
            failed = 0
            for seed in range(asked.seeds):
                mapper, seconds = mapped(log, config, seed)
                text, off_m = scores(asked.folder, known, rows_of(mapper.trajectory()))
                failed += off_m >= FAILED_M
                print(
                    f"{name}  {particles} particles  seed {seed}  {text}  {mapper.keyframes} keyframes  {seconds:.1f} s"
                )
            print(f"{name}  {particles} particles  failed {failed} of {asked.seeds}")
            if asked.memory:
                print(f"{name}  {particles} particles  peak memory {peak_mb(log, config):.0f} MB")


if __name__ == "__main__":
    main()
