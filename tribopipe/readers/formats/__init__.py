"""One file a format; the docstring of each says what such a file holds and how it is written."""
