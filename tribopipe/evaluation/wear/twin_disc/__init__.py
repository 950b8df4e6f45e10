"""Wear of two discs: both wear coefficients of a run, and predictions from them."""
