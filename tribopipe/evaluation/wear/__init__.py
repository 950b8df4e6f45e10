"""Wear laws and the Global Incremental Wear Model."""
