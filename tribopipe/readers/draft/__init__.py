"""From the files of an instrument to a run folder: run.toml is filled with all that they and the lab show."""
