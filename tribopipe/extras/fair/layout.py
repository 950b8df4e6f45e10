"""Where things lie in a crate."""

METADATA = "ro-crate-metadata.json"
PREVIEW = "ro-crate-preview.html"
ARCHIVE = "archive"
"""A folder that is an archive of its own."""
DATASET = "about/dataset.toml"
