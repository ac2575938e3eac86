from twonav_cli.terminal.survey_report import survey_sentences

METRICS = {
    "keyframes": 209, "driven_m": 30.63, "simulated_s": 107.6, "collisions": 0, "pose_mean_m": 0.01685,
    "pose_mean_deg": 0.162, "pose_worst_m": 0.03268, "agreeing": 0.99975, "hidden_cells": 7090,
    "maze_cells_blocked_by_us": 0, "maze_cells_freed_by_us": 0, "maze_blocked_by_us": [], "maze_freed_by_us": [],
}  # fmt: skip


def test_a_survey_is_told_with_its_units_and_what_comes_next() -> None:
    told = "\n".join(survey_sentences(METRICS, "kitchen"))
    for words in ("31 m driven", "0.017 m and 0.16 degrees", "at worst 0.033 m", "99.98 %", "7,090 cells", "the same"):
        assert words in told
    assert "twonav train --stage maze --scene kitchen" in told


def test_cells_of_the_maze_that_differ_are_named_and_the_rest_is_counted() -> None:
    differing = {"maze_cells_blocked_by_us": 3, "maze_blocked_by_us": [[4, 7], [5, 7]]}
    differing |= {"maze_cells_freed_by_us": 1, "maze_freed_by_us": [[0, 2]]}
    told = survey_sentences(METRICS | differing, "kitchen")[3]
    assert told.endswith("3 more blocked: [4, 7], [5, 7], ...; 1 more free: [0, 2]")
