"""Readers of instrument files, and the conversion of their tables to the signals of a run in SI."""
