"""Runs a short comparison and redraws a figure of its report: streamwise velocity and agitation across the channel, with error bands.

    python python/examples/profiles.py [FOLDER]

FOLDER holds results already; without it cases/quick.toml is run for 4 s into a temporary folder. Without matplotlib the numbers are printed.
"""

import sys
import tempfile
from pathlib import Path

import diptych

CASE = Path(__file__).resolve().parents[2] / "cases" / "quick.toml"


def results():
    if len(sys.argv) > 1:
        return diptych.load(sys.argv[1])
    folder = Path(tempfile.mkdtemp(prefix="diptych-")) / "quick"
    return diptych.run(CASE, folder, set={"run.duration": "4 s", "run.average_from": "1.5 s"})


def main():
    found = results()
    print(*found.verdicts, sep="\n")
    columns = {"U_m_s": "mean velocity U [m/s]", "uu_m2_s2": "variance uu [m²/s²]"}
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        print(found.profiles[["variant", "y_m", *columns]].to_string(index=False))
        return
    figure, axes = plt.subplots(1, len(columns), figsize=(9, 4), layout="constrained")
    for axis, (name, label) in zip(axes, columns.items()):
        error = name.replace("_m", "_se_m", 1)
        for variant, rows in found.profiles.groupby("variant", sort=False):
            (line,) = axis.plot(1e3 * rows["y_m"], rows[name], label=variant)
            axis.fill_between(1e3 * rows["y_m"], rows[name] - rows[error], rows[name] + rows[error], alpha=0.2, color=line.get_color())
        axis.set_xlabel("y [mm]")
        axis.set_ylabel(label)
    axes[0].legend()
    picture = Path("profiles.png").resolve()
    figure.savefig(picture, dpi=150)
    print(f"Figure: {picture}")


main()
