#!/usr/bin/env python3
"""Speed beside LAMMPS, LIGGGHTS and EDMD: the same scenes from the same starts, one thread each on one core, in turn.

    apt-get install lammps liggghts python3
    benches/peers/run.py [ROUNDS] [s1] [d] [f] [dense] [rough] [hard] [growth] [large]

README.md beside this file says what is compared and what is not equal. Prints ratios and adds them to target/peers/results.csv, from which ../page.py makes tables; a peer that is not
installed is left out; LAMMPS is needed for all but `hard` (EDMD, see crowds.py), and `growth` and `large` (10⁷ spheres), which are ours alone.
"""
import os
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import crowds
import measure
import scenes
from measure import WORK


def peer(program, script, step, steps, variables):
    """[-] simulated seconds per wall second in the last loop of another program (LAMMPS or LIGGGHTS), which makes `steps` steps of `step` [s]."""
    log = WORK / f"{program}.log"
    words = [word for key, value in {**variables, "steps": steps}.items() for word in ("-var", key, value)]
    _, share = measure.execute([program, "-in", HERE / script, "-log", log, "-screen", "none", *words])
    return steps * step / measure.loop_time(log, share)


def ours(case, name, model, keys):
    return measure.rate(measure.diptych(case, name, model, keys))


def without_gas(rounds):
    case = HERE / "s1.toml"
    keep = ["--save-state"]
    measure.diptych(case, "s1-start", "hard", {"run.duration": "0 s"}, 1, keep)
    data = WORK / "s1.data"
    scenes.write_data(WORK / "s1-start" / "state.csv", scenes.D.density, 0.0, data)
    contestants = {"LAMMPS": lambda: peer("lmp", "s1.lmp", 7.5e-7, 4000, {"data": data})}
    if shutil.which("liggghts"):
        contestants["LIGGGHTS"] = lambda: peer("liggghts", "s1.liggghts", 7.5e-7, 2000, {"data": data})
    uniform = {"soft.stepping": "uniform", "soft.time_step": "7.5e-7 s"}
    local = {"soft.stepping": "local", "soft.steps_per_contact": 20}
    contestants["soft, uniform, same step"] = lambda: ours(case, "s1-uniform", "soft", uniform)
    contestants["soft, local, N_c = 20"] = lambda: ours(case, "s1-local", "soft", local)
    contestants["hard"] = lambda: ours(case, "s1-hard", "hard", {})
    measure.ratios("S1, no gas", measure.in_turn(rounds, contestants), "LAMMPS")


# Number of steps in LAMMPS's timed loop, by scene and form of the drag. Each loop takes a few seconds of wall time.
STEPS = {"d": {"held": 600, "kicks": 2400}, "f": {"held": 10000, "kicks": 60000}}
DURATION = {"d": "20 ms", "f": "400 ms"}


def with_drag(scene, rounds):
    case = scenes.settled(scene)
    variables = scenes.drag_variables(scene)
    scenes.write_data(WORK / scene.name / "start.csv", scene.density, scene.frame, variables["data"])

    def lammps(drag, hold):
        steps = STEPS[scene.name][drag]
        return lambda: peer("lmp", "drag.lmp", scene.step, steps, {**variables, "drag": drag, "hold": hold})

    span = {"run.duration": DURATION[scene.name]}
    uniform = {"soft.stepping": "uniform", "soft.time_step": f"{scene.step} s", "run.duration": "5 ms"}
    local = {"soft.stepping": "local", **span}
    name = scene.name
    contestants = {
        "LAMMPS, held": lammps("held", 10),
        "LAMMPS, kicks": lammps("kicks", scenes.KICKS[name]),
        "soft, uniform, same step": lambda: ours(case, f"{name}-uniform", "soft", uniform),
        "soft, local, N_c = 20": lambda: ours(case, f"{name}-local", "soft", local),
        "hard": lambda: ours(case, f"{name}-hard", "hard", span),
    }
    rates = measure.in_turn(rounds, contestants)
    for base in ("LAMMPS, held", "LAMMPS, kicks"):
        measure.ratios(f"Case {name.upper()} with drag", rates, base)


DENSE_STEP, DENSE_STEPS = 3.8e-7, 500  # time step [s] of dense.toml, and number of steps in LAMMPS's timed loop


def dense(rounds):
    """Dense gas: LAMMPS and our uniform steps on one core, and ours on two cores. Also prints particle steps per second."""
    case = HERE / "dense.toml"
    measure.diptych(case, "dense-start", "soft", {"run.duration": "0 s"}, 1, ["--save-state"])
    data = WORK / "dense.data"
    count = scenes.write_data(WORK / "dense-start" / "state.csv", scenes.D.density, 0.0, data, (scenes.DENSE_EDGE,) * 3)
    variables = {"data": data, "kn": scenes.D.stiffness, "gamma": scenes.dashpot(0.9), "dt": DENSE_STEP}
    contestants = {
        "LAMMPS": lambda: peer("lmp", "dense.lmp", DENSE_STEP, DENSE_STEPS, variables),
        "soft, same step": lambda: ours(case, "dense-1", "soft", {}),
    }
    two = []
    if os.cpu_count() > 1:
        contestants["soft, same step, two threads"] = lambda: two_threads(case, two)
    rates = measure.in_turn(rounds, contestants)
    measure.ratios(f"Dense gas, {count} spheres", rates, "LAMMPS")
    for name, values in rates.items():
        print(f"{name}: {measure.spread([value * count / DENSE_STEP / 1e6 for value in values])} million particle-steps/s")
    if two:
        gains = [b / a for a, b in zip(rates["soft, same step"], two)]
        measure.save(f"Dense gas, {count} spheres", "soft, same step, two threads", "wall time of one thread over two", "-", gains)
        print(f"two threads over one, wall time: {measure.spread(gains)}")


# Friction, and ratios of tangential to normal stiffness and dashpot, in the scenes with rough spheres: usual values in the examples of LAMMPS.
FRICTION, STIFFNESS_RATIO, DASHPOT_RATIO = 0.3, 2 / 7, 0.5
ROUGH = {
    "contact.friction": FRICTION,
    "soft.tangential.linear.stiffness_ratio": STIFFNESS_RATIO,
    "soft.tangential.linear.dashpot_ratio": DASHPOT_RATIO,
}


def rough(rounds):
    """Rough spheres (spins, friction, tangential springs with memory) in the dense gas and in S1. In S1 also hard spheres, rough by Walton's rule, and
    smooth."""
    case = HERE / "dense.toml"
    measure.diptych(case, "dense-start", "soft", {"run.duration": "0 s"}, 1, ["--save-state"])
    data = WORK / "dense.data"
    scenes.write_data(WORK / "dense-start" / "state.csv", scenes.D.density, 0.0, data, (scenes.DENSE_EDGE,) * 3)
    kn, gamma = scenes.D.stiffness, scenes.dashpot(0.9)
    variables = {"data": data, "kn": kn, "gamma": gamma, "dt": DENSE_STEP}
    variables |= {"kt": STIFFNESS_RATIO * kn, "gammat": DASHPOT_RATIO * gamma, "mu": FRICTION}
    contestants = {
        "LAMMPS": lambda: peer("lmp", "rough.lmp", DENSE_STEP, DENSE_STEPS, variables),
        "soft, same step": lambda: ours(case, "dense-rough", "soft", ROUGH),
        "soft, smooth": lambda: ours(case, "dense-1", "soft", {}),
    }
    measure.ratios("Dense gas of rough spheres", measure.in_turn(rounds, contestants), "LAMMPS")
    case = HERE / "s1.toml"
    measure.diptych(case, "s1-start", "hard", {"run.duration": "0 s"}, 1, ["--save-state"])
    data = WORK / "s1.data"
    scenes.write_data(WORK / "s1-start" / "state.csv", scenes.D.density, 0.0, data)
    walton = {"contact.friction": FRICTION, "hard.friction.walton.tangential_restitution": 0.4}
    local = {**ROUGH, "soft.stepping": "local", "soft.steps_per_contact": 20}
    variables = {"data": data, "kt": STIFFNESS_RATIO * kn, "mu": FRICTION}
    contestants = {
        "LAMMPS": lambda: peer("lmp", "s1-rough.lmp", 7.5e-7, 4000, variables),
        "soft, local, N_c = 20": lambda: ours(case, "s1-rough", "soft", local),
        "hard, Walton": lambda: ours(case, "s1-walton", "hard", walton),
        "hard, smooth": lambda: ours(case, "s1-hard", "hard", {}),
    }
    measure.ratios("S1 of rough spheres, no gas", measure.in_turn(rounds, contestants), "LAMMPS")


def two_threads(case, rates):
    """[-] simulated seconds per wall second on two cores. This is not corrected for other processes: the share of two cores that the process got says
    little about its loop."""
    variant = measure.diptych(case, "dense-2", "soft", {}, 2)
    rates.append(variant["simulated_seconds"] / variant["wall_seconds"])
    return rates[-1]


WITH_LAMMPS = ("s1", "d", "f", "dense", "rough")


def main():
    words = sys.argv[1:]
    rounds = next((int(word) for word in words if word.isdigit()), 5)
    wanted = [word.lower() for word in words if not word.isdigit()] or [*WITH_LAMMPS, "hard", "growth"]
    unknown = [word for word in wanted if word not in (*WITH_LAMMPS, "hard", "growth", "large")]
    if unknown or rounds < 1:
        sys.exit(f"usage: benches/peers/run.py [ROUNDS] [s1] [d] [f] [dense] [rough] [hard] [growth] [large]; not understood: {' '.join(unknown) or rounds}")
    if not shutil.which("lmp") and any(scene in wanted for scene in WITH_LAMMPS):
        sys.exit("lmp is not here: apt-get install lammps")
    measure.build()
    if "s1" in wanted:
        without_gas(rounds)
    for scene in (scenes.D, scenes.F):
        if scene.name in wanted:
            with_drag(scene, rounds)
    if "dense" in wanted:
        dense(rounds)
    if "rough" in wanted:
        rough(rounds)
    if "hard" in wanted:
        crowds.beside_edmd(rounds)
    if "growth" in wanted:
        crowds.growth(rounds, (10_000, 100_000, 1_000_000), 0.25)
    if "large" in wanted:
        # short windows, since a window of ten million spheres takes minutes; a dense start of so many spheres would take an hour
        crowds.growth(rounds, (10_000, 10_000_000), 0.05, (0.3,))


if __name__ == "__main__":
    main()
