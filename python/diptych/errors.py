"""Exceptions, with the messages of the program."""


class InputError(ValueError):
    """The case or the command has a mistake: nothing was computed, and nothing was written."""


class RunError(RuntimeError):
    """An engine stopped before the end of the run. `results` has the results that were written until then, or is None."""

    def __init__(self, message: str, results=None):
        super().__init__(message)
        self.results = results
