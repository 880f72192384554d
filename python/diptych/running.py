"""Starts the program, and loads the results that it writes."""

import os
import subprocess
import sys
from pathlib import Path

from .errors import InputError, RunError
from .results import Results, load


def _program() -> list[str]:
    """Start of a command line: the program that the environment variable DIPTYCH names, or else that of this package."""
    if named := os.environ.get("DIPTYCH"):
        return [named]
    return [sys.executable, "-m", "diptych"]


def _started(line: list[str], out) -> Results:
    """Starts the program, and loads the results that it has written to `out`."""
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode == 2:
        raise InputError(done.stderr.strip())
    written = load(out) if (Path(out) / "summary.json").is_file() else None
    if done.returncode != 0 or written is None:
        raise RunError(done.stderr.strip() or f"diptych ended with {done.returncode}", written)
    return written


def judge(a, b, out, *, settings=None, margin=None, overwrite=False) -> Results:
    """Compares two sides by `diptych judge`, and loads the results; their table is `judged`. A side is a file, or a list of files of replicas.

    settings: path of judge.toml. margin: largest difference that counts as equivalent, such as "2 %".
    """
    def side(files) -> str:
        return ",".join(map(str, files)) if isinstance(files, (list, tuple)) else str(files)

    line = [*_program(), "judge", side(a), side(b), "--out", str(out), "--quiet"]
    for name, value in (("--settings", settings), ("--margin", margin)):
        if value is not None:
            line += [name, str(value)]
    return _started(line + ["--overwrite"] * overwrite, out)


def run(case, out, *, command="compare", model=None, set=None, seed=None, threads=None, overwrite=False, arguments=()) -> Results:
    """Runs a case, and loads the results that it has written to the folder `out`.

    command: "compare" (all variants of the case) or "run" (one variant, with `model` "soft", "hard" or "auto").
    set: keys of the case and their values as they are typed, {"run.duration": "2 s"}.
    arguments: further arguments of the command line, such as ["--save-state"].
    """
    line = [*_program(), command, str(case), "--out", str(out), "--quiet"]
    for name, value in (("--model", model), ("--seed", seed), ("--threads", threads)):
        if value is not None:
            line += [name, str(value)]
    for key, value in (set or {}).items():
        line += ["--set", f"{key}={value}"]
    if overwrite:
        line.append("--overwrite")
    return _started([*line, *map(str, arguments)], out)


def compare(case, out, **options) -> Results:
    """Compares all variants of a case; `options` are those of `run`."""
    return run(case, out, command="compare", **options)


def sweep(case, out, values, *, only=(), arguments=(), **options) -> Results:
    """Runs a case at several values of its keys. The table `variants` of the results has a row for each run.

    values: keys with lists of values as they are typed, {"contact.restitution": [0.8, 0.9]}. only: names of variants.
    """
    axes = [word for key, list_ in values.items() for word in ("--sweep", f"{key}={','.join(map(str, list_))}")]
    names = [word for name in only for word in ("--only", name)]
    return run(case, out, command="sweep", arguments=[*axes, *names, *arguments], **options)
