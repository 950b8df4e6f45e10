"""Several runs under one wear law: fit some, predict others, and say where the law does not hold."""
