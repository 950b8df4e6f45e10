"""Wear laws of tribopipe, one in each module; the entry points in pyproject.toml declare them."""
