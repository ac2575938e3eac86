import numpy as np
import pytest

from twonav_cli.mapping.three_by_three import root, root_of_inverse, solved, times

RNG = np.random.default_rng(8)


def positive(scale: float) -> np.ndarray:
    """Return a symmetric positive matrix [3, 3] whose rows are of different size, as cells and radians are."""
    part = RNG.standard_normal((3, 4)) * np.array([[1.0], [1.0], [scale]])
    return np.asarray(part @ part.T + 1e-3 * np.diag([1.0, 1.0, scale**2]))


MATRICES = [positive(scale) for scale in (1.0, 30.0, 0.03) for _ in range(4)]


@pytest.mark.parametrize("matrix", MATRICES)
def test_products_and_solutions_are_those_of_numpy(matrix: np.ndarray) -> None:
    vector = RNG.standard_normal(3)
    assert times(matrix, vector) == pytest.approx(matrix @ vector)
    assert solved(matrix, vector) == pytest.approx(np.linalg.solve(matrix, vector))


def test_a_product_takes_the_rows_of_a_matrix_that_is_not_symmetric() -> None:
    assert times(np.arange(9.0).reshape(3, 3), np.array([1.0, 10.0, 100.0])).tolist() == [210.0, 543.0, 876.0]


@pytest.mark.parametrize("matrix", MATRICES)
def test_the_root_is_the_cholesky_factor_of_numpy(matrix: np.ndarray) -> None:
    assert root(matrix) == pytest.approx(np.linalg.cholesky(matrix))


@pytest.mark.parametrize("matrix", MATRICES)
def test_the_root_of_the_inverse_gives_the_inverse_and_is_upper_triangular(matrix: np.ndarray) -> None:
    upper = root_of_inverse(matrix)
    assert upper @ upper.T @ matrix == pytest.approx(np.eye(3), abs=1e-8)
    assert np.array_equal(upper, np.triu(upper))
    assert (np.diag(upper) > 0).all()
