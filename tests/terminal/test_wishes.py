"""The player's commands, as a journey asks for them."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

import pytest

from twonav_cli.experiments.new_goal import GoalWish
from twonav_cli.terminal.commands import AddGoal, Command, GoTo, Kidnap, Move, Pause, Quit, SingleStep, Speed
from twonav_cli.terminal.wishes import QueuedWishes


class Player:
    """The screen's end of the queue."""

    def __init__(self) -> None:
        self.commands: queue.Queue[Command] = queue.Queue()
        self.stop = threading.Event()
        self.wishes = QueuedWishes(self.commands, self.stop, speed=4.0)

    def asks(self, *commands: Command) -> QueuedWishes:
        for command in commands:
            self.commands.put(command)
        return self.wishes

    def is_let_on(self, within_s: float) -> bool:
        """Whether the simulation is given permission within a time."""
        waiting = threading.Thread(target=self.wishes.wait_for_permission, daemon=True)
        waiting.start()
        waiting.join(within_s)
        return not waiting.is_alive()


@pytest.fixture
def player() -> Iterator[Player]:
    player = Player()
    yield player
    player.stop.set()


def test_nothing_is_wanted_at_first(player: Player) -> None:
    wishes = player.wishes
    assert (wishes.next_goal(wait=False), wishes.take_kidnap(), wishes.take_move()) == (None, False, None)
    assert not wishes.left()
    assert wishes.pace() == 4.0
    assert player.is_let_on(within_s=1.0)


def test_goals_are_handed_out_once_and_in_order(player: Player) -> None:
    wishes = player.asks(GoTo("bed"), GoTo("desk"))
    assert [wishes.next_goal(wait=False) for _ in range(3)] == ["bed", "desk", None]


def test_a_goal_is_added_before_any_that_was_asked_for_is_driven_to(player: Player) -> None:
    wishes = player.asks(AddGoal("plant", 3.2, 1.5), GoTo("plant"), AddGoal("here"))
    assert wishes.next_goal(wait=True) is None
    assert wishes.take_new_goal() == GoalWish("plant", (3.2, 1.5))
    assert wishes.take_new_goal() == GoalWish("here")
    assert wishes.take_new_goal() is None
    assert wishes.next_goal(wait=False) == "plant"


def test_a_goal_is_added_during_a_pause_and_uses_up_no_single_step(player: Player) -> None:
    player.asks(SingleStep(), AddGoal("plant", 3.2, 1.5))
    assert player.is_let_on(within_s=1.0)
    player.wishes.take_new_goal()
    assert player.is_let_on(within_s=1.0)
    assert not player.is_let_on(within_s=0.2)


def test_a_kidnap_and_a_move_happen_once(player: Player) -> None:
    wishes = player.asks(Kidnap(), Kidnap(), Move(2), Move(0))
    assert [wishes.take_kidnap(), wishes.take_kidnap()] == [True, False]
    assert [wishes.take_move() for _ in range(3)] == [2, 0, None]


def test_a_speed_counts_from_when_it_is_read(player: Player) -> None:
    wishes = player.asks(Speed(0.5))
    wishes.next_goal(wait=False)
    assert wishes.pace() == 0.5


def test_waiting_for_a_goal_ends_when_one_comes(player: Player) -> None:
    threading.Timer(0.1, player.commands.put, [GoTo("bed")]).start()
    begun_s = time.monotonic()
    assert player.wishes.next_goal(wait=True) == "bed"
    assert time.monotonic() - begun_s >= 0.08


@pytest.mark.parametrize("by_key", [True, False])
def test_waiting_for_a_goal_ends_when_the_player_leaves(player: Player, by_key: bool) -> None:
    leave = (lambda: player.commands.put(Quit())) if by_key else player.stop.set
    threading.Timer(0.05, leave).start()
    assert player.wishes.next_goal(wait=True) is None
    assert player.wishes.left()


def test_a_pause_holds_until_it_is_lifted(player: Player) -> None:
    player.asks(Pause(True))
    assert not player.is_let_on(within_s=0.2)
    player.asks(Pause(False))
    assert player.is_let_on(within_s=2.0)


def test_a_single_step_is_one_step_and_then_a_pause(player: Player) -> None:
    player.asks(SingleStep())
    assert player.is_let_on(within_s=1.0)
    assert not player.is_let_on(within_s=0.2)


@pytest.mark.parametrize("command", [GoTo("bed"), Kidnap(), Move(1), Quit()])
def test_a_goal_a_kidnap_a_move_or_leaving_is_answered_during_a_pause(player: Player, command: Command) -> None:
    player.asks(Pause(True), command)
    assert player.is_let_on(within_s=1.0)
