import numpy as np
import pytest

from twonav_cli.mapping.resampling import effective_number, normalised, systematic


class Fixed:
    """A generator that always draws the same number."""

    def __init__(self, value: float) -> None:
        self.value = value

    def random(self) -> float:
        return self.value


def drawn_with(weights: list[float], value: float) -> list[int]:
    chosen = systematic(np.array(weights), Fixed(value))  # type: ignore[arg-type]  # it only asks for random()
    return [int(particle) for particle in chosen]


def test_weights_sum_to_one_however_small_their_logarithms() -> None:
    assert normalised(np.log([1.0, 3.0, 4.0])) == pytest.approx([0.125, 0.375, 0.5])
    assert normalised(np.array([-5000.0, -5000.0 + np.log(3.0)])) == pytest.approx([0.25, 0.75])
    assert normalised(np.array([-1e5, 0.0])).tolist() == [0.0, 1.0]


def test_the_effective_number_by_hand() -> None:
    assert effective_number(np.full(8, 0.125)) == pytest.approx(8.0)
    assert effective_number(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0)
    assert effective_number(np.array([0.5, 0.25, 0.25])) == pytest.approx(8 / 3)


def test_particles_are_drawn_in_even_steps_through_the_weights() -> None:
    # One draw of 0.4 puts the marks at 0.1, 0.35, 0.6 and 0.85; the weights end at 0.1..., 0.5, 0.55 and 1.
    assert drawn_with([0.15, 0.35, 0.05, 0.45], 0.4) == [0, 1, 3, 3]
    assert drawn_with([0.15, 0.35, 0.05, 0.45], 0.9) == [1, 1, 3, 3]
    assert drawn_with([0.25, 0.25, 0.25, 0.25], 0.5) == [0, 1, 2, 3]
    assert drawn_with([0.0, 0.0, 1.0, 0.0], 0.999) == [2, 2, 2, 2]


def test_every_particle_gets_its_share_rounded_up_or_down() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        weights = normalised(rng.normal(size=12))
        copies = np.bincount(systematic(weights, rng), minlength=12)
        assert (np.abs(copies - 12 * weights) < 1).all()
        assert copies.sum() == 12


def test_copies_match_the_weights_on_average() -> None:
    rng = np.random.default_rng(1)
    weights = np.array([0.03, 0.52, 0.15, 0.3])
    copies = sum(np.bincount(systematic(weights, rng), minlength=4) for _ in range(4000)) / 4000
    assert copies == pytest.approx(4 * weights, abs=0.03)


def test_weights_that_do_not_quite_sum_to_one_name_no_particle_that_is_not_there() -> None:
    assert drawn_with([0.5, 0.5 - 1e-6], 0.9999999) == [0, 1]
    assert systematic(np.array([1.0]), np.random.default_rng(0)).tolist() == [0]


def test_more_places_than_particles_are_filled_in_even_steps_through_the_weights() -> None:
    drawn = systematic(np.array([0.1, 0.0, 0.6, 0.3]), np.random.default_rng(0), 1000)
    assert np.bincount(drawn, minlength=4).tolist() == pytest.approx([100, 0, 600, 300], abs=1)
