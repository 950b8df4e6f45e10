"""``python -m tribopipe``, for where the command is not on the PATH."""

from tribopipe.cli.entry_point import main

main()
