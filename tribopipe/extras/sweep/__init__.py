"""Repeated evaluations: choices of evaluation, predictions, virtual tests."""
