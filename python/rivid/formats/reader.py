"""The process that reads one file, for rivid.formats: function, format, path and limits are its arguments, standard output is the answer.

That is a line of JSON, then the bytes of the columns. The line holds their names, types and numbers of rows, the lines of a list of contents, or
what stands against it.
"""

from __future__ import annotations

import importlib
import json
import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError
from rivid.formats.columns import printable

_LONGEST = 64  # characters of a word; time stamps have fewer
_LONGEST_ERROR = 400


def _confine(mebibytes: int, seconds: int) -> None:
    own = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    limits = {
        resource.RLIMIT_AS: own + (mebibytes << 20),
        resource.RLIMIT_FSIZE: mebibytes << 20,  # rosbags unpacks into files
        resource.RLIMIT_CPU: seconds,
        resource.RLIMIT_CORE: 0,
    }
    for what, most in limits.items():
        hard = resource.getrlimit(what)[1]
        resource.setrlimit(what, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _vector(values: Any) -> Any:
    array = np.asarray(values)
    if array.dtype.kind in "biufcMm":
        return array
    return np.array([str(value)[:_LONGEST] for value in array], dtype=f"U{_LONGEST}")


def _said(function: str, name: str, module: str, extra: str, path: Path, mebibytes: int, seconds: int) -> tuple[Any, list[Any]]:
    try:
        reader = importlib.import_module(module)
        _confine(mebibytes, seconds)
        found = getattr(reader, function)(path)
        if not isinstance(found, Mapping):
            return [printable(line) for line in found], []
        columns = {printable(key): _vector(values) for key, values in found.items()}
        return [(key, column.dtype.str, len(column)) for key, column in columns.items()], list(columns.values())
    except ImportError as error:
        return f"{path}: is {name}, which needs the Python package {error.name}: pip install 'rivid[{extra}]'", []
    except MemoryError:
        return (
            f"{path}: takes more than {mebibytes} MiB of memory while it is read, the limit; "
            "rivid.limit_inputs(mebibytes) or rivid convert --max-size raises it"
        ), []
    except InputError as error:
        return str(error), []
    except Exception as error:  # the libraries raise whatever a damaged file leads to
        return f"{path}: can not be read as {name}: {type(error).__name__}: {str(error)[:_LONGEST_ERROR]}", []


def main() -> None:
    """Reads the file that the command line names."""
    function, name, module, extra, path, mebibytes, seconds = sys.argv[1:]
    head, columns = _said(function, name, module, extra, Path(path), int(mebibytes), int(seconds))
    out = sys.stdout.buffer
    out.write(json.dumps(printable(head) if isinstance(head, str) else head).encode() + b"\n")
    for column in columns:
        out.write(np.ascontiguousarray(column).view(np.uint8).data)
