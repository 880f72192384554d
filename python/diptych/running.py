"""Starts the diptych binary."""

import os
import shutil
import subprocess
from pathlib import Path

from .results import Results, load


class InputError(ValueError):
    """The case or the command is at fault (exit code 2): nothing was written. The message is that of the program."""


class RunError(RuntimeError):
    """An engine stopped on the way (exit code 1). `results` holds what was written until then, or is None."""

    def __init__(self, message: str, results: Results | None):
        super().__init__(message)
        self.results = results


def binary() -> Path:
    """The program: the one that the environment variable DIPTYCH names, or one on PATH, or one that cargo has built."""
    if named := os.environ.get("DIPTYCH"):
        return Path(named)
    if found := shutil.which("diptych"):
        return Path(found)
    for root in (Path.cwd(), Path(__file__).resolve().parents[2]):
        for profile in ("release", "debug"):
            built = root / "target" / profile / "diptych"
            if built.is_file():
                return built
    raise FileNotFoundError("no diptych binary: build it (cargo build --release) or set DIPTYCH to its path")


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
    """Compares two sides, each a file or a list of files (replicas), and loads the answer; `judged` is its table.

    settings: path of judge.toml. margin: such as "2 %".
    """
    def side(files) -> str:
        return ",".join(map(str, files)) if isinstance(files, (list, tuple)) else str(files)

    line = [str(binary()), "judge", side(a), side(b), "--out", str(out), "--quiet"]
    for name, value in (("--settings", settings), ("--margin", margin)):
        if value is not None:
            line += [name, str(value)]
    return _started(line + ["--overwrite"] * overwrite, out)


def run(case, out, *, command="compare", model=None, set=None, seed=None, threads=None, overwrite=False, arguments=()) -> Results:
    """Runs a case and loads what it wrote into the folder `out`.

    command: "compare" (all variants of the case) or "run" (one, of `model` "soft", "hard" or "auto").
    set: keys of the case and their values as they are typed, {"run.duration": "2 s"}.
    arguments: further ones of the command line, such as ["--save-state"].
    """
    line = [str(binary()), command, str(case), "--out", str(out), "--quiet"]
    for name, value in (("--model", model), ("--seed", seed), ("--threads", threads)):
        if value is not None:
            line += [name, str(value)]
    for key, value in (set or {}).items():
        line += ["--set", f"{key}={value}"]
    if overwrite:
        line.append("--overwrite")
    return _started([*line, *map(str, arguments)], out)
