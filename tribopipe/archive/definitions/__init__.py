"""What archived files hold, declared once: NeXus definitions are written from it, and files are held against it."""
