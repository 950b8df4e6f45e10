"""What everything may use: units, errors, files, plug-ins, arrays, tasks in parallel.

Imports no other package of tribopipe.
"""
