"""The version of tribopipe."""

VERSION = "0.1.0"
