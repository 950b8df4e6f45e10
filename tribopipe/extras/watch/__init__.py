"""A folder that instruments write into is watched: each export that has settled becomes a run, once."""
