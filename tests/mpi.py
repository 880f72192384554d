#!/usr/bin/env python3
"""Runs a program that was built with MPI on several processes: tests/mpi.py target/release/diptych

All results that do not depend on time must be those of one process. A failure in one process must end all processes with one message and one
exit code. A run that is killed must be resumable. Needs mpirun.
"""

import csv
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAM = str(Path(sys.argv[1]).resolve())
CASE = str(Path(__file__).resolve().parent.parent / "cases" / "quick.toml")
CRADLE = str(Path(CASE).parent / "cradle.toml")
SHORT = ["--set", "run.duration=50 ms", "--set", "run.average_from=10 ms"]
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def start(count, arguments, folder, **variables):
    """Starts `count` processes by mpirun; a single process is started without MPI."""
    head = ["mpirun", "--oversubscribe", "-n", str(count)] if count > 1 else []
    return subprocess.Popen(
        [*head, PROGRAM, *arguments], cwd=folder, env={**ENVIRONMENT, **variables}, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def diptych(count, arguments, folder):
    """Runs `count` processes. Returns the exit code and the printed text."""
    process = start(count, arguments, folder)
    out, said = process.communicate(timeout=300)
    return process.returncode, out + said


def lasting(value):
    """Value of summary.json without keys for times, and without keys that depend on the command line."""
    # the number of pairs that searches examine depends on the division of the box
    passing = {"pair_checks", "timing", "wall_seconds", "wall_seconds_per_simulated_second", "particle_windows_per_second", "command", "verdicts", "sentences"}
    if isinstance(value, dict):
        return {key: lasting(one) for key, one in value.items() if key not in passing}
    return [lasting(one) for one in value] if isinstance(value, list) else value


def summary(folder):
    whole = json.loads((folder / "summary.json").read_text())
    # the check of the number of threads in the trust sheet is left out
    for sheet in whole.get("trust", []):
        sheet["checks"] = [check for check in sheet["checks"] if "thread" not in json.dumps(check)]
    return lasting(whole)


def rows(folder):
    table = list(csv.DictReader((folder / "sweep.csv").open()))
    return [{k: v for k, v in row.items() if k not in ("wall_seconds", "cost_s_s", "cost_s_s_se")} for row in table]


def same_results(place):
    """Checks that replicas, sweeps and sensitivity have equal results on one, two and three processes."""
    values = "soft.linear_spring_dashpot.stiffness=1 kN/m,2 kN/m,3 kN/m"
    commands = {
        "run": ["run", CASE, "--replicas", "5", *SHORT],
        "compare": ["compare", CASE, "--replicas", "3", *SHORT],
        "sweep": ["sweep", CASE, "--sweep", values, "--replicas", "2", *SHORT],
        "sensitivity": ["sensitivity", CASE, "--factors", "restitution,stiffness", "--replicas", "2", *SHORT],
    }
    for name, command in commands.items():
        for count in (1, 2, 3):
            code, said = diptych(count, [*command, "--out", f"{name}{count}"], place)
            assert code == 0, said
            shared = f"{count} processes share the work" in said
            assert shared == (count > 1), said
            look = rows if name == "sweep" else summary
            assert look(place / f"{name}{count}") == look(place / f"{name}1"), f"{name} on {count} processes"
        print(f"{name}: the same on 1, 2 and 3 processes")


def one_run_is_shared(place):
    """Checks runs that processes share in domains (blocks of the box): gas with drag, all three models, two sizes, walls of triangles, a bed."""
    cases = Path(CASE).parent
    short = lambda time: ["--set", f"run.duration={time}", "--set", "run.average_from=0 s"]
    commands = {
        "three models": ["compare", CASE, *short("20 ms")],
        "case D": ["run", str(cases / "channel-d.toml"), "--model", "hard", *short("1 ms")],
        "two sizes": ["run", str(cases / "mixtures" / "binary-channel.toml"), "--model", "soft", *short("1 ms")],
        "triangles": ["run", str(cases / "walls" / "gas-in-a-ball.toml"), "--model", "hybrid", *short("20 ms")],
        "gas above a bed": ["run", str(cases / "hybrid" / "gas-above-bed.toml"), "--model", "hybrid", *short("1 ms")],
        "crowded": ["run", str(cases / "dense-gas.toml"), "--model", "soft", *short("1 ms")],
        "all at once": ["run", str(cases / "dense-gas.toml"), "--model", "soft", "--set", "soft.stepping=uniform", *short("1 ms")],
    }
    for number, (name, command) in enumerate(commands.items()):
        for count in (1, 2, 3, 4):
            code, said = diptych(count, [*command, "--out", f"one{number}-{count}"], place)
            assert code == 0, said
            words = "nothing was shared" if name == "gas above a bed" else "messages ("
            assert count == 1 or words in said, said
            for table in ("series.csv", "profiles.csv", "impacts.csv"):
                mine, theirs = (place / f"one{number}-{n}" / table for n in (count, 1))
                assert mine.read_bytes() == theirs.read_bytes(), f"{name}: {table} on {count} processes"
            assert summary(place / f"one{number}-{count}") == summary(place / f"one{number}-1"), f"{name} on {count} processes"
        print(f"{name}: one run has the same bits on 1, 2, 3 and 4 processes")


def arrays(path):
    """Arrays of a VTK file by name. Each array has the bytes of each point."""
    head, data = path.read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)
    head = head.decode()
    count = int(re.search(r'NumberOfPoints="(\d+)"', head)[1])
    found = {}
    for name, offset in re.findall(r'Name="(\w+)" NumberOfComponents="\d" format="appended" offset="(\d+)"', head.split("<Verts>")[0]):
        length = int.from_bytes(data[int(offset) : int(offset) + 8], "little")
        block = data[int(offset) + 8 : int(offset) + 8 + length]
        size = length // max(count, 1)
        found[name] = [block[k * size : (k + 1) * size] for k in range(count)]
    return found


def trajectory(folder, name):
    """Frames of a trajectory that its index lists: time, particles by id, and number of files of each frame."""
    frames = []
    for time, file in re.findall(r'timestep="([^"]+)" part="0" file="([^"]+)"', (folder / "trajectory" / f"{name}.pvd").read_text()):
        path = folder / "trajectory" / file
        files = [path.parent / one for one in re.findall(r'Source="([^"]+)"', path.read_text())] if path.suffix == ".pvtp" else [path]
        particles = {}
        for one in files:
            points = arrays(one)
            assert len(points) == 8, points.keys()
            new = dict(zip(points.pop("id"), zip(*points.values()), strict=True))
            assert not new.keys() & particles.keys(), f"{one}: a particle of another piece"
            particles.update(new)
        frames.append((time, particles, len(files)))
    return frames


def same_frames(folder, other, name, pieces):
    """Checks that two folders have equal frames, bit by bit, and that at least `pieces` frames of the second one consist of several files."""
    one, two = trajectory(folder, name), trajectory(other, name)
    assert [(time, particles) for time, particles, _ in one] == [(time, particles) for time, particles, _ in two], (folder, other, name)
    assert sum(files > 1 for _, _, files in two) >= pieces, [files for _, _, files in two]
    # every file belongs to a frame of the index
    stray = {path.name.split(".")[0].split("-")[0] for path in (other / "trajectory" / name).iterdir()}
    assert len(stray) == len(two), stray


def frames_in_pieces(place):
    """Checks trajectories to which every process writes its part of each frame: at samples, between samples, and at the end."""
    case = str(Path(CASE).parent / "channel-f.toml")
    command = ["compare", case, "--set", "run.duration=11 ms", "--set", "run.average_from=0 s", "--every", "1.7 ms"]
    for count in (1, 2, 3):
        code, said = diptych(count, [*command, "--out", f"frames{count}"], place)
        assert code == 0, said
        for index in (place / "frames1" / "trajectory").glob("*.pvd"):
            same_frames(place / "frames1", place / f"frames{count}", index.stem, 6 if count > 1 else 0)
    code, said = diptych(2, ["run", case, "--model", "hard", *command[2:], "--set", "output.format=both", "--out", "frames4"], place)
    assert code == 0, said
    same_frames(place / "frames1", place / "frames4", "hard", 0)
    print("trajectories: the pieces are together the frames of one process")


def work_is_shared(place):
    """Checks that each of two processes does some of the runs of a sweep."""
    process = start(2, ["sweep", CASE, "--threads", "1", "--sweep", "run.seed=1,2,3,4,5,6", "--only", "hard", "--set", "run.duration=1 s", "--out", "shared"], place)
    used = {}
    while process.poll() is None:
        for name in os.listdir("/proc"):
            try:
                words = Path("/proc", name, "cmdline").read_text().split("\0")
                if words[0] == PROGRAM and "shared" in words:
                    stat = Path("/proc", name, "stat").read_text().rsplit(")", 1)[1].split()
                    used[name] = int(stat[11])
            except (OSError, ValueError, IndexError):
                continue
        time.sleep(0.02)
    said = process.communicate()[1]
    assert process.returncode == 0, said
    assert len(used) == 2 and min(used.values()) > 0.2 * max(used.values()), f"ticks of processor time: {used}\n{said}"
    print(f"both processes work: {used} ticks")


def refusals(place):
    """Checks that wrong input gives one message and one exit code from all processes together."""
    other = place / "other.toml"
    other.write_text(Path(CASE).read_text())
    mpirun = ["mpirun", "--oversubscribe"]
    cases = [
        (["-n", "3", PROGRAM, "run", "nothere.toml", "--replicas", "2"], ["no such file"]),
        (["-n", "2", PROGRAM, "run", CASE, "--replicsa", "2"], ["unexpected argument"]),
        (["-n", "7", PROGRAM, "run", CRADLE], ["7 processes for", "mpirun -n"]),
        (["-n", "1", PROGRAM, "run", CASE, "--replicas", "2", ":", "-n", "1", PROGRAM, "run", str(other), "--seed", "9", "--replicas", "2"],
         ["process 1 of 2", "another case"]),
        (["-n", "1", PROGRAM, "run", CASE, "--replicas", "2", ":", "-n", "1", PROGRAM, "run", "nothere.toml", "--replicas", "2"],
         ["no such file", "process 1 of 2"]),
        (["-n", "2", PROGRAM, "run", CASE, "--replicas", "2", "--out", "run1"], ["holds results"]),
    ]
    before = sorted(path.name for path in place.iterdir())
    for arguments, wanted in cases:
        ended = subprocess.run([*mpirun, *arguments], cwd=place, env=ENVIRONMENT, text=True, capture_output=True, timeout=60)
        said = ended.stdout + ended.stderr
        assert ended.returncode == 2, (ended.returncode, said)
        assert all(words in said for words in wanted) and said.count("error:") == 1, said
    assert sorted(path.name for path in place.iterdir()) == before
    print("refusals: one message, exit code 2, nothing written")


def lasts(seconds, count, arguments, place):
    """Setting of the duration with which `count` processes run for at least `seconds` of wall time on this machine. Half a simulated second is timed first.

    mpirun passes SIGTERM on after a second, and kills the processes after another second. A run that should receive SIGTERM must therefore last longer."""
    began = time.monotonic()
    code, said = diptych(count, [*arguments, "--set", "run.duration=0.5 s", "--out", f"timed{count}"], place)
    assert code == 0, said
    return ["--set", f"run.duration={max(1.0, round(0.5 * seconds / (time.monotonic() - began), 1))} s"]


def killed_and_gone_on_with(place):
    """Checks that killing one process ends all of them, and that the stored runs can be resumed on another number of processes."""
    long = ["--set", "run.average_from=0.2 s", "--checkpoint-every", "0.2 s"]
    long = [*long, *lasts(2.5, 1, ["run", CASE, *long], place), "--replicas", "4"]
    code, said = diptych(1, ["run", CASE, *long, "--out", "whole"], place)
    assert code == 0, said
    for number, how in enumerate((signal.SIGKILL, signal.SIGTERM)):
        folder = place / f"cut{number}"
        process = start(3, ["run", CASE, *long, "--out", folder.name], place)
        # waits until a replica is in progress
        while process.poll() is None and not list((folder / "checkpoint").glob("a-*")):
            time.sleep(0.02)
        assert process.poll() is None, process.communicate()
        if how == signal.SIGKILL:
            one = subprocess.run(["pgrep", "-f", f"^{PROGRAM} run.*{folder.name}"], text=True, capture_output=True).stdout.split()
            assert one, f"no process of {folder.name} is running"
            os.kill(int(one[-1]), how)
        else:
            process.send_signal(how)
        said = process.communicate(timeout=60)
        assert process.returncode != 0 and not (folder / "summary.json").exists(), said
        code, told = diptych(2, ["resume", folder.name], place)
        assert code == 0, (said, told)
        assert summary(folder) == summary(place / "whole"), how
    print("killed and gone on with: the same results")


def process_of(folder, rank):
    """Process id of the process with the number `rank`, among the processes that write into the folder."""
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            words = Path("/proc", name, "cmdline").read_text().split("\0")
            if words[0] == PROGRAM and folder in words and f"OMPI_COMM_WORLD_RANK={rank}" in Path("/proc", name, "environ").read_text().split("\0"):
                return int(name)
        except OSError:
            continue
    raise AssertionError(f"no process {rank} writes into {folder}")


def one_run_is_killed(place):
    """Checks a run that all processes share, if one of them is killed or runs out of memory: mpirun names this process, and the run can be resumed on
    another number of processes."""
    long = ["--model", "hard", "--set", "run.average_from=0.2 s", "--checkpoint-every", "0.2 s", "--every", "50 ms"]
    case = str(Path(CASE).parent / "channel-f.toml")
    long += lasts(4.0, 3, ["run", case, *long], place)
    code, said = diptych(1, ["run", case, *long, "--out", "all"], place)
    assert code == 0, said
    parts = []
    # a checkpoint is in parts, unless all particles have just been moved together, which happens by chance: repeated until one is in parts
    for number, how in enumerate(("killed", "told to stop", "out of memory") + ("told to stop",) * 6):
        if number >= 3 and 3 in parts:
            break
        folder = place / f"part{number}"
        # with this variable, nearly every piece of memory is requested from the system, and given back
        process = start(3, ["run", case, *long, "--out", folder.name], place, MALLOC_MMAP_THRESHOLD_="4096")
        while process.poll() is None and not (folder / "checkpoint" / "a").exists():
            time.sleep(0.02)
        assert process.poll() is None, process.communicate()
        parts.append(len(list((folder / "checkpoint").glob("a-part-*"))))
        if how == "killed":
            os.kill(process_of(folder.name, 2), signal.SIGKILL)
        elif how == "out of memory":
            resource.prlimit(process_of(folder.name, 1), resource.RLIMIT_AS, (1, 1))
        else:
            process.send_signal(signal.SIGTERM)
        out, said = process.communicate(timeout=60)
        assert process.returncode != 0 and not (folder / "summary.json").exists(), said
        # by chance, the program, Open MPI or the growing stack (segmentation fault) is the first to request memory that is not available;
        # each of these ends the process in another way
        words = {
            "killed": [["process rank 2"], ["signal 9"]],
            "out of memory": [["process rank 1", "],1]"], ["memory allocation of", "out of dynamic memory", "signal 11"]],
        }.get(how, [])
        assert all(any(one in out + said for one in either) for either in words), (words, out, said)
        count = 1 if how == "out of memory" else 2
        code, told = diptych(count, ["resume", folder.name], place)
        assert code == 0, (said, told)
        assert summary(folder) == summary(place / "all"), how
        same_frames(place / "all", folder, "hard", count - 1)
    assert set(parts) <= {0, 3} and 3 in parts, f"parts that checkpoints were stored in: {parts}"
    print("a process of a shared run is killed or has no memory left: mpirun names it, and what goes on gives the same results")


with tempfile.TemporaryDirectory() as folder:
    place = Path(folder)
    same_results(place)
    one_run_is_shared(place)
    frames_in_pieces(place)
    work_is_shared(place)
    refusals(place)
    killed_and_gone_on_with(place)
    one_run_is_killed(place)
