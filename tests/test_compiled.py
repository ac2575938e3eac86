"""Compiled code is kept apart for every state of the sources."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from twonav_cli.compiled import sources_of_loops
from twonav_cli.files import digest_of_files
from twonav_cli.paths import PACKAGE

KERNEL = "from twonav_cli.compiled import compiled\n"


def test_a_change_in_any_file_that_compiled_code_can_depend_on_is_seen(tmp_path: Path) -> None:
    for folder, text in (("hot", KERNEL), ("cold", "")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "loop.py").write_text(text)
        (tmp_path / folder / "constants.py").write_text("A = 1\n")
    (tmp_path / "ground.py").write_text("B = 1\n")
    before = digest_of_files(sources_of_loops(tmp_path))
    (tmp_path / "cold" / "constants.py").write_text("A = 2\n")
    assert digest_of_files(sources_of_loops(tmp_path)) == before
    for changed in ("hot/constants.py", "ground.py"):
        (tmp_path / changed).write_text("A = 3\n")
        after = digest_of_files(sources_of_loops(tmp_path))
        assert after != before
        before = after


def cache_folder_of(environment: dict[str, str]) -> str:
    code = "import os, twonav_cli.learner.draws, numba; print(numba.config.CACHE_DIR)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.strip()


def test_the_folder_is_named_after_the_sources_unless_the_user_names_one(tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    own = PACKAGE / "__pycache__" / f"numba-{digest_of_files(sources_of_loops())}"
    assert cache_folder_of(environment) == str(own)
    assert cache_folder_of({**environment, "NUMBA_CACHE_DIR": str(tmp_path)}) == str(tmp_path)
