"""What was measured on the specimens, turned into depth, volume and specific wear rate of each body."""
