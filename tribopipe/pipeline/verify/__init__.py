"""Whether an archive is sound: every byte as it was written, every number as it follows from what it stands on."""
