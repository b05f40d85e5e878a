"""Errors that a user can fix: what was given, what is allowed, what to do."""


class InputError(ValueError):
    """Bad input, found before a run starts. Scripts print it and exit with code 2."""


class RunError(RuntimeError):
    """A run that had to stop, for example because the state became non-finite."""
