"""Wear depth, wear volume and specific wear rate of each body from post-test measurements."""
