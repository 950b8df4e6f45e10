"""Presentation of results: figures, pages, tables, reports."""
