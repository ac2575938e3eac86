"""The rows of one scene in a table of localizers: found, trained where they are missing, and measured, with bars."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import Card, read_card
from twonav_cli.dataset.plan import GRID_SET, RANDOM_SET
from twonav_cli.dataset.store import FrameStore, open_store
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.localizer_tables.budget import budget
from twonav_cli.experiments.localizer_tables.error_map import ErrorMap, error_map
from twonav_cli.experiments.localizer_tables.placing import (
    NEAREST_FRAMES,
    Locator,
    Poses,
    errors_at,
    nearest_locator,
    network_locator,
    placed,
)
from twonav_cli.experiments.localizer_tables.report import (
    BELIEF,
    HELD_CELLS,
    NEAREST,
    PAPER_SPLIT,
    TRIALS,
    LocalizerRow,
    belief_row,
    nearest_row,
    trained_row,
    training_figures,
)
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.experiments.localizer_tables.scene_frames import SceneFrames
from twonav_cli.experiments.localizer_tables.trained import (
    check_begun,
    finished,
    row_folder,
    shipped_card,
    train_row,
)
from twonav_cli.experiments.predecessors import checkpoint_folder
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.errors_report import pose_errors
from twonav_cli.localizer.measuring import thinned
from twonav_cli.localizer.training_config import TrainingConfig
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.fitting_bar import fitting_bar
from twonav_cli.terminal.train_frames import collected, frames_folder
from twonav_cli.worker_pool import StoppedError


class SceneRows:
    """The networks of a scene.

    Attributes:
        floor: The scene and its map.
        cards: Network to its card; None for one that is not trained.
        frames: The scene's frames; None where they are not all taken.
        notes: What could not be measured, and why.
    """

    def __init__(
        self, request: LocalizerRequest, floor: Floor, networks: Sequence[str], should_stop: Callable[[], bool]
    ) -> None:
        """Look what is trained already.

        Raises:
            TwonavError: A network was trained otherwise than it is asked for.
        """
        self.request, self.floor, self.should_stop = request, floor, should_stop
        self.frames: SceneFrames | None = None
        self.notes: list[str] = []
        self.configs: dict[str, TrainingConfig] = {name: budget(name, floor.scene.name, request) for name in networks}
        self.cards: dict[str, Card | None] = {name: self._card(name) for name in self.configs}

    def _card(self, name: str) -> Card | None:
        """Return the card of a network: the user's, or where nothing is to be trained a shipped one (not for maps)."""
        request, config = self.request, self.configs[name]
        own = finished(self.folder(name), config, request.seed, self.floor)
        if own is not None or not request.only_finished or request.quick or request.table == "fig7":
            return own
        shipped = shipped_card(name, config, request.seed, self.floor)
        if shipped is not None:
            self.notes.append(f"{name} here; its figures are the authors' of {shipped['date']}")
        return shipped

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.floor.scene.name

    @property
    def missing(self) -> list[str]:
        """Networks that are not trained."""
        return [name for name, card in self.cards.items() if card is None]

    def folder(self, name: str) -> Path:
        """Return where a network lies, and what was measured with it."""
        return row_folder(self.scene, name, self.request.quick)

    def facts(self) -> dict[str, Any]:
        """Return the map, how many frames there are, and what could not be measured."""
        counts = None if self.frames is None else self.frames.counts()
        return {"map": self.floor.map_source, "frames": counts, "notes": self.notes}

    # Frames and trainings

    def check_begun(self) -> None:
        """Make sure that the trainings that were broken off can go on.

        Raises:
            TwonavError: One was begun with another number of pictures.
        """
        for name in self.missing:
            check_begun(self.folder(name), self.configs[name])

    def take_frames(self) -> None:
        """Take the frames that are missing.

        Raises:
            StoppedError: That was interrupted.
            TwonavError: No renderer, or a folder that holds other frames.
        """
        request, stores = self.request, []
        for name in (GRID_SET, RANDOM_SET):
            store = collected(self.floor, name, request.seed, request.quick, self.should_stop)
            if store is None:
                raise StoppedError
            stores.append(store)
        self.frames = SceneFrames(*stores)

    def find_frames(self) -> None:
        """Take what frames there are, if they are all there."""
        request = self.request
        folders = [frames_folder(self.floor, name, request.seed, request.quick) for name in (GRID_SET, RANDOM_SET)]
        try:
            self.frames = SceneFrames(*(self._found(folder) for folder in folders))
        except TwonavError as error:
            self.notes.append(f"{BELIEF} and {NEAREST}: {error}")

    def _found(self, folder: Path) -> FrameStore:
        store = open_store(folder, self.floor.scene.digest)
        if store.meta.get("map_digest") != self.floor.map.digest:
            raise TwonavError(f"the frames in {folder} were taken on another map: delete it to take them anew")
        return store

    def train_missing(self) -> None:
        """Train the networks that are not trained, one after the other.

        Raises:
            StoppedError: That was interrupted; the next time it goes on.
        """
        missing = self.missing
        for number, name in enumerate(missing, start=1):
            if self.should_stop():
                raise StoppedError
            self.cards[name] = self._trained(name, f"{number} of {len(missing)}")

    def _trained(self, name: str, which: str) -> Card:
        assert self.frames is not None
        config, request = self.configs[name], self.request
        command = request.only(self.scene, name).command()
        with progress() as bar:
            title = f"{self.scene} {name}"
            show = fitting_bar(bar, f"{title} ({which})", config)
            card = train_row(self.frames, self.folder(name), config, request.seed, self.should_stop, show, command)
            if card is None:
                raise StoppedError
            found = card["metrics"][PAPER_SPLIT]
            bar.console.print(
                f"{title}: {found['pos_mean_m']:.3f} m and {found['ang_mean_deg']:.2f} degrees on the paper's split",
                markup=False,
            )
        return card

    # Figures

    def rows(self) -> list[LocalizerRow]:
        """Return the scene's rows: the paper's networks, then ours and the most alike frame.

        Raises:
            StoppedError: Measuring was interrupted.
        """
        found = [trained_row(self.scene, name, card, self.folder(name)) for name, card in self.cards.items()]
        if self.frames is None:
            return found
        ours = self._belief()
        if ours is not None:
            folder, card, locator = ours
            found.append(belief_row(self.scene, self._errors(BELIEF, locator, self._fair_trials(card)), card, folder))
        nearest = nearest_locator(self.frames.training())
        return [*found, nearest_row(self.scene, self._errors(NEAREST, nearest, TRIALS))]

    def _fair_trials(self, card: Card) -> Sequence[str]:
        """Return the trials of which our network has seen nothing; where one is left out, a note says so."""
        assert self.frames is not None
        if not self.frames.seen_cells(card):
            return TRIALS
        self.notes.append(
            f"{BELIEF} in held-out cells: it was trained with another seed or on another map, where other cells are "
            "held out"
        )
        return [trial for trial in TRIALS if trial != HELD_CELLS]

    def maps(self) -> list[ErrorMap]:
        """Return the error map of every network that is trained, of ours and of the most alike frame.

        Raises:
            StoppedError: Measuring was interrupted.
        """
        if self.frames is None:
            return []
        found = []
        for name, card in self.cards.items():
            if card is not None:
                locator = network_locator(self.folder(name), self.floor.scene.digest)
                found.append(self._map(name, locator, training_figures(card, self.folder(name))))
        ours = self._belief()
        if ours is not None:
            folder, card, locator = ours
            found.append(self._map(BELIEF, locator, training_figures(card, folder)))
        return [*found, self._map(NEAREST, nearest_locator(self.frames.training()), None)]

    def _map(self, name: str, locator: Locator, training: dict[str, Any] | None) -> ErrorMap:
        assert self.frames is not None
        store, frames = selection = self._trial(name, PAPER_SPLIT)
        errors_m, _ = pose_errors(self._placed(name, locator, PAPER_SPLIT, selection), store.poses[frames])
        return error_map(self.scene, name, errors_m, store.poses[frames], training)

    def _errors(self, name: str, locator: Locator, trials: Sequence[str]) -> dict[str, Any]:
        """Return the errors of a locator at every one of some trials that has frames."""
        found = {}
        for trial in trials:
            selection = self._trial(name, trial)
            if len(selection[1]):
                found[trial] = errors_at(self._placed(name, locator, trial, selection), selection)
        return found

    def _trial(self, name: str, trial: str) -> Selection:
        """Return the frames of a trial; evenly chosen ones for the most alike frame, which is slow to find."""
        assert self.frames is not None
        store, frames = self.frames.trials()[trial]
        return store, thinned(frames, NEAREST_FRAMES) if name == NEAREST else frames

    def _placed(self, name: str, locator: Locator, trial: str, selection: Selection) -> Poses:
        title, file = f"{self.scene} {name}, {trial}", self.folder(name) / f"poses-{trial}.safetensors"
        with progress() as bar:
            task = bar.add_task(title, total=len(selection[1]), result="frames measured")
            if not bar.console.is_terminal and not file.exists():
                bar.console.print(f"{title}: measuring {len(selection[1]):,} frames", markup=False)
            return placed(locator, selection, file, self.should_stop, lambda done: bar.update(task, completed=done))

    def _belief(self) -> tuple[Path, Card, Locator] | None:
        """Return our network where there is one for this scene: folder, card and what places with it."""
        floor = self.floor
        try:
            folder = checkpoint_folder(
                self.scene, "localizer", None, False, floor.scene.digest, floor.map.digest, floor.map_source
            )
            card = read_card(folder)
            if card.get("settings", {}).get("network", BELIEF) != BELIEF:
                raise TwonavError(f"the localizer in {folder} is another network")
            return folder, card, network_locator(folder, floor.scene.digest)
        except TwonavError as error:
            self.notes.append(f"{BELIEF}: {error}")
            return None
