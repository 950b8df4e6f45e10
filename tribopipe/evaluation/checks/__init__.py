"""Checks of a run before it is archived: small registered functions, each with one concern."""
