"""Checks that other programs read the right numbers from trajectories: the readers of VTK (ParaView), ASE and OVITO.

    python3 tests/readers.py path/to/diptych
    python3 tests/readers.py path/to/diptych 2       # built with MPI: frames in pieces, written by 2 processes

Compares every number with `state.csv` of the same run, bit by bit except for OVITO. Readers that are not installed are left out, with a message.
The exit code is 0 if all numbers that could be compared are equal.
"""

import csv
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

CASE = pathlib.Path(__file__).parent.parent / "cases" / "beads-in-air.toml"


def run(program, folder, model, processes):
    """Makes a short run with its final state and with frames in both formats. Returns the folder of the frames, and the rows of the state by id."""
    out = folder / model
    # frames in both formats are not in pieces, because extended XYZ is one file of all particles
    kind = "vtp" if processes > 1 else "both"
    short = ["--set", "run.duration=20 ms", "--set", f"output.format={kind}", "--every", "5 ms", "--save-state", "--quiet"]
    mpirun = ["mpirun", "--oversubscribe", "-n", str(processes)] if processes > 1 else []
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    subprocess.run([*mpirun, program, "run", str(CASE), "--model", model, "--out", str(out), *short], check=True, env=environment)
    with open(out / "state.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return out / "trajectory", rows


def same(what, found, expected):
    """Checks that all numbers have the same bits."""
    found, expected = [[struct.pack("<d", float(x)) for x in values] for values in (found, expected)]
    if found != expected:
        sys.exit(f"{what}: {sum(a != b for a, b in zip(found, expected))} of {len(expected)} numbers differ, {len(found)} read")


def near(what, found, expected):
    """Checks that all numbers are equal up to two units in the last place, because OVITO reads decimal digits by its own algorithm."""
    worst = max(abs(float(a) - b) / math.ulp(b) for a, b in zip(found, expected, strict=True))
    if worst > 2:
        sys.exit(f"{what}: off by up to {worst:.0f} units in the last place")


def columns(rows, names):
    return [float(row[name]) for row in rows for name in names]


def vtk(frames, name, rows, processes=1):
    """Checks the index, the last frame and the walls with the reader of VTK."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPPolyDataReader

    def read(path):
        reader = vtkXMLPPolyDataReader() if path.suffix == ".pvtp" else vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        return reader.GetOutput()

    # the frame of the start is not in parts
    files = sorted(path for path in (frames / name).iterdir() if path.suffix == ".pvtp" or path.suffix == ".vtp" and "-" not in path.name)
    assert files[-1].suffix == (".pvtp" if processes > 1 else ".vtp"), files
    index = (frames / f"{name}.pvd").read_text(encoding="utf-8")
    assert all(f"{name}/{file.name}" in index for file in files) and len(files) == 5, index
    last = read(files[-1])
    data = last.GetPointData()
    array = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
    assert set(array) == {"velocity", "radius", "id", "species", "overlap", "contacts", "solver"}, array.keys()
    order = array["id"].argsort()
    array = {name: values[order] for name, values in array.items()}
    assert last.GetNumberOfVerts() == processes and list(array["id"]) == list(range(len(rows)))
    same("vtk positions", vtk_to_numpy(last.GetPoints().GetData())[order].ravel(), columns(rows, "xyz"))
    same("vtk velocities", array["velocity"].ravel(), columns(rows, ["vx", "vy", "vz"]))
    same("vtk radii", 2 * array["radius"], columns(rows, ["diameter"]))
    time = vtk_to_numpy(last.GetFieldData().GetArray("TimeValue"))[0]
    assert abs(time - 0.02) < 1e-12, time
    walls = read(frames / f"{name}-walls.vtp")
    assert walls.GetNumberOfPolys() == 2 and walls.GetNumberOfPoints() == 8
    return f"{len(files)} frames"


def ase(frames, name, rows):
    """Checks the last frame with the reader of ASE."""
    from ase.io import read

    atoms = read(sorted((frames / name).glob("*.xyz"))[-1], format="extxyz")
    same("ase positions", atoms.get_positions().ravel(), columns(rows, "xyz"))
    same("ase velocities", atoms.arrays["velo"].ravel(), columns(rows, ["vx", "vy", "vz"]))
    assert list(atoms.arrays["id"]) == list(range(len(rows))) and list(atoms.pbc) == [True, False, True]
    same("ase box", atoms.cell.lengths(), [0.03, 0.04, 0.03])
    assert abs(atoms.info["Time"] - 0.02) < 1e-12
    return "last frame"


def ovito(frames, name, rows):
    """Checks that OVITO reads all frames as one sequence."""
    from ovito.io import import_file

    pipeline = import_file(str(frames / name / "*.xyz"), sort_particles=True)
    assert pipeline.num_frames == 5, pipeline.num_frames
    particles = pipeline.compute(4).particles
    near("ovito positions", particles.positions[...].ravel(), columns(rows, "xyz"))
    near("ovito velocities", particles["Velocity"][...].ravel(), columns(rows, ["vx", "vy", "vz"]))
    # OVITO stores radii in single precision
    wrong = [r for r, row in zip(particles["Radius"][...], rows, strict=True) if abs(2 * float(r) / float(row["diameter"]) - 1) > 6e-8]
    assert not wrong, wrong
    return "5 frames"


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    processes = int(sys.argv[2]) if len(sys.argv) == 3 else 1
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        for model in ("soft", "hard"):
            frames, rows = run(program, pathlib.Path(folder), model, processes)
            assert len(rows) == 200
            of_pieces = ((lambda *of: vtk(*of, processes), "vtk"),)
            for reader, library in of_pieces if processes > 1 else ((vtk, "vtk"), (ase, "ase"), (ovito, "ovito")):
                try:
                    what = reader(frames, model, rows)
                except ImportError as why:
                    print(f"{model}: {library} left out, it is not installed ({why})")
                else:
                    print(f"{model}: {library} reads {what}, equal to the state")


if __name__ == "__main__":
    main()
