"""The command line: thin commands that parse, call and print. Heavy packages are imported inside them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from twonav_cli.errors import TwonavError
from twonav_cli.terminal.map_options import (
    KeyframeDistanceOption,
    KeyframeTurnOption,
    LaserForwardOption,
    LogArgument,
    MapChoices,
    MaxRangeOption,
    OutOption,
    ParticlesOption,
    ResolutionOption,
)
from twonav_cli.terminal.map_source import MapFromOption
from twonav_cli.terminal.reproduce_options import (
    AgentBaseOption,
    AgentLocalizerOption,
    NetworksOption,
    OnlyFinishedOption,
    QuickRowsOption,
    RowDeviceOption,
    RowImagesOption,
)
from twonav_cli.terminal.train_options import (
    CoolingOption,
    DiscountOption,
    ExplorationOption,
    GoalSelectionOption,
    InitialQOption,
    LearnerOption,
    PresetOption,
    RandomMazeOption,
    TemperatureOption,
    TrainBaseOption,
    WatchOption,
)

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    add_completion=False,
    help="A robot learns to find its way through an apartment from its own camera, and shows why it does or does not.",
)
scenes_app = typer.Typer(help="List the scenes, or look at one.", invoke_without_command=True)
app.add_typer(scenes_app, name="scenes")

SceneOption = Annotated[str, typer.Option("--scene", help="Name of a scene (see `twonav scenes`) or path to an .xml.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of everything random in the run.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]
RecordOption = Annotated[Path | None, typer.Option("--record", help="Where the recording (.rrd) goes.")]
NoRecordOption = Annotated[bool, typer.Option("--no-record", help="Write no recording.")]
BaseOption = Annotated[str, typer.Option("--base", help="omni or differential.")]
LocalizerOption = Annotated[
    str,
    typer.Option("--localizer", help="filtered (camera and odometry), raw (each picture alone) or truth (3d only)."),
]
CheckpointsOption = Annotated[
    Path | None,
    typer.Option(
        "--checkpoints", help="Folder of a scene's checkpoints (map, maze, 2d, 3d, localizer); default: the shipped."
    ),
]


NetworkOption = Annotated[
    str | None, typer.Option("--network", help="Ours (belief) or one of the paper's, as inception-9 (localizer only).")
]


@app.command()
def play(
    goal: Annotated[list[str] | None, typer.Option("--goal", help="Goal to drive to; repeat for more.")] = None,
    scene: SceneOption = "apartment",
    stage: Annotated[str, typer.Option("--stage", help="maze, 2d or 3d.")] = "3d",
    start: Annotated[
        str | None, typer.Option("--start", help="Start to begin at; default: drawn from the seed.")
    ] = None,
    seed: SeedOption = 0,
    record: RecordOption = None,
    no_record: NoRecordOption = False,
    plain: Annotated[bool, typer.Option("--plain", help="One line per action instead of the live screen.")] = False,
    localizer: LocalizerOption = "filtered",
    base: BaseOption = "omni",
    speed: Annotated[float, typer.Option("--speed", min=0.0, help="Simulated seconds per second; 0: no limit.")] = 4.0,
    checkpoints: CheckpointsOption = None,
    map_from: MapFromOption = None,
    keys: Annotated[str | None, typer.Option("--keys", help="Keys to press, as in 'kitchen<enter> q'.")] = None,
) -> None:
    """Watch the robot drive to the goals you name, from its own camera; ask for more at the prompt."""
    from twonav_cli.terminal.play import PlayRequest, run_play

    request = PlayRequest(
        scene=scene, stage=stage, goals=tuple(goal or ()), start=start, seed=seed, record=record,
        recording=not no_record, plain=plain, localizer=localizer, base=base, speed=speed,
        checkpoints=checkpoints, map_from=map_from, keys=keys,
    )  # fmt: skip
    raise typer.Exit(run_play(request))


@app.command()
def train(
    stage: Annotated[str, typer.Option("--stage", help="map, maze, 2d, frames, localizer, 3d or all.")],
    scene: Annotated[
        str | None,
        typer.Option(
            "--scene", help="Name of a scene (see `twonav scenes`) or path to an .xml.", show_default="apartment"
        ),
    ] = None,
    seed: SeedOption = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the last run of this stage stopped.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for the checkpoint; default: runs/SCENE/STAGE.")
    ] = None,
    record: RecordOption = None,
    no_record: NoRecordOption = False,
    quick: Annotated[bool, typer.Option("--quick", help="A small run that shows that everything works.")] = False,
    images: Annotated[
        int | None, typer.Option("--images", min=1, help="Pictures shown in all, repeats included (localizer only).")
    ] = None,
    network: Annotated[
        str | None,
        typer.Option("--network", help="Ours (belief) or one of the paper's, as inception-9 (localizer only)."),
    ] = None,
    device: Annotated[str | None, typer.Option("--device", help="cpu, cuda or auto (localizer only).")] = None,
    base: TrainBaseOption = None,
    no_transfer: Annotated[
        bool,
        typer.Option(
            "--no-transfer", help="Learn from nothing (2d, 3d). Drive it: --out DIR/3d here, --checkpoints DIR there."
        ),
    ] = False,
    map_from: MapFromOption = None,
    json_: JsonOption = False,
    watch: WatchOption = False,
    learner: LearnerOption = None,
    preset: PresetOption = None,
    discount: DiscountOption = None,
    temperature: TemperatureOption = None,
    initial_q: InitialQOption = None,
    goal_selection: GoalSelectionOption = None,
    exploration: ExplorationOption = None,
    cooling: CoolingOption = None,
    random_maze: RandomMazeOption = None,
) -> None:
    """Train one stage, or all: the robot makes its map; the agent learns in the maze, in 2D, in 3D by its camera."""
    from twonav_cli.terminal.learning_choices import LearningChoices
    from twonav_cli.terminal.train import TrainRequest, run_train

    choices = LearningChoices(learner, preset, discount, temperature, initial_q, goal_selection, exploration, cooling)
    request = TrainRequest(
        stage=stage, scene=scene, seed=seed, resume=resume, out=out, record=record, recording=not no_record,
        quick=quick, images=images, network=network, device=device, base=base, transfer=not no_transfer, as_json=json_,
        watch=watch, random_maze=random_maze, map_from=map_from, choices=choices,
    )  # fmt: skip
    raise typer.Exit(run_train(request))


@app.command("map")
def map_log(
    log: LogArgument,
    particles: ParticlesOption = None,
    resolution: ResolutionOption = None,
    max_range: MaxRangeOption = None,
    keyframe_distance: KeyframeDistanceOption = None,
    keyframe_turn: KeyframeTurnOption = None,
    laser_forward: LaserForwardOption = None,
    seed: SeedOption = 0,
    out: OutOption = None,
    record: RecordOption = None,
    no_record: NoRecordOption = False,
    json_: JsonOption = False,
) -> None:
    """Make a map from the scans and the odometry of a real robot's log, with a particle filter."""
    from twonav_cli.terminal.map_log import MapRequest, run_map

    choices = MapChoices(particles, resolution, max_range, keyframe_distance, keyframe_turn)
    request = MapRequest(
        log=log, choices=choices, laser_forward_m=laser_forward, seed=seed, out=out, record=record,
        recording=not no_record, as_json=json_,
    )  # fmt: skip
    raise typer.Exit(run_map(request))


@app.command()
def evaluate(
    stage: Annotated[str, typer.Option("--stage", help="3d, 2d, maze or localizer.")] = "3d",
    localizer: LocalizerOption = "raw",
    scene: SceneOption = "apartment",
    seed: SeedOption = 0,
    record: RecordOption = None,
    base: BaseOption = "omni",
    frames: Annotated[
        int | None,
        typer.Option("--frames", min=1, help="Held-out random poses (localizer only).", show_default="4000"),
    ] = None,
    track_frames: Annotated[
        int | None,
        typer.Option("--track-frames", min=0, help="Frames along driven tracks (localizer only).", show_default="5000"),
    ] = None,
    kidnap_frames: Annotated[
        int | None,
        typer.Option(
            "--kidnap-frames",
            min=0,
            help="Frames of tracks with a kidnap every 25 (localizer only).",
            show_default="10000",
        ),
    ] = None,
    network: NetworkOption = None,
    repeats: Annotated[int, typer.Option("--repeats", min=1, help="How often every pair is driven.")] = 1,
    workers: Annotated[
        int, typer.Option("--workers", min=1, help="Processes that share the pairs; the figures are the same.")
    ] = 1,
    checkpoints: CheckpointsOption = None,
    map_from: MapFromOption = None,
    json_: JsonOption = False,
) -> None:
    """Measure: every goal from every start, or the localizer's errors on held-out random poses."""
    from twonav_cli.terminal.evaluate import EvaluateRequest, run_evaluate

    request = EvaluateRequest(
        stage=stage, localizer=localizer, scene=scene, seed=seed, record=record, base=base, frames=frames,
        track_frames=track_frames, kidnap_frames=kidnap_frames, network=network, repeats=repeats, workers=workers,
        checkpoints=checkpoints, map_from=map_from, as_json=json_,
    )  # fmt: skip
    raise typer.Exit(run_evaluate(request))


@app.command()
def reproduce(
    table: Annotated[
        str,
        typer.Argument(
            help="table5 to table8, fig8, sensitivity, all of these; or, in hours, table3, table4, fig7 (networks), "
            "table9, table10 (agents in 2D and 3D); or fig9 (where the camera's pose is wrong)."
        ),
    ],
    repeats: Annotated[
        int | None,
        typer.Option(
            "--repeats", help="Runs of every method on every maze, or agents; default: 10, in the sensitivity sweep 3."
        ),
    ] = None,
    seed: SeedOption = 0,
    discount: Annotated[
        float | None,
        typer.Option("--discount", help="For every learner; default: 0.99 for the paper's, their own for the others."),
    ] = None,
    cooling: Annotated[
        str | None,
        typer.Option(
            "--cooling", help="T cools per-goal, anew for each, or once, over all goals.", show_default="per-goal"
        ),
    ] = None,
    mazes: Annotated[
        int | None, typer.Option("--mazes", help="Random mazes (table5, table6, sensitivity).", show_default="10")
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(
            "--scene",
            help="Whose maze (table7 to table10, fig8), fig9), or only whose rows (table3, table4, fig7).",
            show_default="apartment, or all rows",
        ),
    ] = None,
    map_from: MapFromOption = None,
    processes: Annotated[
        int | None, typer.Option("--processes", help="Workers that share the runs; default: one for each processor.")
    ] = None,
    quick: QuickRowsOption = False,
    images: RowImagesOption = None,
    device: RowDeviceOption = None,
    networks: NetworksOption = None,
    only_finished: OnlyFinishedOption = False,
    localizer: AgentLocalizerOption = None,
    base: AgentBaseOption = None,
    json_: JsonOption = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for NAME.json and NAME.png; default: runs/reproduce.")
    ] = None,
) -> None:
    """Make a table or figure of the paper again, and print it beside the paper's figures.

    Those about mazes take two minutes together (all). Those about localizers train the paper's networks, those about
    2D and 3D ten agents; both take hours, can be interrupted at any time and go on where they were.
    """
    from twonav_cli.terminal.reproduce import ReproduceRequest, run_reproduce

    request = ReproduceRequest(
        table=table, repeats=repeats, seed=seed, discount=discount, mazes=mazes, scene=scene, processes=processes,
        as_json=json_, out=out, cooling=cooling, map_from=map_from, quick=quick, images=images, device=device,
        networks=networks, only_finished=only_finished, localizer=localizer, base=base,
    )  # fmt: skip
    raise typer.Exit(run_reproduce(request))


@app.command()
def inspect(
    file: Annotated[Path, typer.Argument(help="A recording (.rrd) that twonav wrote.")],
    json_: JsonOption = False,
) -> None:
    """Print a recording's trials, outcomes and failures, and the command that opens it in the viewer."""
    from twonav_cli.terminal.inspect import run_inspect

    raise typer.Exit(run_inspect(file, json_))


@app.command()
def doctor(
    json_: JsonOption = False,
    warm_up: Annotated[bool, typer.Option("--warm-up", help="Also compile everything that play needs.")] = False,
) -> None:
    """Report renderer, versions, device, scenes and checkpoints, and what to do about what is missing."""
    from twonav_cli.terminal.doctor import run_doctor

    raise typer.Exit(run_doctor(json_, warm_up))


@scenes_app.callback()
def scenes(context: typer.Context, json_: JsonOption = False) -> None:
    """List the scenes."""
    if context.invoked_subcommand is None:
        from twonav_cli.terminal.scenes import run_list

        raise typer.Exit(run_list(json_))


@scenes_app.command("show")
def scenes_show(
    scene: Annotated[str, typer.Argument(help="Name of a scene, or path to an .xml or to any map's .yaml.")],
    map_: Annotated[
        bool, typer.Option("--map", help="Draw the 5 cm map with the blocked cells of the maze over it.")
    ] = False,
    map_from: MapFromOption = None,
) -> None:
    """Draw a scene's floor plan with its goals and starts, or a map with the maze that is made from it."""
    from twonav_cli.terminal.scenes import run_show

    raise typer.Exit(run_show(scene, map_, map_from))


@app.command()
def version() -> None:
    """Print the version."""
    from twonav_cli import __version__

    typer.echo(__version__)


def main() -> None:
    """Run the command line; a TwonavError is one red line and exit code 1, Ctrl-C is 130."""
    import signal

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        app()
    except TwonavError as error:
        from twonav_cli.terminal.console import fail

        fail(str(error))
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(141)
