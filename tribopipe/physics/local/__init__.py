"""Wear where it happens: Archard's law at every point of a contact that is solved again as the surfaces wear."""
