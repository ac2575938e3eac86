"""The README holds the tree, one line per module, and names commands that exist."""

from __future__ import annotations

import re
from pathlib import Path

from twonav_cli.terminal.app import app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def test_every_module_stands_in_the_tree_and_nothing_else() -> None:
    tree = README.split("```\ntwonav_cli/\n")[1].split("```")[0]
    listed: set[str] = set()
    folders: list[str] = []
    for line in tree.splitlines():
        name, depth = line.split()[0], (len(line) - len(line.lstrip())) // 2
        folders = folders[: max(depth - 1, 0)]
        if name.endswith("/"):
            folders.append(name)
        elif name.endswith(".py"):
            listed.add("".join(folders) + name)
    package = ROOT / "twonav_cli"
    modules = {str(path.relative_to(package)) for path in package.rglob("*.py") if path.name != "__init__.py"}
    assert listed == modules


def test_the_readme_names_only_commands_that_exist() -> None:
    known = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
    known |= {group.name for group in app.registered_groups if group.name}
    named = set(re.findall(r"`?twonav ([a-z]+)\b", README))
    assert named
    assert named <= known | {"play"}
