"""Average of a correlated series by pymbar, to check the errors that `diptych judge` states."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Average:
    """Average of the steady part of a series. Times have the unit of the interval between two samples."""

    #: Time at which the steady part starts.
    start: float
    mean: float
    standard_error: float
    #: Integral correlation time: the mean over a long time L has the variance of a sample times 2 correlation_time/L.
    correlation_time: float


def average(values, interval: float) -> Average:
    """Average of a series sampled at every `interval`. The steady part, and the statistical inefficiency g = 2 time/interval,
    are those of pymbar (Chodera 2016, J. Chem. Theory Comput. 12, 1799). Needs pymbar: pip install ./python[statistics]."""
    from pymbar import timeseries

    series = np.asarray(values, dtype=float)
    start, inefficiency, independent = timeseries.detect_equilibration(series)
    steady = series[start:]
    error = float(steady.std(ddof=1) / np.sqrt(independent))
    return Average(start * interval, float(steady.mean()), error, 0.5 * float(inefficiency) * interval)
