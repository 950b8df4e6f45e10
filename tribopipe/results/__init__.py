"""Results of the stages, and runs in memory.

Archive, views and the command line know these, and not how they are computed. Imports ``documents`` and ``physics``.
"""
