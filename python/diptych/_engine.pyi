from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

def main(arguments: Sequence[str]) -> int:
    """Runs the program with a command line, whose first word is the name of the program; returns its exit code."""

class Simulation:
    """One case with one collision model. All numbers are in SI units.

    Arrays share the memory of the engine and cannot be written. An array shows one instant: before the engine moves
    the particles, it leaves the memory to the arrays that still exist and goes on with a copy; without such arrays
    nothing is copied. Rows are in the order of the engine, which may change; `ids` says which particle a row is.
    """

    def __init__(
        self,
        case: str | PathLike[str] | None = None,
        *,
        text: str | None = None,
        model: Literal["soft", "hard", "hybrid", "dsmc"] | None = None,
        set: Mapping[str, object] | None = None,
        seed: int | None = None,
        threads: int | None = None,
    ) -> None:
        """Makes the particles of a case at their start.

        case: path of a case, or the name of a built-in one. text: text of a case, instead.
        model, seed: instead of those of the case. set: keys and values as they are typed, {"run.duration": "2 s"}.
        threads: number of threads, all processors by default; results do not depend on it.

        Raises InputError with the message of the program, which names file, line, value and remedy.
        """

    def run_until(
        self,
        time: float,
        observer: Callable[[Simulation], Any] | None = None,
        *,
        every: Literal["sample", "window"] | float | None = None,
    ) -> None:
        """Runs until `time` [s], without the lock of the interpreter.

        observer is called at the ends of samples of the case (every="sample", the default), of windows
        (every="window"), or after every so many seconds of simulated time, and at `time`. A run with calls at samples
        has the bits of `diptych run`; looking at other times divides kicks of drag, which changes rounding.

        Raises RunError if the engine cannot go on, and what a signal raises, such as KeyboardInterrupt.
        """

    def step(self, windows: int = 1) -> None:
        """Runs windows of the schedule: times between two exchanges of momentum with the gas."""

    def state(self) -> pd.DataFrame:
        """Particles in the order of their ids, within the box; column names end with units. A copy."""

    @property
    def time(self) -> float:
        """[s] simulated time."""
    @property
    def duration(self) -> float:
        """[s] duration that the case asks for."""
    @property
    def model(self) -> str:
        """Name of the collision model."""
    @property
    def windows(self) -> int:
        """Number of completed windows."""
    @property
    def species_names(self) -> list[str]:
        """Names of the species, by their index in `species`."""
    @property
    def size(self) -> tuple[float, float, float]:
        """[m] edges of the box along x (spanwise), y (wall-normal) and z (streamwise)."""
    @property
    def kinetic_energy(self) -> float:
        """[J] translational kinetic energy of all particles."""
    @property
    def pair_impacts(self) -> int:
        """Number of impacts between particles since the start."""
    @property
    def wall_impacts(self) -> int:
        """Number of impacts at walls since the start."""
    @property
    def positions(self) -> NDArray[np.float64]:
        """[m] centres, shape (N, 3). They may lie outside periodic sides; `state` brings them back."""
    @property
    def velocities(self) -> NDArray[np.float64]:
        """[m/s] velocities, shape (N, 3)."""
    @property
    def spins(self) -> NDArray[np.float64] | None:
        """[rad/s] spins, shape (N, 3); None if spheres do not rotate."""
    @property
    def radii(self) -> NDArray[np.float64]:
        """[m] radii, shape (N,)."""
    @property
    def masses(self) -> NDArray[np.float64]:
        """[kg] masses, shape (N,)."""
    @property
    def species(self) -> NDArray[np.uint16]:
        """Index of the species of each particle, shape (N,)."""
    @property
    def ids(self) -> NDArray[np.uint32]:
        """Number of each particle in the initial state, shape (N,)."""
