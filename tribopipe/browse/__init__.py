"""The archive in a web browser: a local server, and the client it serves."""
