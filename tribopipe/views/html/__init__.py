"""Reports in one HTML file that can be sent to someone."""
