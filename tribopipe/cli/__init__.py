"""The command line: arguments in, a library call, its result rendered."""
