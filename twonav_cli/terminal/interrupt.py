"""Ctrl-C as a normal way to stop: the first asks the loop to save and end, the second breaks it off."""

from __future__ import annotations

import signal
import sys
from types import FrameType, TracebackType


class StopOnInterrupt:
    """While it is entered, the first SIGINT or SIGTERM only makes the object true when called."""

    def __init__(self, sentence: str = "stopping: saving first") -> None:
        self._sentence = sentence
        self.asked = False
        self._before: dict[int, object] = {}

    def __call__(self) -> bool:
        """Whether the run was asked to stop."""
        return self.asked

    def __enter__(self) -> StopOnInterrupt:
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.getsignal(number)
            signal.signal(number, self._ask)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]  # getsignal returned it, so it is one

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
        print(f"{self._sentence} (once more to break off)", file=sys.stderr)
