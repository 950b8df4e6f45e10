"""Each kind of contact: from what run.toml states of it to the physics of its wear.

Imports ``documents``, ``physics`` and, of ``results``, what concerns a contact.
"""
