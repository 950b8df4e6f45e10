"""What people see of results: figures, pages, tables, reports."""
