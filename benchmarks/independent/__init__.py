"""A simulator of wear tests that shares no code with tribopipe: own wear, own noise, own disturbances.

What it records reaches tribopipe as a user's would: columns of numbers and a run.toml (`runs.py`).
"""
