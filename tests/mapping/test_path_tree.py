import numpy as np

from twonav_cli.mapping.path_tree import PathTree


def poses(*xs: float) -> np.ndarray:
    return np.array([[x, 0.1 * x, 0.01 * x] for x in xs])


def xs_of(tree: PathTree, particle: int) -> list[float]:
    return [float(x) for x in tree.path_of(particle)[1][:, 0]]


def test_without_a_draw_every_particle_keeps_its_own_path() -> None:
    tree = PathTree(2)
    tree.grow(1.5, poses(10, 20))
    tree.grow(2.5, poses(11, 21))
    assert xs_of(tree, 0) == [10, 11]
    assert xs_of(tree, 1) == [20, 21]
    stamps, path = tree.path_of(1)
    assert stamps == [1.5, 2.5]
    assert np.array_equal(path, poses(20, 21))


def test_paths_through_two_draws_by_hand() -> None:
    tree = PathTree(3)
    tree.grow(0.0, poses(10, 20, 30))
    tree.grow(1.0, poses(11, 21, 31))
    tree.draw_again(np.array([1, 1, 2]))
    tree.grow(2.0, poses(12, 22, 32))
    tree.draw_again(np.array([0, 2, 0]))
    tree.grow(3.0, poses(13, 23, 33))
    assert xs_of(tree, 0) == [20, 21, 12, 13]
    assert xs_of(tree, 1) == [30, 31, 32, 23]
    assert xs_of(tree, 2) == [20, 21, 12, 33]


def test_a_draw_counts_at_once_and_two_in_a_row_follow_each_other() -> None:
    tree = PathTree(3)
    tree.grow(0.0, poses(10, 20, 30))
    tree.draw_again(np.array([2, 0, 0]))
    assert [xs_of(tree, particle) for particle in range(3)] == [[30], [10], [10]]
    tree.draw_again(np.array([1, 1, 0]))
    assert [xs_of(tree, particle) for particle in range(3)] == [[10], [10], [30]]


def test_many_draws_agree_with_paths_that_are_copied() -> None:
    rng, tree = np.random.default_rng(0), PathTree(5)
    copies = np.zeros((5, 0))
    for k in range(40):
        xs = rng.normal(size=5)
        tree.grow(float(k), poses(*xs))
        copies = np.column_stack([copies, xs])
        if k % 3 == 0:
            parents = rng.integers(5, size=5)
            tree.draw_again(parents)
            copies = copies[parents]
    assert np.array_equal([xs_of(tree, particle) for particle in range(5)], copies)


def test_a_path_does_not_change_with_the_poses_it_was_given() -> None:
    tree, given = PathTree(1), poses(10)
    tree.grow(0.0, given)
    given[:] = 99.0
    tree.path_of(0)[1][:] = 99.0
    assert xs_of(tree, 0) == [10]


def test_the_latest_stamp_is_that_of_the_last_keyframe() -> None:
    tree = PathTree(1)
    assert tree.latest_s == 0.0
    assert tree.path_of(0)[1].shape == (0, 3)
    tree.grow(7.5, poses(1))
    assert tree.latest_s == 7.5
