"""Scenes of spheres with soft and hard collisions: engines, runs and comparisons of cases, results as pandas tables.

Column names of tables end with the unit of the column. All numbers of `Simulation` are in SI units.
"""

from importlib import import_module

# modules are loaded at the first use of a name, so that the command `diptych` starts without numpy and pandas
_MODULES = {
    "InputError": "errors",
    "Results": "results",
    "RunError": "errors",
    "Simulation": "_engine",
    "compare": "running",
    "judge": "running",
    "load": "results",
    "run": "running",
    "sweep": "running",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module 'diptych' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__():
    return [*globals(), *__all__]
