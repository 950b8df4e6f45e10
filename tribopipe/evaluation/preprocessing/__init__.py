"""Preprocessing of a run's signals, step by step as a recipe lists them. Raw signals are never changed."""
