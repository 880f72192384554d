"""Runs diptych cases and loads their results as pandas tables with units in the column names."""

from .results import Results, load
from .running import InputError, RunError, binary, run

__all__ = ["InputError", "Results", "RunError", "binary", "load", "run"]
