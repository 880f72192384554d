#!/usr/bin/env python3
"""Do LAMMPS and our engines compute the same? Run this before speeds are quoted. The exit code is 1 if results differ.

    benches/peers/verify.py
"""
import csv
import math
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import measure
import scenes
from measure import WORK

failed = []


def judge(what, theirs, ours, limit, unit):
    """Prints the number of LAMMPS and ours. They agree if their difference is at most `limit`; all have the unit `unit`."""
    close = abs(theirs - ours) <= limit
    print(f"| {what} | {theirs:.10g} | {ours:.10g} | {abs(theirs - ours):.2g} | {limit:.2g} | {unit} |", flush=True)
    if not close:
        failed.append(what)


def last_row(log):
    """Numbers in the last line of the table that LAMMPS printed, by the titles of the columns."""
    lines = Path(log).read_text().splitlines()
    end = max(i for i, line in enumerate(lines) if line.startswith("Loop time"))
    head = max(i for i in range(end) if re.match(r"\s*Step\b", lines[i]))
    return dict(zip(lines[head].split(), map(float, lines[end - 1].split())))


def lammps(script, variables):
    log = WORK / "verify.log"
    words = [word for key, value in variables.items() for word in ("-var", key, value)]
    measure.execute(["lmp", "-in", HERE / script, "-log", log, "-screen", "none", *words])
    return last_row(log)


def collisions():
    """Compares the impacts between particles of scene S1 within 3 ms of the same start."""
    case, steps, step = HERE / "s1.toml", 4000, 7.5e-7
    measure.diptych(case, "s1-start", "hard", {"run.duration": "0 s"}, 1, ["--save-state"])
    data = WORK / "s1.data"
    scenes.write_data(WORK / "s1-start" / "state.csv", scenes.D.density, 0.0, data)
    row = lammps("s1.lmp", {"data": data, "contacts": 1, "steps": steps})
    # every elastic contact of two equal spheres lasts pi sqrt(m/(2 k)); LAMMPS counts each contact for both partners
    mass = math.pi / 6 * scenes.D.diameter**3 * scenes.D.density
    contact = math.pi * math.sqrt(mass / (2 * scenes.D.stiffness))
    theirs = row["f_average"] / 2 / contact
    for model in ("soft", "hard"):
        keys = {"run.duration": f"{steps * step} s"}
        mine = measure.diptych(case, f"verify-{model}", model, keys)
        # at worst both are independent Poisson counts; with the same start they differ by less
        limit = 3 * math.sqrt(2 * mine["pair_impacts"]) / (steps * step)
        judge(f"S1 collision rate, {model}", theirs, mine["pair_impacts"] / (steps * step), limit, "1/s")
        if model == "hard":  # no energy is in springs at the start
            judge("S1 kinetic energy at the start", lammps("s1.lmp", {"data": data, "contacts": 1, "steps": 1})["KinEng"],
                  mine["energy"]["at_start"], 1e-6 * mine["energy"]["at_start"], "J")


def drag(scene):
    """Compares the sum of the drag forces and their power at t = 0 in the scenes D and F. Our force is the impulse in a window of 10 ps, divided by
    10 ps, in which drag changes by 1e-10 of its value. In a window of 1 ns, a sphere met a wall in one settled start of D, which changed the mean
    along y by 1.4e-6 of the weight."""
    case = scenes.settled(scene)
    variables = scenes.drag_variables(scene)
    count = scenes.write_data(WORK / scene.name / "start.csv", scene.density, scene.frame, variables["data"])
    row = lammps("drag.lmp", {**variables, "drag": "every", "warm": 0, "steps": 0})
    span = 1e-11
    keys = {"run.duration": f"{span} s", "run.window": f"{span} s", "statistics.sample_interval": f"{span} s"}
    energy = measure.diptych(case, f"verify-{scene.name}", "hard", keys)["energy"]
    total = count * math.pi / 6 * scene.diameter**3 * scene.density
    force = [impulse / span / total for impulse in energy["drag_impulse"]]
    # the limit is relative to a typical acceleration, that of gravity
    for axis, k, mine in zip("xyz", (1, 2, 3), force):
        judge(f"{scene.name.upper()} mean drag acceleration, {axis}", row[f"c_drag[{k}]"] / total, mine, 1e-6 * 9.81, "m/s2")
    # power in the frame at rest, from that in LAMMPS's moving frame
    power = row["c_drag[4]"] + scene.frame * row["c_drag[3]"]
    judge(f"{scene.name.upper()} power of drag", power, energy["drag_work"] / span, 1e-6 * abs(power), "W")


def mean_velocity(state):
    """[m/s] mean velocity of the particles along z."""
    with open(state, newline="") as file:
        velocities = [float(row["vz"]) for row in csv.DictReader(line for line in file if not line.startswith("#"))]
    return math.fsum(velocities) / len(velocities)


def motion(scene):
    """Compares the change of the mean velocity by drag and weight in the scenes D and F, by each form of drag in LAMMPS and by our soft engine. Windows
    are so short that the separate computation of drag and flight has no visible effect. (Hard collisions take no time, and differ by more than the limit.)"""
    case = scenes.settled(scene)
    variables = scenes.drag_variables(scene)
    hold = scenes.KICKS[scene.name]
    steps = 20 * hold
    span = steps * scene.step
    keys = {"run.duration": f"{span} s", "soft.stepping": "local", "run.window": "0.02 ms"}
    measure.diptych(case, f"verify-{scene.name}", "soft", keys, 1, ["--save-state"])
    start, end = mean_velocity(WORK / scene.name / "start.csv"), mean_velocity(WORK / f"verify-{scene.name}" / "state.csv")
    # limits over the change by weight alone. held: 1e-5. kicks (every h seconds): the mid-point factor knows the drag k per slip, but the slope of the
    # law is up to 1.687 k, so that drag has a relative error of up to 0.687 k h/(2 m); k/m is g/slip where drag carries the weight, slip above 1.6 m/s
    for form, every, error in (("held", 10, 1e-5), ("kicks", hold, 0.687 * 9.81 / 1.6 * hold * scene.step / 2)):
        row = lammps("drag.lmp", {**variables, "drag": form, "hold": every, "warm": 0, "steps": steps})
        judge(f"{scene.name.upper()} change of mean velocity in {span:.3g} s, {form}",
              row["c_mean[3]"] + scene.frame - start, end - start, error * 9.81 * span, "m/s")


def main():
    measure.build()
    print("| quantity | LAMMPS | ours | difference | limit | unit |\n|---|---|---|---|---|---|")
    collisions()
    for scene in (scenes.D, scenes.F):
        drag(scene)
        motion(scene)
    if failed:
        sys.exit(f"not the same: {', '.join(failed)}")


if __name__ == "__main__":
    main()
