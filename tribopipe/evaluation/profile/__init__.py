"""A profile across a wear track or a worn tip: its unworn surface, the groove, what is piled up next to it."""
