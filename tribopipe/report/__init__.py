"""Figures of a run and its results."""
