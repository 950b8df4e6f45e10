"""Several runs under one wear law: fit some, predict others, and report where the law does not hold."""
