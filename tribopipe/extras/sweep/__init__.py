"""One computation done many times over: choices of evaluation, predictions, virtual tests."""
