"""A `FunctionCall` returns what CasADi's plain call returns."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from estimation.function_call import FunctionCall
from models.arrays import Array


def example() -> ca.Function:
    """Vector, matrix and scalar in; vector, matrix, row, scalar out; none symmetric."""
    v, M, s = ca.SX.sym("v", 3), ca.SX.sym("M", 2, 3), ca.SX.sym("s")
    results = [M @ v, s * M, (M @ ca.diag(v))[0, :], ca.sumsqr(v) * s]
    return ca.Function("example", [v, M, s], [ca.densify(r) for r in results])


def plain(function: ca.Function, *arguments: object) -> list[Array]:
    return [np.asarray(result) for result in function(*arguments)]


def test_equals_the_plain_call() -> None:
    function, rng = example(), np.random.default_rng(1)
    call = FunctionCall(function)
    for _ in range(5):
        v, M, s = rng.standard_normal(3), rng.standard_normal((2, 3)), rng.standard_normal()
        vector, matrix, row, scalar = call(v, M, s)
        wanted = plain(function, v, M, s)
        assert vector.shape == (2,)
        assert matrix.shape == (2, 3)
        assert row.shape == (1, 3)
        assert scalar.shape == (1,)
        for result, expected in zip((vector, matrix, row, scalar), wanted, strict=True):
            np.testing.assert_array_equal(result.reshape(expected.shape), expected)


def test_takes_any_memory_layout() -> None:
    function = example()
    call, M = FunctionCall(function), np.arange(6.0).reshape(3, 2).T
    strided = np.arange(6.0)[::2]
    np.testing.assert_array_equal(call(strided, M, 2.0)[1], 2.0 * M)
    np.testing.assert_array_equal(call(strided[:, None], M, [[2.0]])[0], M @ strided)


def test_results_are_copies() -> None:
    call = FunctionCall(example())
    v, M = np.ones(3), np.ones((2, 3))
    first = call(v, M, 1.0)
    kept = [result.copy() for result in first]
    call(2 * v, 3 * M, 5.0)
    for result, expected in zip(first, kept, strict=True):
        np.testing.assert_array_equal(result, expected)


def test_wrong_arguments_are_refused() -> None:
    call = FunctionCall(example())
    with pytest.raises(ValueError, match="argument"):
        call(np.ones(3), np.ones((2, 3)))
    with pytest.raises(ValueError, match="shape"):
        call(np.ones(4), np.ones((2, 3)), 1.0)


@pytest.mark.parametrize("wrong", [np.ones(1), np.array(2.0), np.ones((1, 1))])
def test_an_argument_is_never_spread_over_a_vector(wrong: Array) -> None:
    """CasADi's own trap: a shape that disagrees is broadcast in silence."""
    with pytest.raises(ValueError, match="shape"):
        FunctionCall(example())(wrong, np.ones((2, 3)), 1.0)


def test_sparse_arguments_and_results_are_dense_outside() -> None:
    """A buffer of CasADi's has one entry per nonzero, not per entry."""
    L = ca.SX.sym("L", ca.Sparsity.lower(3))
    call = FunctionCall(ca.Function("sparse", [L], [2 * L, L @ ca.SX([1, 10, 100])]))
    value = np.array([[1.0, 0.0, 0.0], [2.0, 3.0, 0.0], [4.0, 5.0, 6.0]])
    doubled, product = call(value)
    np.testing.assert_array_equal(doubled, 2 * value)
    np.testing.assert_array_equal(product, value @ [1, 10, 100])
