"""Additions to the pipeline: live tests, watched folders, sweeps, simulation, Abaqus, research data."""
