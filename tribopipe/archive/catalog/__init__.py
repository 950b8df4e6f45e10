"""The catalogue: what a list says of every run, kept in SQLite beside the archive and derived from it."""
