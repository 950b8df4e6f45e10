"""The version of tribopipe."""

VERSION = "0.2.0"
