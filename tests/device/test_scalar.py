"""The physics over plain numbers: singular values, comparisons and functions, as a device computes them."""

import ctypes
import itertools
from pathlib import Path

import numpy as np
import pytest
from device.compiled import library
from reference.snow import polar_svd
from verification.kernels.test_11_svd import KINDS, matrices

NUMBER = {"float32": ctypes.c_float, "float64": ctypes.c_double}


@pytest.fixture(scope="module")
def scalar(tmp_path_factory):
    """The library of scalar.cpp."""
    return library(Path(__file__).with_name("scalar.cpp"), tmp_path_factory.mktemp("scalar"))


def answers(function, precision, count, *numbers):
    """Return what a function of the library writes for numbers."""
    out = (NUMBER[precision] * count)()
    function(*(NUMBER[precision](a) for a in numbers), out)
    return np.array(out)


def of_matrices(scalar, name, F, count):
    """Return the numbers (n, count) that a function of the library writes for matrices F (n, 3, 3)."""
    out = np.empty((len(F), count), F.dtype)
    function = getattr(scalar, f"{name}_{F.dtype}")
    function(F.ctypes.data_as(ctypes.c_void_p), len(F), out.ctypes.data_as(ctypes.c_void_p))
    return out.astype(float)


def decomposed(scalar, F):
    """Return U (n, 3, 3), sigma (n, 3), V (n, 3, 3) of matrices."""
    out = of_matrices(scalar, "svd", F, 21)
    return out[:, :9].reshape(-1, 3, 3), out[:, 9:12], out[:, 12:].reshape(-1, 3, 3)


@pytest.mark.parametrize("kind", KINDS)
def test_svd_of_one_matrix(scalar, precision, eps, kind):
    """U diag(sigma) V^T = F with rotations U and V; errors as in test_11_svd.py, where they are derived."""
    F = matrices(kind, 200).astype(precision)
    U, sigma, V = decomposed(scalar, F)
    size = np.linalg.norm(F.astype(float), axis=(1, 2))[:, None, None] + 1e-300
    error = (U * sigma[:, None, :]) @ np.swapaxes(V, 1, 2) - F
    np.testing.assert_allclose(error / size, 0, atol=30 * eps)
    for rotation in (U, V):
        np.testing.assert_allclose(np.linalg.det(rotation), 1, atol=60 * eps)


def test_sign_of_an_inverted_matrix(scalar, precision, eps):
    """diag(1, 1, -0.5) has the singular values 1, 1, -0.5."""
    F = np.diag([1.0, 1.0, -0.5])[None].astype(precision)
    np.testing.assert_allclose(decomposed(scalar, F)[1], [[1, 1, -0.5]], atol=4 * eps)


@pytest.mark.parametrize("kind", ["random", "near identity", "identity", "inverted", "rotation", "two equal"])
def test_stretches(scalar, precision, eps, kind):
    """Laws see the singular values of one matrix in any order, to the rounding of F^T F - I.

    The sign of an inverted F is in them: a comparison that is lost (`a | b` of two bools is an int) would
    take it for one near the identity, and give |sigma|.
    """
    F = matrices(kind, 200).astype(precision)
    exact = np.sort(polar_svd(F.astype(float))[1], axis=1)
    found = np.sort(of_matrices(scalar, "stretches", F, 3), axis=1)
    size = np.abs(exact).max(axis=1, keepdims=True)
    np.testing.assert_allclose(found / size, exact / size, rtol=0, atol=60 * eps)


@pytest.mark.parametrize(("a", "b"), [*itertools.product([-2.5, 0.0, 0.25, 3.0], repeat=2)])
def test_comparisons(scalar, precision, a, b):
    """Joined comparisons of numbers choose as Python's `or`, `and` and `not` do."""
    less, zero = a < b, a == 0
    expected = [less, less or zero, less and zero, not (less or zero), a if less or zero else b]
    expected += [min(a, b), max(a, b), abs(a), min(max(a, -1), 1), a, b]
    found = answers(getattr(scalar, f"compare_{precision}"), precision, 11, a, b)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("a", [1e-6, 0.3, 1.0, 4.7, 20.0])
def test_functions(scalar, precision, eps, a):
    """Functions of one number keep their digits: 3 eps, as those of packs."""
    a = float(np.dtype(precision).type(a))
    expected = [f(a) for f in (np.exp, np.expm1, np.log1p, np.sinh, np.arcsinh, np.sqrt)]
    expected += [1 / np.sqrt(a), 1 / np.sqrt(a), np.floor(a), 1 / a]
    found = answers(getattr(scalar, f"functions_{precision}"), precision, 10, a)
    np.testing.assert_allclose(found, expected, rtol=3 * eps)
