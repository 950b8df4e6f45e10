"""From signals and post-test measurements to results: preprocessing, checks, drift, friction, wear, studies.

Knows no file and no picture. Imports ``contacts``, ``results`` and what these use.
"""
