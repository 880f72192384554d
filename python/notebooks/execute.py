"""Executes a notebook from its start to its end, without storing the output; an error of a cell ends it with exit code 1."""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

path = Path(sys.argv[1])
NotebookClient(nbformat.read(path, as_version=4), timeout=120).execute()
print(f"{path.name}: executed")
