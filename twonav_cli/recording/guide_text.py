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
5. **Belief** tells why it believed so. Violet floor at the blue arrow: the picture was right and the filter has not
   followed yet. Violet floor elsewhere: the picture looks like another place. Violet in several places: it did not
   know, and *Confidence* should be low.

## The map (metres, y up; row 0 of the maze is the top)
| colour | what |
|---|---|
| blue arrow, outline | where the robot is |
| magenta arrow | where the controller believes it is (odometry since the last estimate) |
| orange arrow | the estimate after the last look: the filter's, or without one the localizer's |
| violet floor | what the last picture says by itself: dark is likely (each shade is a factor of 1.6) |
| violet arrow | the pose of that picture alone, where a filter makes something else of it |
| violet dots with a number | other places where the robot could be, and their probability |
| red line | the error between is and believes |
| light blue line | way of this trial |
| orange dots | range finder (beams beyond its cut are left out) |
| black circle | the goal of this trial |

## The other tabs
* **Belief**: the map with the filter's particles (magenta dots), how sure the robot was after every look (the estimate,
  and the picture alone), how widely its belief was spread, and both errors. The simulator's truth has no belief.
* **Q-values**: value of the best action per cell and the greedy action, for the goal driven to and for every goal;
  bright is close to the goal. Unvisited cells keep their initial value.
* **TD errors**: per goal and cell, how wrong the value was at the latest visit; pink is what was never tried.
* **Learning**: TD error per goal (log10; in training the largest decides the next goal), actions per trial beside the
  shortest way, share of the last 20 trials that reached the goal, a lane per goal, and why each goal was chosen.
* **Controller**: the robot from above, always in the middle: candidate motions (dark is cheap, red would touch), the
  chosen one in black, and the local cost map. Candidates and cost map lie where the controller believes they lie.
* **Trials**: the last trials as a table; for programs every one is a row of `/trials`.
"""

_FLAT = """
## What went wrong, and why
The robot is its outline on the 5 cm map, driven by the same controller as in 3D. It knows where it is after every
action; within one it trusts odometry.
1. The recording opens on the end of the run: every failure is on the map and in the log, with its **cause** and the
   **evidence**. The marked stretch of the time line is the last failure; space plays, the arrow keys step.
2. The lanes under the map show goal, outcome and cause of every trial. Click into a lane to go there.
3. **Controller** shows why an action ended blocked: candidate motions (dark is cheap, red would touch), the chosen one
   in black, and the local cost map. In tight corners every candidate that turns or leads on may be red.

## The map (metres, y up; row 0 of the maze is the top)
| colour | what |
|---|---|
| blue arrow, outline | where the robot is |
| magenta arrow | where the controller believes it is: odometry since the action began |
| red line | the error between is and believes |
| light blue line | way of this trial |
| orange dots | range finder |
| black circle | the goal of this trial |

The other tabs are those of every learning run: **Q-values**, **TD errors**, **Learning**, **Trials**. Training writes
the actions only; playing and `twonav evaluate --record` every control period.
"""

_MAZE = """
## How to read it
1. **Story** answers which goal was trained when, and why that one. Each goal has a lane: waiting, current, learned. A
   goal stays current until it is learned; then the one with the largest TD error among the others is next. The log
   says so with the two largest numbers; the diamonds on the curves are these choices. Click a line of the log to move
   the cursor there; the table below it shows every goal's TD error at the moment of the choice.
2. The TD error of a goal is the mean over all cells and actions (log10 in the plot). All curves fall together, because
   every action teaches every goal. Early on what was never tried weighs most: such an entry counts 10,000.
3. *Actions per trial* are means over one trial from each start, beside the shortest way. They rise when a new goal
   begins, and fall to the shortest way while it is learned.
4. **Q-values**: value of the best action per cell and the greedy action, for every goal. Drag the cursor from trial 0
   on and watch the values of all goals grow at once; most of it happens in the first hundred trials (the tables are
   recorded after trials 1, 2, 3, 5, 8, ... and whenever a goal is learned). Unvisited cells keep their initial value.
5. **TD errors**: per goal and cell, the mean over the four actions of how wrong the value was at the latest visit, in
   powers of ten. Pink cells have actions that were never tried. Cells that stay bright were rarely visited since:
   that is where this goal still has something to learn. Point at a cell to read its number.

## The other tabs
* **Maze**: the maze (row 0 is the top), the way of single trials where they were recorded, actions of every trial, and
  the share that reached the goal (means over a few trials in a long run).
* **Trials**: one row per trial (of a long run only some). For programs: `/trials`, `/choices` (every choice of a goal
  with its reason and the TD errors behind it), `/learned` and `/totals`; `twonav inspect FILE` prints them.
"""

_FIT = """
## How to read it
* **Curves**: loss and learning rate per batch, and what was measured on the validation frames, by unit.
* The timelines are `batch`, `epoch` and `sim_time`; switch at the lower left.
"""

_MAP = """
## What went wrong, and why
1. The recording opens on the last keyframe, with the whole map. Drag the cursor to the left (or press space) and watch
   it grow: a wall that is drawn twice, or a room that is turned, begins at one keyframe.
2. Red dots with a number are the keyframes where something went wrong; the log says what. **No match**: scan matching
   failed, so that particles kept odometry. **Jump**: scan matching moved the robot far from where odometry led.
   **Lost** (only in a simulation): the best particle is far from where the robot is.
3. Few effective particles, drawn again and again, mean that one particle decides everything: what it gets wrong, stays.
   A map that breaks where a loop closes needs more particles; one that breaks in a long corridor needs better odometry.
4. When another particle becomes the best, map and way are its own: the log says how far the way moved.

## The map (metres, y up; the robot starts at 0, 0 unless a scene says otherwise)
| colour | what |
|---|---|
| white, black, grey | free, occupied, never seen |
| magenta arrow, line | the best particle, and the way that it believes to have come |
| orange arrow, line | where odometry alone leads |
| blue arrow, line; red line | where the robot is (only in a simulation); the error |
| green dots | the scan of this keyframe, where the best particle believes it to lie |
| small arrows | all particles, before they are drawn again: bright ones weigh most |

The picture of the map and the ways are drawn every few keyframes; everything else at every one.

## The curves
* **Particles**: the effective number, 1 / (sum of squared weights); below half of all, particles are drawn again.
* **Correction of odometry's guess**: how far scan matching moved it, from one keyframe to the next.
* **Spread**: standard deviation over the particles. It grows in unknown land and shrinks where a loop closes.
* **Distance from odometry alone**: what all corrections add up to.

`keyframe` counts the scans that went into the map, `time` is seconds since the first scan. For programs: `/keyframes`
holds these numbers of every keyframe, `/drawings` the size of the map; `twonav inspect FILE` sums them up.
"""


def about(event: RunStarted, kind: str) -> str:
    """Return the text of the "About" tab in Markdown."""
    settings = "\n".join(f"| {name} | {value} |" for name, value in event.settings.items())
    table = f"\n## Settings\n| setting | value |\n|---|---|\n{settings}\n" if settings else ""
    body = {"2d": _FLAT, "3d": _DRIVE, "maze": _MAZE, "localizer": _FIT, "map": _MAP}[kind]
    timelines = (
        ""
        if kind in ("localizer", "map")
        else "\n`step` counts actions over the whole run, `trial` attempts at a goal, `sim_time` simulated seconds.\n"
    )
    return (
        f"# twonav: {event.command}, {event.scene}, stage {event.stage}, seed {event.seed}\n{timelines}{body}{table}"
        "\nWritten with Rerun 0.41; use the viewer of the same version (`rerun FILE`).\n"
    )
