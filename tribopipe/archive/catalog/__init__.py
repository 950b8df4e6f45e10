"""The catalog: what a list states about every run, kept in SQLite next to the archive and derived from it."""
