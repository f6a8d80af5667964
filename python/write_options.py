"""Writes rivid/_options.py: a class for each table of options, from the fields of the library.

    write_options.py FOLDER_OF_THE_EXTENSION OUTPUT
"""

import sys
import textwrap
from pathlib import Path

HEAD = '''"""Options in the words of experiment files, docs/experiment.md. Written by python/write_options.py; do not edit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypedDict, Union

from rivid._keys import Control, Method, Motion, Options

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

'''

# Class, base, first lines of its text, tables of its keys, keys that the class itself stands for, and what it
# has besides.
CONTROL = "Control law of the simulated loop and how it is sampled: {}."
FIT = "{}, with the signal chain in front of it."
OF_METHOD = ["signal", "method"]
OF_LOOP = [*OF_METHOD, "method.iv"]
DIDIM = "Least squares of the torques on the regressor of the simulated loop, DIDIM"
OUTPUT_ERROR = "Closed-loop output error: positions of the simulated loop against the log's"
CLASSES = [
    ("Ols", "Method", FIT.format("Ordinary least squares, IDIM-OLS"), OF_METHOD, ["name"], []),
    ("Wls", "Method", FIT.format("Weighted least squares, IDIM-WLS"), OF_METHOD, ["name"], []),
    ("Iv", "Method", FIT.format("Instrumental variables, IDIM-IV"), OF_LOOP, ["name"], ["control"]),
    ("Didim", "Method", FIT.format(DIDIM), OF_LOOP, ["name", "prefilter"], ["control"]),
    ("OutputError", "Method", FIT.format(OUTPUT_ERROR), OF_LOOP, ["name", "prefilter"], ["control"]),
    ("Auto", "Method", FIT.format("The method that logs and controller allow"), OF_LOOP, ["name"], ["control"]),
    ("Physical", "Options", "How physically consistent parameters are looked for.", ["method.physical"], [], []),
    ("Essential", "Options", "Which parameters an estimate can do without.", ["method.essential"], [], []),
    ("Pd", "Control", CONTROL.format("PD"), ["control", "control.pd"], ["law"], []),
    ("Pid", "Control", CONTROL.format("PID"), ["control", "control.pid"], ["law"], []),
    ("Cascade", "Control", CONTROL.format("a cascade of drives"), ["control", "control.cascade"], ["law"], []),
    ("ComputedTorque", "Control", CONTROL.format("computed torque"), ["control", "control.computed_torque"], ["law"], []),
    ("Fourier", "Motion", "Finite Fourier series as reference.", ["reference.fourier"], [], []),
    ("PointToPoint", "Motion", "Moves from rest to rest as reference.", ["reference.point_to_point"], [], []),
    ("Logged", "Motion", "A reference that is in a file.", ["reference.logged"], [], []),
]
# Keys that functions take.
DICTIONARIES = [
    ("RobotKeys", "Keys of [robot].", ["robot"], ["urdf", "mdh"]),
    ("LogKeys", "Keys of [log].", ["log"], ["files"]),
    ("SimulationKeys", "Keys of [simulation].", ["simulation"], []),
]
EXTRA = {"control": ("Control | None", "the controller, as Pd, Pid, Cascade or ComputedTorque")}


# Types of the kinds of values that C++ names; one that is missing here is an error.
TYPES = {
    "boolean": "bool",
    "integer": "int",
    "number": "float",
    "string": "str",
    "file": "str | PathLike[str]",
    "list": "Sequence[Any]",
    "two numbers": "Sequence[Any]",
    "three numbers": "Sequence[Any]",
    "list of lists": "ArrayLike",
    "table": "Mapping[str, Any]",
    "list of tables": "Sequence[Mapping[str, Any]]",
    "column": "str | int | Mapping[str, Any]",
    "columns": "str | int | Mapping[str, Any] | Sequence[Any]",
}


def python_type(kinds, words):
    """The type of a key that takes these kinds of values, or one of some words."""
    out = [f"Literal[{', '.join(map(repr, dict.fromkeys(words)))}]"] if words else []
    out += [TYPES[kind] for kind in kinds if kind != "word"] or ([] if words else ["str"])
    return " | ".join(dict.fromkeys(out))


def sentence(key, otherwise, unit, meaning):
    """A key as docstrings tell it."""
    unit = f" [{unit}]" if unit else ""
    default = "" if otherwise in ("–", "required") else f" Default: {otherwise}."
    return f"{key}: {meaning.rstrip('.')}{unit}.{default}"


def wrapped(text, indent):
    return textwrap.fill(text, 116, initial_indent=indent, subsequent_indent=indent + "    ", break_on_hyphens=False)


def rows_of(tables, names, left_out):
    rows = {}
    for name in names:
        for row in tables.get(name, []):
            if row[0] not in left_out:
                rows.setdefault(row[0], row)
    return list(rows.values())


def class_text(name, base, text, rows, extra, tables):
    lines = ["", f"class {name}({base}):", f'    """{text}', ""]
    lines += [wrapped(sentence(row[0], *row[2:5]), "    ") for row in rows]
    lines += [wrapped(f"{key}: {EXTRA[key][1]}.", "    ") for key in extra]
    lines += ['    """', "", f"    _tables: ClassVar[Mapping[str, str]] = {tables!r}", "", "    def __init__(", "        self,", "        *,"]
    lines += [f"        {row[0]}: Union[{python_type(row[1], row[5])}, None] = None," for row in rows]
    lines += [f"        {key}: {EXTRA[key][0]} = None," for key in extra]
    names = [row[0] for row in rows] + extra
    lines += ["    ) -> None:", "        super().__init__("]
    lines += [f"            {key}={key}," for key in names]
    lines += ["        )", ""]
    return lines


def dictionary_text(name, text, rows):
    lines = ["", f"class {name}(TypedDict, total=False):", f'    """{text}', ""]
    lines += [wrapped(sentence(row[0], *row[2:5]), "    ") for row in rows]
    lines += ['    """', ""]
    lines += [f"    {row[0]}: Union[{python_type(row[1], row[5])}]" for row in rows]
    return [*lines, ""]


def main():
    sys.path.insert(0, sys.argv[1])
    import _rivid

    tables = _rivid.option_tables()
    lines = []
    for name, base, text, names, left_out, extra in CLASSES:
        sections = {key: table.split(".")[0] for table in names for key in [row[0] for row in tables[table]]}
        lines += class_text(name, base, text, rows_of(tables, names, left_out), extra, sections)
    for name, text, names, left_out in DICTIONARIES:
        lines += dictionary_text(name, text, rows_of(tables, names, left_out))
    exported = [entry[0] for entry in (*CLASSES, *DICTIONARIES)]
    lines += ["", f"__all__ = {exported!r}", ""]
    Path(sys.argv[2]).write_text(HEAD + "\n".join(lines), encoding="utf-8")


main()
