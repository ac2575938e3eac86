"""The robot that takes the frames: moved to every pose of a plan, with a camera and, for labels, a range finder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twonav_cli.dataset.collect import MAPPER, SIMULATOR, Images, Labels, Provenance
from twonav_cli.dataset.labels import MapLabels, TourLabels
from twonav_cli.dataset.plan import FramePlan
from twonav_cli.geometry import Pose
from twonav_cli.mapping.floor import Floor
from twonav_cli.mapping.known_maps import SURVEY
from twonav_cli.scene.camera import Camera
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.world import World

UNKNOWN = (np.nan, np.nan, np.nan)


class Photographer:
    """Implements `Taker` in a scene; where the robot made the map itself, it also says where each frame was taken."""

    def __init__(self, floor: Floor, seed: int) -> None:
        """Build the world.

        Args:
            floor: Scene and map.
            seed: Of the noise in the labels.

        Raises:
            TwonavError: No renderer, or the scene cannot be simulated.
        """
        self._world = World(floor.scene)
        self._camera = Camera(self._world)
        self._labels = MapLabels(floor, RangeFinder(self._world), seed) if labelled_by(floor) == MAPPER else None

    def take(self, plan: FramePlan, chunk: int) -> tuple[Images, Labels | None]:
        """Return the pictures [n, 84, 84, 3] of a chunk and their labels [n, 3], None where nobody labels."""
        first, end = (int(number) for number in plan.chunks[chunk])
        poses = [Pose(*(float(value) for value in row)) for row in plan.poses[first:end]]
        if self._labels is None:
            return np.stack([self._picture(pose) for pose in poses]), None
        way = plan.ways[chunk]
        label = TourLabels(self._labels, self._world.place, first, way) if len(way) else self._labels.set_down
        images, found = [], []
        for index, pose in enumerate(poses, start=first):
            images.append(self._picture(pose))
            found.append(label(index, pose) or UNKNOWN)
        return np.stack(images), np.array(found, dtype=np.float32)

    def close(self) -> None:
        """Give back the renderer."""
        self._camera.close()

    def _picture(self, pose: Pose) -> Images:
        self._world.place(pose)
        return self._camera.image()


@dataclass(frozen=True)
class MakePhotographer:
    """Makes a photographer in whichever process it is called."""

    floor: Floor
    seed: int

    def __call__(self) -> Photographer:
        """Return one with a world of its own."""
        return Photographer(self.floor, self.seed)


def labelled_by(floor: Floor) -> str:
    """Return who says where frames on a floor are taken: the robot on a map that it made, else the simulator."""
    return MAPPER if floor.map_source == SURVEY else SIMULATOR


def provenance_of(floor: Floor, seed: int) -> Provenance:
    """Return what frames that are taken on a floor show."""
    scene, labels = floor.scene, labelled_by(floor)
    return Provenance(scene.name, scene.digest, seed, labels=labels, map_digest=floor.map.digest)
