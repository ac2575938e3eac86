"""Errors and what the surroundings allow."""

from __future__ import annotations

import io

import pytest

from twonav_cli.terminal import console


@pytest.fixture(autouse=True)
def _fresh_consoles() -> None:
    console.err.cache_clear()


def test_an_error_is_one_line_on_standard_error_with_brackets_kept(capsys: pytest.CaptureFixture[str]) -> None:
    console.fail("no map in [red]here[/red]:\n train first")
    captured = capsys.readouterr()
    assert captured.err == "error: no map in [red]here[/red]: train first\n"
    assert captured.out == ""


@pytest.mark.parametrize(
    ("no_colour", "term", "refused"), [("", "xterm", False), ("1", "xterm", True), ("", "dumb", True)]
)
def test_no_color_and_a_dumb_terminal_refuse_colour(
    monkeypatch: pytest.MonkeyPatch, no_colour: str, term: str, refused: bool
) -> None:
    monkeypatch.setenv("NO_COLOR", no_colour)
    monkeypatch.setenv("TERM", term)
    assert console.colour_refused() is refused


def test_the_progress_bar_shows_the_numbers_that_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    from rich.console import Console

    written = io.StringIO()
    monkeypatch.setattr(console, "err", lambda: Console(file=written, force_terminal=True, width=120))
    with console.progress() as bar:
        task = bar.add_task("frames", total=2, result="")
        bar.update(task, completed=1, result="loss 1.25")
    assert "loss 1.25" in written.getvalue()
