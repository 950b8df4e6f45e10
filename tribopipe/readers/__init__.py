"""From the instrument's own files to a run: readers parse, one place harmonizes."""
