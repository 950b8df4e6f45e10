"""Each kind of contact: from what run.toml states of it to the physics of its wear.

Imports ``documents`` and ``physics``.
"""
