#!/usr/bin/env python3
"""Do rough beads flow in LAMMPS as in our program? A sheared box, and a layer on a rough incline. Prints tables; takes some twenty minutes.

    benches/peers/flows.py
"""
import csv
import math
import random
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import measure
from measure import ROOT, WORK

SPEED = math.sqrt(9.81e-3)  # [m/s] sqrt(g d), LAMMPS's unit of speed
TIME = math.sqrt(1e-3 / 9.81)  # [s] sqrt(d/g), its unit of time
BEADS = 858  # number of beads in both programs, which is that of the lattice in incline.lmp
STRESS = math.pi / 6 * 1e-9 * 2500 * 100**2 / 1e-3  # [Pa] unit of stress, m rate²/d with the mass, shear rate and diameter of shear.toml


def lammps(script, variables):
    words = [word for key, value in variables.items() for word in ("-var", key, value)]
    measure.execute(["lmp", "-in", HERE / script, "-log", WORK / "flows.log", "-screen", "none", *words])


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def shear():
    """Prints stresses in units of m rate²/d: the normal stresses along the flow, the gradient and the vorticity, and the shear stress."""
    out = WORK / "shear.txt"
    lammps("shear.lmp", {"count": 512, "phi": 0.47, "out": out})
    theirs = [float(word) for word in out.read_text().splitlines()[-1].split()[1:5]]
    measure.diptych(HERE / "shear.toml", "flows-shear", "soft", {})
    ours = {row["component"]: row for row in rows(WORK / "flows-shear" / "stress.csv")}
    print("\n| stress | LAMMPS | ours |\n|---|---|---|")
    for name, component, peer in zip(("flow", "gradient", "vorticity", "shear"), ("zz", "yy", "xx", "yz"), theirs):
        mine, error = (float(ours[component][key]) / STRESS for key in ("total_Pa", "total_se"))
        print(f"| {name} | {peer:.3f} | {mine:.3f} ± {error:.3f} |", flush=True)


def base():
    """Random positions of 80 fixed beads, at least 0.8 diameters apart, also across periodic sides: x, y and height in diameters."""
    draw, beads = random.Random(5), []
    while len(beads) < 80:
        x, y, height = draw.uniform(0, 6), draw.uniform(0, 12), draw.uniform(-0.4, 0)
        near = lambda other: math.dist((0, 0, 0), ((x - other[0] + 3) % 6 - 3, (y - other[1] + 6) % 12 - 6, height - other[2])) < 0.8
        if not any(map(near, beads)):
            beads.append((x, y, height))
    return beads


def case_on(beads):
    """Path of a copy of the case inclined-flow.toml, with the fixed `beads` as walls in place of its base, and with the bead sizes of incline.lmp."""
    text = (ROOT / "cases" / "driven" / "inclined-flow.toml").read_text()
    head, rest = text.split('[[walls]]\nname = "base"')
    ground = '[[walls]]\nname = "ground"' + rest.split('[[walls]]\nname = "ground"')[1].split("[[compare]]")[0]
    # the restitution 0.88 of two beads becomes 0.835 for a bead and a fixed one in LAMMPS, where the effective mass is twice as large
    wall = '[[walls]]\nsphere = {{ center = ["{} mm", "{} mm", "{} mm"], radius = "0.5 mm" }}\nrestitution = 0.835\nfriction = 0.5\n\n'
    head = head.replace('diameter = "1 mm"', 'sizes.uniform = { from = "0.9 mm", to = "1.1 mm" }')
    case = WORK / "incline.toml"
    case.write_text(head + "".join(wall.format(x, height, y) for x, y, height in beads) + ground)
    return case


def incline():
    """Prints the number of beads and the speed in each layer of the height of a diameter d, averaged from 100 to 200 sqrt(d/g)."""
    beads, out = base(), WORK / "incline.txt"
    commands = WORK / "incline-base.lmp"
    commands.write_text("".join(f"create_atoms 2 single {x} {y} {height} units box\n" for x, y, height in beads))
    lammps("incline.lmp", {"base": commands, "out": out})
    theirs = [[float(word) for word in line.split()] for line in out.read_text().splitlines()[4:]]
    keys = {"run.duration": f"{200 * TIME} s", "run.average_from": f"{100 * TIME} s", "particles[0].count": BEADS}
    measure.diptych(case_on(beads), "flows-incline", "soft", keys)
    print("\n| height [d] | beads in LAMMPS | ours | speed [sqrt(g d)] in LAMMPS | ours |\n|---|---|---|---|---|")
    mean = BEADS / 40
    for peer, mine in zip(theirs[1:], rows(WORK / "flows-incline" / "profiles.csv")):
        if peer[2] < 1:
            break
        speed, error = (float(mine[key]) / SPEED for key in ("U", "U_se"))
        count = mean * float(mine["number_density_ratio"])
        print(f"| {peer[1]:.1f} | {peer[2]:.1f} | {count:.1f} | {peer[4]:.2f} | {speed:.2f} ± {error:.2f} |", flush=True)
    # a second flow of half the height, which shows the growth of the mean speed with the height
    measure.diptych(case_on(beads), "flows-half", "soft", {**keys, "particles[0].count": BEADS // 2})
    speeds = [mean_speed(WORK / out / "series.csv") for out in ("flows-incline", "flows-half")]
    print(f"\nmean speed {speeds[0]:.3f} and {speeds[1]:.3f}: grows with the height to the power {math.log2(speeds[0] / speeds[1]):.2f}")


def mean_speed(series):
    """[sqrt(g d)] mean speed of all beads down the slope in the second half of the run."""
    late = [row for row in rows(series) if float(row["t_s"]) > 100 * TIME]
    return sum(float(row["mean_velocity_z_m_s"]) for row in late) / len(late) / SPEED


def main():
    measure.build()
    shear()
    incline()


if __name__ == "__main__":
    main()
