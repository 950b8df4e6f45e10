"""One file a format; the docstring of each states what such a file holds and how it is written."""
