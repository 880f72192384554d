from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from .live import LivePage

def main(arguments: Sequence[str]) -> int:
    """Runs the program with a command line, whose first word is the name of the program. Returns the exit code."""

class Simulation:
    """One case with one collision model. All numbers are in SI units.

    Arrays share the memory of the engine and cannot be written. An array shows one instant: before the engine moves
    the particles, it leaves the memory to the arrays that still exist and goes on with a copy; without such arrays
    nothing is copied. Rows are in the order of the engine, which may change; `ids` says which particle a row is.
    """

    def __init__(
        self,
        case: str | PathLike[str] | Mapping[str, Any] | None = None,
        *,
        text: str | None = None,
        model: Literal["soft", "hard", "hybrid", "dsmc"] | None = None,
        set: Mapping[str, object] | None = None,
        seed: int | None = None,
        threads: int | None = None,
        positions: ArrayLike = ...,
        velocities: ArrayLike = ...,
        radii: ArrayLike = ...,
        species: Sequence[str | int] = ...,
        spins: ArrayLike = ...,
    ) -> None:
        """Makes the particles of a case at their start.

        case: path of a case, the name of a built-in one, or a dict with its tables: {"run": {"duration": "2 s"}, ...}.
        Values of a dict are as in case files ("2 mm"), and numbers without a unit are in SI. text: text of a case, in place
        of `case`.
        positions [m], velocities [m/s], spins [rad/s]: arrays (N, 3) of the particles at the start, in place of those of
        the case; velocities and spins are 0 without arrays. radii [m]: array (N,), where a kind has `sizes`, or in a dict
        neither `diameter` nor `sizes`. species: name or index of the kind of each particle, where there are several.
        model, seed: in place of those of the case. set: keys and values as they are typed, {"run.duration": "2 s"}.
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
        """Runs until `time` [s]. Other threads of Python may run meanwhile (the lock of the interpreter is released).

        observer(simulation) is called at every sample of the case, its instants of measurement (every="sample", the
        default), at the end of every window, the time between two exchanges with the gas (every="window"), or at equal
        intervals of simulated time (every=0.1: every 0.1 s). The last call is at `time`. A run with calls at samples has
        the bits of `diptych run`; calls at other times divide the kicks of drag, which changes rounding.

        Raises RunError if the engine cannot go on, and what a signal raises, such as KeyboardInterrupt.
        """

    def step(self, windows: int = 1) -> None:
        """Runs as many windows as `windows` states. A window is the time between two exchanges of momentum with the gas."""

    def state(self) -> pd.DataFrame:
        """Copy of the particles as a table, in the order of their ids, with positions within the box. Column names end with units."""

    def show(self) -> LivePage:
        """A page that shows the particles and curves over time while the simulation runs. In a notebook, the result shows the
        page; elsewhere, open its `url` in a browser. Only browsers on this machine can open the page, and they cannot change
        the simulation. The bits of runs do not depend on the page. It ends with the program or the simulation."""
    @property
    def drag(self) -> Callable[[Simulation], Any] | None:
        """Your own drag law: drag(simulation) returns the acceleration of each particle [m/s^2], shape (N, 3), rows
        in the order of `ids`. None, the default, means no such law. It acts in addition to the drag law of the case.

        It is called before the first window (time between two exchanges with the gas) and at the end of each window. Half
        of the kick (change of velocity) of a window is given before the motion and half after it. Positions and velocities
        are those at `time`, but velocities lack the correction of the last half-kick, which was made with the accelerations
        of the last call. The error is of second order in the window. Windows must be shorter than the response time; the
        key `run.window` sets their length.

        The law must depend on the state of the simulation alone. It cannot run or change the simulation. The ledger
        counts its work as drag. An exception stops the run at the end of a window, and the next run calls the law again.
        Raises TypeError if the object cannot be called. Runs raise ValueError if the array has another shape or a number
        is not finite.
        """
    @drag.setter
    def drag(self, function: Callable[[Simulation], Any] | None) -> None: ...
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
    def ledger(self) -> dict[str, float]:
        """[J] energies since the start: work of drag, gravity, walls, shear and a thermostat, energy through inlets and
        outlets, and energy that impacts dissipated. `residual_J` is the part of the change of the energy that these terms
        do not explain: rounding for hard spheres, errors of the time steps for soft spheres."""
    @property
    def pair_impacts(self) -> int:
        """Number of impacts between particles since the start."""
    @property
    def wall_impacts(self) -> int:
        """Number of impacts at walls since the start."""
    @property
    def positions(self) -> NDArray[np.float64]:
        """[m] centres, shape (N, 3). They may lie outside periodic sides; `state` gives them within the box."""
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
