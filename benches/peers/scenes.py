"""The scenes both sides run, and their common start as a data file for LAMMPS and LIGGGHTS."""
import csv
import math
import shutil
from dataclasses import dataclass
from pathlib import Path

import measure
from measure import WORK

HERE = Path(__file__).resolve().parent
BOX = (0.120, 0.040, 0.064)  # [m] as in the cases
DENSE_EDGE = 15.19e-3  # [m] of the cube of dense.toml

# The frozen gas of both sides: U = u_tau (ln(y u_tau / nu) / kappa + B), y from the nearer wall, with the friction velocity
# of `diptych fluid cases/channel-d.toml`. A formula, because LAMMPS has no table that a script could look up at speed.
FRICTION_VELOCITY = 0.7729  # [m/s]
VISCOSITY = 1.515e-5  # [m2/s] models/fluids/air.toml
KAPPA, INTERCEPT = 0.41, 5.0  # [-] usual constants of the smooth wall (Coles 1956)


@dataclass
class Scene:
    """A scene with drag; `step` [s] is the peer's, `frame` [m/s] the mean velocity the peer's frame moves with."""
    name: str
    case: Path
    diameter: float
    density: float
    stiffness: float
    settle: float
    step: float
    skin: float
    frame: float


D = Scene("d", HERE / "d.toml", 406e-6, 1038, 3000, 0.5, 7.5e-7, 2.5e-4, 14.0)
F = Scene("f", HERE / "f.toml", 1.5e-3, 1032, 5000, 3.0, 4e-6, 1e-3, 10.0)

# Steps between impulses: 1.5e-4 s and 4e-4 s, somewhat less than the window of our own engines. verify.py bounds their error.
KICKS = {"d": 200, "f": 100}


def log_law(y):
    """[m/s] the gas at y [m] from the lower wall."""
    wall = min(y, BOX[1] - y)
    return FRICTION_VELOCITY * (math.log(wall * FRICTION_VELOCITY / VISCOSITY) / KAPPA + INTERCEPT)


def write_log_law(path):
    """A table so fine that a monotone cubic through it keeps the formula to 1e-7: nodes 0.5 % apart in distance from the
    wall, from a quarter of the smaller radius on, where no centre comes. The formula has an edge at the centre plane, which the
    cubic rounds off: towards it the spacing halves twelve times."""
    nearest, ratio, centre = 5e-5, 1.005, BOX[1] / 2
    count = math.ceil(math.log(centre / nearest) / math.log(ratio))
    half = [nearest * (centre / nearest) ** (k / count) for k in range(count)]
    half += [centre - (centre - half[-1]) / 2**k for k in range(1, 13)]
    nodes = half + [centre] + [BOX[1] - y for y in reversed(half)]
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["y_m", "U_m_s"])
        table.writerows([repr(y), repr(log_law(y))] for y in nodes)


def settled(scene):
    """The case in a folder of its own with its gas and a settled start; made once and kept."""
    folder = WORK / scene.name
    case, start = folder / scene.case.name, folder / "start.csv"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(scene.case, case)
    write_log_law(folder / "log-law.csv")
    if (folder / "settled").exists():
        return case
    random = measure.ROOT / "cases" / f"channel-{scene.name}.toml"
    keep = ["--save-state"]
    measure.diptych(random, f"{scene.name}-random", "hard", {"run.duration": "0 s", "run.average_from": "0 s"}, 1, keep)
    shutil.copy(WORK / f"{scene.name}-random" / "state.csv", start)
    print(f"settling scene {scene.name} for {scene.settle} s with the hard engine, once", flush=True)
    measure.diptych(case, f"{scene.name}-settled", "hard", {"run.duration": f"{scene.settle} s"}, 1, keep)
    shutil.copy(WORK / f"{scene.name}-settled" / "state.csv", start)
    (folder / "settled").touch()
    return case


def dashpot(restitution):
    """[1/s] constant of the dashpot over the effective mass, 2 zeta omega_0, between two spheres of D."""
    effective_mass = D.density * math.pi / 6 * D.diameter**3 / 2
    ratio = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    return 2 * ratio * math.sqrt(D.stiffness / effective_mass)


def write_data(state, density, frame, path, box=BOX):
    """A `state.csv` as a data file, seen from a frame that moves with `frame` [m/s] along z; returns the particles."""
    with open(state, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    with open(path, "w") as file:
        file.write(f"start\n\n{len(rows)} atoms\n1 atom types\n\n")
        for axis, length in zip("xyz", box):
            file.write(f"0 {length} {axis}lo {axis}hi\n")
        file.write("\nAtoms\n\n")
        for k, row in enumerate(rows, 1):
            file.write(f"{k} 1 {row['diameter']} {density} {row['x']} {row['y']} {row['z']}\n")
        file.write("\nVelocities\n\n")
        for k, row in enumerate(rows, 1):
            file.write(f"{k} {row['vx']} {row['vy']} {float(row['vz']) - frame!r} 0 0 0\n")
    return len(rows)


def drag_variables(scene):
    """Variables of `drag.lmp` and `drag.liggghts` for a scene, without step counts."""
    return {
        "data": WORK / f"{scene.name}.data", "d": scene.diameter, "rho": scene.density, "kn": scene.stiffness,
        "dt": scene.step, "skin": scene.skin, "frame": scene.frame, "nu": VISCOSITY, "ut": FRICTION_VELOCITY,
        "kappa": KAPPA, "intercept": INTERCEPT, "H": BOX[1],
    }
