"""Contact of the two bodies: elastic start, and the depth that a worn volume makes of it."""
