"""The order of the layers, one heavy dependency per package, and what no file may hold: read from the sources."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import pytest

import twonav_cli

PACKAGE = Path(twonav_cli.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
NAMES = [".".join(("twonav_cli", *path.relative_to(PACKAGE).with_suffix("").parts)) for path in MODULES]

LAYERS = (
    "ground", "scene", "navigation", "sim2d", "mapping", "dataset", "localizer", "learner", "stages", "environments",
    "experiments", "plotting", "recording", "terminal",
)  # fmt: skip
"""A module imports from its own layer and from those before it."""

HEAVY = {
    "mujoco": lambda name: name.startswith("twonav_cli.scene."),
    "torch": lambda name: name.startswith("twonav_cli.localizer.") or name == "twonav_cli.terminal.doctor",
    "rerun": lambda name: name.startswith("twonav_cli.recording."),
    "textual": lambda name: name.startswith("twonav_cli.terminal."),
    "rich": lambda name: name.startswith("twonav_cli.terminal."),
    "typer": lambda name: name.startswith("twonav_cli.terminal."),
    "matplotlib": lambda name: name.startswith("twonav_cli.plotting."),
    "gymnasium": lambda name: name.startswith("twonav_cli.environments."),
    "numba": lambda name: name == "twonav_cli.compiled",
}
"""Package to the modules that may import it."""

GROUND_USES = {"numpy", "numba", "safetensors", "platformdirs"}

FORBIDDEN = {"utils", "helpers", "common", "manager", "base", "core", "misc", "handler", "process"}

UNSAFE = re.compile(
    r"torch\.load\b|\bpickle|allow_pickle\s*=\s*True|yaml\.load\b|(?<![.\w])(?:eval|exec)\(|\bdill\b|\bmarshal\b"
)

LINES_AT_MOST = 400
FUNCTION_LINES_AT_MOST = 40


class Import(NamedTuple):
    """A module that is imported, and whether that happens as soon as the importing one is."""

    module: str
    at_once: bool


def layer_of(name: str) -> str:
    """Return the layer of a module of the package."""
    parts = name.split(".")
    return parts[1] if len(parts) > 2 else "ground"


@lru_cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports_of(path: Path) -> list[Import]:
    """Return what a file imports anywhere, without what only the type checker sees."""
    return list(_imports_in(tree_of(path), at_once=True))


def _imports_in(node: ast.AST, at_once: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (Import(alias.name, at_once) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, "imports are absolute"
            module = child.module or ""
            submodules = (f"{module}.{alias.name}" for alias in child.names)
            inner = [name for name in submodules if name in NAMES]
            yield from (Import(name, at_once) for name in (inner or [module]))
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            for other in child.orelse:
                yield from _imports_in(other, at_once)
        else:
            inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            yield from _imports_in(child, at_once and not inside)


def own(imports: list[Import]) -> list[str]:
    return [module for module, _ in imports if module == "twonav_cli" or module.startswith("twonav_cli.")]


def needed_by(name: str) -> set[str]:
    """Return every module of the package that a module may come to import, itself included."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        module = waiting.pop()
        if module in NAMES and module not in found:
            found.add(module)
            waiting += own(imports_of(MODULES[NAMES.index(module)]))
    return found


def defined_names(path: Path) -> set[str]:
    kinds = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    return {node.name for node in ast.walk(tree_of(path)) if isinstance(node, kinds)}


def words_of(name: str) -> set[str]:
    """Return the lower-case words of a name in snake_case or CamelCase."""
    return {word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}


@pytest.fixture(params=zip(NAMES, MODULES, strict=True), ids=NAMES)
def module(request: pytest.FixtureRequest) -> tuple[str, Path]:
    name, path = request.param
    return name, path


def test_every_package_is_a_layer() -> None:
    assert {layer_of(name) for name in NAMES if not name.endswith("__init__")} == set(LAYERS)


def test_a_module_imports_only_from_its_own_layer_and_those_before_it(module: tuple[str, Path]) -> None:
    name, path = module
    if name == "twonav_cli.__main__":
        pytest.skip("it only starts the command line")
    rank = LAYERS.index(layer_of(name))
    above = [other for other in own(imports_of(path)) if LAYERS.index(layer_of(other)) > rank]
    assert not above, f"{name} imports from a later layer: {above}"


def test_modules_do_not_import_each_other_in_a_circle(module: tuple[str, Path]) -> None:
    name, path = module
    at_once = [other for other, now in imports_of(path) if now and other in NAMES]
    assert not [other for other in at_once if name in needed_at_once_by(other)]


@lru_cache
def needed_at_once_by(name: str) -> frozenset[str]:
    """Return every module that is imported as soon as this one is, itself included."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        current = waiting.pop()
        if current in NAMES and current not in found:
            found.add(current)
            waiting += [other for other, now in imports_of(MODULES[NAMES.index(current)]) if now]
    return frozenset(found)


def test_each_heavy_dependency_has_one_place(module: tuple[str, Path]) -> None:
    name, path = module
    roots = {imported.split(".")[0] for imported, _ in imports_of(path)}
    misplaced = [heavy for heavy, allowed in HEAVY.items() if heavy in roots and not allowed(name)]
    assert not misplaced, f"{name} imports {misplaced}"


@pytest.mark.parametrize("heavy", sorted(HEAVY))
def test_each_heavy_dependency_is_used_where_it_belongs(heavy: str) -> None:
    """So that the test before does not hold because nothing is imported at all."""
    users = [n for n, p in zip(NAMES, MODULES, strict=True) if heavy in {i.split(".")[0] for i, _ in imports_of(p)}]
    assert users


@pytest.mark.parametrize("name", [name for name in NAMES if layer_of(name) == "ground" and "__main__" not in name])
def test_the_ground_needs_little_more_than_numpy(name: str) -> None:
    import sys

    imported = {other.split(".")[0] for other, _ in imports_of(MODULES[NAMES.index(name)])}
    assert imported - set(sys.stdlib_module_names) - {"twonav_cli"} <= GROUND_USES


@pytest.mark.parametrize("name", [name for name in NAMES if layer_of(name) == "learner"])
def test_the_learner_needs_neither_mujoco_nor_torch(name: str) -> None:
    outside = {other.split(".")[0] for inner in needed_by(name) for other, _ in imports_of(MODULES[NAMES.index(inner)])}
    assert not outside & {"mujoco", "torch", "rerun", "cv2", "scipy"}


@pytest.mark.parametrize("name", [name for name in NAMES if layer_of(name) == "recording"])
def test_recording_sees_only_events_and_what_they_are_made_of(name: str) -> None:
    seen = {other for other in own(imports_of(MODULES[NAMES.index(name)])) if layer_of(other) != "recording"}
    grounds = ("events", "geometry", "grid", "maze", "config", "errors", "belief")
    allowed = {f"twonav_cli.{part}" for part in grounds}
    assert seen <= allowed | {"twonav_cli"}


def test_no_name_says_nothing(module: tuple[str, Path]) -> None:
    name, path = module
    assert not words_of(name.removeprefix("twonav_cli")) & FORBIDDEN
    assert not {defined for defined in defined_names(path) if words_of(defined) & FORBIDDEN}


def test_nothing_is_unpickled_or_evaluated(module: tuple[str, Path]) -> None:
    _, path = module
    code = ast.unparse(without_docstrings(path))
    assert not UNSAFE.findall(code)


def without_docstrings(path: Path) -> ast.Module:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            node.value.value = ""
    return tree


def test_a_module_is_at_most_400_lines_long(module: tuple[str, Path]) -> None:
    assert len(module[1].read_text(encoding="utf-8").splitlines()) <= LINES_AT_MOST


def test_a_function_is_at_most_40_lines_long_without_its_docstring(module: tuple[str, Path]) -> None:
    long = {}
    for node in ast.walk(tree_of(module[1])):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            body = node.body[1:] if ast.get_docstring(node) is not None else node.body
            lines = body[-1].end_lineno - body[0].lineno + 1 if body else 0  # type: ignore[operator]  # parsed: it has
            if lines > FUNCTION_LINES_AT_MOST:
                long[node.name] = lines
    assert not long


def test_the_words_of_a_name_are_found_in_both_spellings() -> None:
    assert words_of("read_HTTPBaseURL") == {"read", "http", "base", "url"}
    assert words_of("on_process2") == {"on", "process"}
