"""From tribometer run folders to wear laws that can be trusted."""

__version__ = "0.1.0"
