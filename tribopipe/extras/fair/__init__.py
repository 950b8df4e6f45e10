"""Archived runs as data that others find, open and cite: RO-Crate, .eln, and the way back."""
