"""Contact by finite elements, whose mesh moves as the surface wears as the Wear-Processor does (paper, Section 3.2)."""
