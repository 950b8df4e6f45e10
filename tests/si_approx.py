"""`pytest.approx` for numbers in SI: wear coefficients are 1e-14 m²/N and volumes 1e-12 m³.

pytest allows for an absolute difference of 1e-12, by which any two of them would be equal.
"""

import pytest

DUST = 1e-30
"""Absolute difference of two zeros in SI."""

type(pytest.approx(1.0)).DEFAULT_ABSOLUTE_TOLERANCE = DUST
