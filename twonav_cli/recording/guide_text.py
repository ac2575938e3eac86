"""What the "About" tab of a recording says."""

from __future__ import annotations

from twonav_cli.events import RunStarted

_DRIVE = """
## What went wrong, and why
1. The recording opens on the end of the run: every failure is on the map and in the log. The marked stretch of the time
   line is the last failure; space plays, the arrow keys step.
2. The lanes under the map show goal, outcome and cause of every trial; the whole trial has the colour of how it ended.
   Click into a lane to go there.
3. The log names each failure with its **cause** and the **evidence** for it. Click a line to move the cursor.
4. A long red line on the map means the robot believed to be elsewhere: look at *Position error* and at the camera.
   Dots with a trial number are the places where trials failed; they accumulate.

## The map (metres, y up; row 0 of the maze is the top)
| colour | what |
|---|---|
| blue arrow, outline | where the robot is |
| magenta arrow | where the controller believes it is (odometry since the last estimate) |
| orange arrow | the localizer's estimate after an action |
| red line | the error between is and believes |
| light blue line | way of this trial |
| orange dots | range finder (beams beyond its cut are left out) |
| black circle | the goal of this trial |

## The other tabs
* **Q-values**: value of the best action per cell and the greedy action, for the goal driven to and for every goal;
  bright is close to the goal. Unvisited cells keep their initial value.
* **Learning**: TD error per goal (log10; the largest decides the next goal), actions per trial beside the shortest
  way, share of the last 20 trials that reached the goal, and why each goal was chosen.
* **Controller**: the robot from above, always in the middle: candidate motions (dark is cheap, red would touch), the
  chosen one in black, and the local cost map. Candidates and cost map lie where the controller believes they lie.
* **Trials**: the last trials as a table; for programs every one is a row of `/trials`.
"""

_MAZE = """
## How to read it
* **Learning**: TD error per goal (log10; the largest decides the next goal), actions per trial beside the shortest way
  (means over a few trials in a long run), share of trials that reached the goal.
* **Q-values**: value of the best action per cell and the greedy action per goal; bright is close to the goal.
  Unvisited cells keep their initial value. Move the cursor to see them grow.
* **Maze**: the maze (row 0 is the top), and the way of single trials where they were recorded.
* **Trials**: one row per trial (of a long run only some), also for programs (`/trials`).
"""

_FIT = """
## How to read it
* **Curves**: loss and learning rate per batch, and what was measured on the validation frames, by unit.
* The timelines are `batch`, `epoch` and `sim_time`; switch at the lower left.
"""


def about(event: RunStarted, kind: str) -> str:
    """Return the text of the "About" tab in Markdown."""
    settings = "\n".join(f"| {name} | {value} |" for name, value in event.settings.items())
    table = f"\n## Settings\n| setting | value |\n|---|---|\n{settings}\n" if settings else ""
    body = {"3d": _DRIVE, "maze": _MAZE, "localizer": _FIT}[kind]
    timelines = (
        ""
        if kind == "localizer"
        else "\n`step` counts actions over the whole run, `trial` attempts at a goal, `sim_time` simulated seconds.\n"
    )
    return (
        f"# twonav: {event.command}, {event.scene}, stage {event.stage}, seed {event.seed}\n{timelines}{body}{table}"
        "\nWritten with Rerun 0.41; use the viewer of the same version (`rerun FILE`).\n"
    )
