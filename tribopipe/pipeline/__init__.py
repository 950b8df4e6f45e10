"""The steps of a run in their order, on an archive: process, studies, verify, reproduce."""
