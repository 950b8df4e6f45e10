"""`python -m tribopipe`: the command line where its script is not on the path."""

from tribopipe.cli.entry_point import main

if __name__ == "__main__":
    main()
