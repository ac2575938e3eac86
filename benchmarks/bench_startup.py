"""How long a person waits: `twonav --help`, and from `twonav play` to the first camera picture on the screen.

    python benchmarks/bench_startup.py [rounds]

Wall time of fresh processes in a pseudo-terminal, after one warm-up each; the median of the rounds is printed.
"""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import statistics
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

TWONAV = str(Path(sys.executable).with_name("twonav"))
FIRST_POSE = re.compile(rb"true.{0,120}?\d\.\d\d", re.DOTALL)
"""The true pose is filled in by the event that brings the first picture."""


def help_s() -> float:
    """Return the wall seconds of `twonav --help`."""
    begun_s = time.perf_counter()
    subprocess.run([TWONAV, "--help"], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begun_s


def first_picture_s(limit_s: float = 60.0) -> tuple[float, float]:
    """Return the wall seconds until the screen is drawn, and until the first camera picture is."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.environ.update(TERM="xterm-256color", COLORTERM="truecolor")
        os.execv(TWONAV, [TWONAV, "play", "--goal", "kitchen", "--no-record"])
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    begun_s, seen, drawn_s = time.perf_counter(), b"", 0.0
    try:
        while time.perf_counter() - begun_s < limit_s:
            if not select.select([terminal], [], [], 0.05)[0]:
                continue
            try:
                seen = seen[-200_000:] + os.read(terminal, 65536)
            except OSError:
                break
            if not drawn_s and b"plan" in seen:
                drawn_s = time.perf_counter() - begun_s
            if FIRST_POSE.search(seen):
                return drawn_s, time.perf_counter() - begun_s
    finally:
        os.kill(pid, signal.SIGINT)
        time.sleep(1.0)
        os.close(terminal)
        os.waitpid(pid, 0)
    raise SystemExit("no picture came: run `twonav doctor`")


def main() -> None:
    """Print both figures."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    help_s()
    print(f"twonav --help: {statistics.median(help_s() for _ in range(rounds)):.2f} s")
    first_picture_s()
    times = [first_picture_s() for _ in range(rounds)]
    drawn_s, picture_s = (statistics.median(column) for column in zip(*times, strict=True))
    print(f"twonav play: screen after {drawn_s:.2f} s, first camera picture after {picture_s:.2f} s")


if __name__ == "__main__":
    main()
