"""Runs diptych cases and loads their results as pandas tables with units in the column names."""

from .results import Results, load
from .running import InputError, RunError, binary, judge, run

__all__ = ["InputError", "Results", "RunError", "binary", "judge", "load", "run"]
