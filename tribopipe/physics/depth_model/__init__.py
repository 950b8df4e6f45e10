"""Contributions to the depth signal other than wear, in one model fitted together with the post-test measurement.

Contains the model alone: block averages of a reading, its terms and their posterior. It knows no contact, no wear law
and no document; the wear at each block comes in as a function of the wear depth at the end.
"""
