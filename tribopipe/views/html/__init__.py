"""Reports as single HTML files, for sending to others."""
