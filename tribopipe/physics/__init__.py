"""Equations of friction, contact and wear: numbers in SI in, numbers out.

Imports numpy, scipy and ``base`` alone: no document, no record, no file.
"""
