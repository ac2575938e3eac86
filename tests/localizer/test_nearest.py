import numpy as np

from twonav_cli.dataset.store import FrameStore
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.nearest import nearest_poses


def test_a_training_frame_is_nearest_to_itself(toy_store: FrameStore) -> None:
    training = toy_store.training()
    assert np.array_equal(nearest_poses(toy_store, training, training[::50]), toy_store.poses[training[::50]])


def test_the_most_alike_frame_is_nearer_than_a_random_one(toy_store: FrameStore) -> None:
    queries = toy_store.off_grid()
    found = error_metrics(nearest_poses(toy_store, toy_store.training(), queries), toy_store.poses[queries])
    other = error_metrics(toy_store.poses[toy_store.training()[: len(queries)]], toy_store.poses[queries])
    assert found["pos_median_m"] < 0.5 * other["pos_median_m"]


def test_frames_of_one_data_set_are_placed_by_those_of_another(
    toy_store: FrameStore, toy_grid_store: FrameStore
) -> None:
    queries = toy_grid_store.paper_test()
    found = nearest_poses(toy_store, toy_store.training(), queries, toy_grid_store)
    errors = error_metrics(found, toy_grid_store.poses[queries])
    chance = error_metrics(toy_store.poses[toy_store.training()[: len(queries)]], toy_grid_store.poses[queries])
    assert errors["pos_median_m"] < 0.5 * chance["pos_median_m"]
