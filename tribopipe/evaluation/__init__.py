"""Evaluation of signals and post-test measurements: preprocessing, checks, drift, friction, wear, studies.

Knows no file and no picture. Imports ``contacts``, ``results`` and what these use.
"""
