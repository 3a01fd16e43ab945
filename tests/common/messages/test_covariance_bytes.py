"""A covariance in six bytes: as exact as anybody needs it, and never one that cannot be."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.errors import MessageError
from common.messages.wire_form import LEAST_M, STEP, WHOLE, pack_covariance, unpack_covariance

deviations = st.floats(2 * LEAST_M, 0.9)
UPPER = np.triu_indices(3)


def packed_and_back(matrix: np.ndarray) -> np.ndarray:
    found = np.zeros((3, 3))
    found[UPPER] = unpack_covariance(pack_covariance(tuple(matrix[UPPER].tolist())))
    return found + np.triu(found, 1).T


@given(st.tuples(deviations, deviations, deviations), st.integers(0, 2**31))
def test_deviations_and_correlations_come_back_to_half_a_step(sigma: tuple[float, float, float], seed: int) -> None:
    factor = np.random.default_rng(seed).normal(size=(3, 3))
    correlation = factor @ factor.T
    correlation /= np.sqrt(np.outer(np.diag(correlation), np.diag(correlation)))
    found = packed_and_back(correlation * np.outer(sigma, sigma))
    back = np.sqrt(np.diag(found))
    assert np.log(back / np.array(sigma)) == pytest.approx(0.0, abs=0.501 * STEP)
    assert found / np.outer(back, back) == pytest.approx(correlation, abs=0.501 / WHOLE)


def test_packing_again_changes_nothing() -> None:
    once = unpack_covariance(pack_covariance((3e-6, 1e-6, -2e-6, 5e-4, 2e-5, 8e-6)))
    assert unpack_covariance(pack_covariance(once)) == once


@pytest.mark.parametrize("variance", [0.0, 1e-14, 1e3])
def test_what_is_out_of_scale_is_clipped(variance: float) -> None:
    found = unpack_covariance(pack_covariance((variance, 0.0, 0.0, variance, 0.0, variance)))
    assert math.sqrt(found[0]) == pytest.approx(LEAST_M if variance < 1 else LEAST_M * math.exp(255 * STEP))


def test_what_is_no_covariance_is_refused() -> None:
    for bad in (math.nan, math.inf, -1e-6):
        with pytest.raises(MessageError):
            pack_covariance((bad, 0.0, 0.0, 1e-6, 0.0, 1e-6))
    for packed in (b"", bytes(5), b"\x05\x05\x05\x80\x00\x00", "text", None):
        with pytest.raises(MessageError):
            unpack_covariance(packed)


def test_a_covariance_far_beyond_its_variances_is_clipped() -> None:
    assert pack_covariance((5e-324, 1e300, -1e300, 5e-324, 1e300, 1e-6))[3:] == bytes((127, 129, 127))
