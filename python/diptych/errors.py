"""Exceptions, with the messages of the program."""


class InputError(ValueError):
    """The case or the command is at fault: nothing was computed and nothing written."""


class RunError(RuntimeError):
    """An engine stopped on the way. `results` holds what the program has written until then, or is None."""

    def __init__(self, message: str, results=None):
        super().__init__(message)
        self.results = results
