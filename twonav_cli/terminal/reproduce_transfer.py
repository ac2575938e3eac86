"""`twonav reproduce table9 | table10`: agents that are missing learn in processes of their own; prints and writes."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from twonav_cli.checkpoint import versions
from twonav_cli.experiments.transfer.agent_chain import (
    AgentJob,
    finished_card,
    run_agent,
    trials_at_most,
)
from twonav_cli.experiments.transfer.finished import finished_agents
from twonav_cli.experiments.transfer.request import CHAINS, CHAINS_OF, TransferRequest
from twonav_cli.experiments.transfer.tables import Figures, TransferReport, transfer_report
from twonav_cli.files import write_whole
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.stages.fitting import check_robot_fits
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.map_source import tell_source
from twonav_cli.worker_pool import StoppedError, done_in_workers


def run_transfer(request: TransferRequest, folder: Path, as_json: bool) -> int:
    """Make, print and write a table about transfer.

    Args:
        request: What was asked, checked.
        folder: Where the results go.
        as_json: Print one JSON object instead.

    Returns:
        0, or 130 when interrupted: agents go on where they were the next time.

    Raises:
        TwonavError: A goal cannot be reached, or a checkpoint is damaged or of another map.
    """
    floor = read_floor(request.scene, request.map_from, own_first=True)
    chains = CHAINS_OF[request.table]
    if not request.only_finished:
        check_robot_fits(floor)
        with StopOnInterrupt("stopping: the agents go on where they were the next time") as stop:
            try:
                _train_missing(request, chains, floor, stop)
            except StoppedError:
                print(f"stopped: go on with: {request.command()}", file=sys.stderr)
                return 130
    report = transfer_report(request, finished_agents(request, chains, floor), _settings(request, floor))
    if not as_json:
        from twonav_cli.terminal.reproduced_transfer import print_transfer

        print_transfer(report)
    _write(report, folder, "-quick" if request.quick else "")
    tell_source(floor, request.scene, request.map_from)
    if as_json:
        print(json.dumps(asdict(report), allow_nan=False))
    return 0


def _train_missing(
    request: TransferRequest, chains: tuple[str, ...], floor: Floor, should_stop: Callable[[], bool]
) -> None:
    """Let every agent learn that has not learned yet."""
    wanted = [AgentJob(request, chain, agent) for agent in range(request.agents) for chain in chains]
    jobs = [job for job in wanted if finished_card(job, floor, CHAINS[job.chain][-1]) is None]
    if not jobs:
        return
    begun_s = time.monotonic()
    with progress() as bar:
        task = bar.add_task(f"{request.table}, agents", total=len(wanted), completed=len(wanted) - len(jobs), result="")
        for number, learned in done_in_workers(run_agent, jobs, request.processes, should_stop):
            said = (
                f"agent {jobs[number].agent} {jobs[number].chain}: {learned} of {len(floor.maze.goals)} goals learned"
            )
            bar.update(task, advance=1, result=said)
            if not bar.console.is_terminal:
                minutes = (time.monotonic() - begun_s) / 60
                bar.console.print(f"{said}, after {minutes:.1f} min", markup=False)


def _settings(request: TransferRequest, floor: Floor) -> Figures:
    return {
        "seed": request.seed,
        "agents": request.agents,
        "scene": floor.scene.name,
        "map": floor.map_source,
        "localizer": request.localizer,
        "base": request.base,
        "quick": request.quick,
        "trials_at_most": {chain: trials_at_most(chain, request.quick) for chain in CHAINS},
        "learning": {name: asdict(request.learning(name)) for name in ("maze", "2d", "3d")},
        "command": request.command(),
        "versions": versions(),
    }


def _write(report: TransferReport, folder: Path, ending: str) -> None:
    """Write NAME.json and NAME.png, and print their paths."""
    from twonav_cli.plotting.pictures import picture_of_transfer

    text = json.dumps(asdict(report), indent=1, allow_nan=False) + "\n"
    print(write_whole(folder / f"{report.table}{ending}.json", text), file=sys.stderr)
    if report.goals:
        print(write_whole(folder / f"{report.table}{ending}.png", picture_of_transfer(report)), file=sys.stderr)
