"""The history of an archive: one line for each write, chained by checksums, by which loss and exchange are seen."""
