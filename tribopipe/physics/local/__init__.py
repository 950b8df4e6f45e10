"""Wear where it happens: Archard's law at every point of a contact that is solved anew as the surfaces wear."""
