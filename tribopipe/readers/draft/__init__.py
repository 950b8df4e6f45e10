"""Run folders from instrument files; run.toml is filled from the files and from the lab's own entries."""
