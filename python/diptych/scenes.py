"""Scenes from Python values: the text of a case from a dict, and the table of its start from arrays."""

import csv
import io
import json
import math
import os
import re
from collections.abc import Mapping

import numpy as np

from .errors import InputError


def case_text(scene: Mapping, radii=None, species=None) -> str:
    """Text of a case from a dict with its tables. A kind of particles (species) without a size gets the sizes of its particles from `radii`."""
    scene = {key: value for key, value in scene.items() if value is not None}
    if radii is not None and "particles" in scene:
        scene["particles"] = _sized(scene["particles"], np.asarray(radii, dtype=float), species)
    return "".join(f"{_key(key)} = {_value(value, str(key))}\n" for key, value in scene.items())


def start_table(positions, velocities=None, radii=None, species=None, spins=None) -> str:
    """Text of the table of the particles at the start, in SI units. Numbers keep all their bits."""
    places = _array("positions", positions, None, 3)
    count = len(places)
    columns = {"id": range(count), **dict(zip("xyz", places.T.tolist()))}
    for name, letter, vectors in (("velocities", "v", velocities), ("spins", "w", spins)):
        if vectors is not None:
            columns |= {f"{letter}{axis}": column for axis, column in zip("xyz", _array(name, vectors, count, 3).T.tolist())}
    if radii is not None:
        columns["diameter"] = (2 * _array("radii", radii, count, None)).tolist()
    if species is not None:
        columns["species"] = np.asarray(species).tolist()
        if len(columns["species"]) != count:
            raise InputError(f"error: `species` has {len(columns['species'])} entries for {count} positions")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values()))
    return text.getvalue()


def _array(name: str, values, rows: int | None, width: int | None) -> np.ndarray:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as why:
        raise InputError(f"error: `{name}` is no array of numbers: {why}") from None
    rows = len(array) if rows is None and array.ndim else rows
    wanted = (rows,) if width is None else (rows, width)
    if array.shape != wanted:
        raise InputError(f"error: `{name}` has the shape {array.shape} where {wanted} belongs")
    return array


def _sized(kinds, radii: np.ndarray, species) -> list:
    """Kinds of particles (species) of a case. A kind without a size gets the diameters of its particles."""
    of = None if species is None else np.asarray(species)
    sized = []
    for number, kind in enumerate(kinds):
        if not {"diameter", "sizes", "use"} & set(kind):
            own = radii if of is None else radii[(of == number) | (of == kind.get("name"))]
            diameters, shares = np.unique(2 * own, return_counts=True)
            table = {"diameters": diameters.tolist(), "fractions": shares.tolist()}
            kind = {**kind, **({"diameter": table["diameters"][0]} if len(diameters) == 1 else {"sizes": {"table": table}})}
        sized.append(kind)
    return sized


def _key(key) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", str(key)) else json.dumps(str(key), ensure_ascii=False)


def _value(value, key: str) -> str:
    """Text of a value in TOML. `key` names the value in messages."""
    value = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
    if isinstance(value, Mapping):
        entries = ((name, entry) for name, entry in value.items() if entry is not None)
        return "{" + ", ".join(f"{_key(name)} = {_value(entry, f'{key}.{name}')}" for name, entry in entries) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(entry, f"{key}[{place}]") for place, entry in enumerate(value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) or isinstance(value, float) and math.isfinite(value):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    raise InputError(f"error: `{key}` = {value!r}\nhelp: a finite number, a text such as \"2 mm\", true or false, a list or a dict")
