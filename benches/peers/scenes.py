"""Scenes that our program and its peers run, and their common start as a data file for LAMMPS and LIGGGHTS."""
import csv
import math
import shutil
from dataclasses import dataclass
from pathlib import Path

import measure
from measure import WORK

HERE = Path(__file__).resolve().parent
BOX = (0.120, 0.040, 0.064)  # [m] edges of the box, as in d.toml and f.toml
DENSE_EDGE = 15.19e-3  # [m] edge of the cube of dense.toml

# The gas of both programs: U = u_tau (ln(y u_tau / nu) / kappa + B) at the distance y from the nearer wall, with the friction velocity
# of `diptych fluid cases/channel-d.toml`. It is a formula, because a script of LAMMPS cannot look up a table fast enough.
FRICTION_VELOCITY = 0.7729  # [m/s]
VISCOSITY = 1.515e-5  # [m2/s] kinematic viscosity of models/fluids/air.toml
KAPPA, INTERCEPT = 0.41, 5.0  # [-] usual constants of the smooth wall (Coles 1956)


@dataclass
class Scene:
    """A scene with drag. LAMMPS has the time step `step` [s], and a frame of reference that moves with the velocity `frame` [m/s] along the flow."""
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

# Number of LAMMPS steps between two kicks of drag: 1.5e-4 s and 4e-4 s, somewhat less than our windows. verify.py bounds the error of these kicks.
KICKS = {"d": 200, "f": 100}


def log_law(y):
    """[m/s] velocity of the gas at the distance y [m] from the lower wall."""
    wall = min(y, BOX[1] - y)
    return FRICTION_VELOCITY * (math.log(wall * FRICTION_VELOCITY / VISCOSITY) / KAPPA + INTERCEPT)


def write_log_law(path):
    """Writes a table of the gas velocity, so fine that a monotone cubic through its nodes agrees with the formula within 1e-7. Distances of
    neighbouring nodes from the wall differ by 0.5 %. The first node is at a quarter of the smaller radius, nearer than any centre can be. The
    formula has a kink at the centre plane, which a cubic rounds off, so towards this plane the spacing of the nodes halves twelve times."""
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
    """Path of the case in its own folder, with the table of its gas and a settled start. The folder is made once and kept."""
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
    """[1/s] constant of the dashpot over the effective mass, 2 zeta omega_0, between two spheres of case D with the given restitution."""
    effective_mass = D.density * math.pi / 6 * D.diameter**3 / 2
    ratio = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    return 2 * ratio * math.sqrt(D.stiffness / effective_mass)


def write_data(state, density, frame, path, box=BOX):
    """Writes a `state.csv` as a data file of LAMMPS, seen from a frame that moves with `frame` [m/s] along z. Returns the number of particles."""
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
    """Variables of the scripts `drag.lmp` and `drag.liggghts` for a scene, without numbers of steps."""
    return {
        "data": WORK / f"{scene.name}.data", "d": scene.diameter, "rho": scene.density, "kn": scene.stiffness,
        "dt": scene.step, "skin": scene.skin, "frame": scene.frame, "nu": VISCOSITY, "ut": FRICTION_VELOCITY,
        "kappa": KAPPA, "intercept": INTERCEPT, "H": BOX[1],
    }
