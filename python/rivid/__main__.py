"""The program `rivid` of the package: `rivid convert` writes logs of other formats as CSV; all else is the program in bin/."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError, version, write_file
from rivid._tools import PROGRAM
from rivid._tools import main as become_the_program
from rivid.formats import beyond_numbers, contents, is_text, limit_inputs, read
from rivid.formats.columns import complete, printable, with_seconds


def _is_position(name: str) -> bool:
    return name.endswith("/position") or (name[:1] == "q" and name[1:].isdigit())


def _numeric(table: dict[str, Any]) -> tuple[list[str], Any]:
    columns = {name: np.asarray(values) for name, values in table.items()}
    names = [name for name, values in columns.items() if values.dtype.kind in "fiub"]
    # A column that is empty as a whole holds nothing, and would take all rows with it.
    names = [name for name in names if not np.isnan(columns[name].astype(float)).all()]
    names.sort(key=lambda name: name not in ("t", "time"))
    return names, np.column_stack([columns[name].astype(float) for name in names])


def convert(source: Path, target: Path, *, force: bool = True) -> list[str]:
    """Writes a log as CSV; returns what was done.

    Raises InputError where ``target`` is the log, or is there and no CSV; unless ``force``, also where it is a CSV of another content.
    """
    table = beyond_numbers(source) if is_text(source) else read(source)
    if not table:
        raise InputError(f"{source}: is text, or of a format that is not known; the tools read CSV files as they are")
    names, values = _numeric(with_seconds(table))
    notes: list[str] = []
    clock = next((name for name in ("t", "time") if name in names), None)
    if clock:
        values, notes = complete(names, values, clock, filter(_is_position, names))
    elif np.isnan(values).any():
        raise InputError(f"{source}: there are empty cells, and no time column to interpolate over")
    if not len(values):
        raise InputError(f"{source}: no row has a value in each of the columns {', '.join(names)}")
    quoted = ['"' + name.replace('"', '""') + '"' if re.search("[,;\t\"#%]", name) else name for name in names]
    rows = (",".join(map(repr, row)) for row in values.tolist())
    text = "\n".join([",".join(quoted), *rows, ""])
    own = force or not target.is_file() or target.samefile(source) or target.suffix != ".csv"
    if not own and target.read_bytes() != text.encode():
        raise InputError(f"{target}: is there already, with another content; name another file, or --force replaces it")
    write_file(target, text, ".csv", [source])
    return [*notes, f"{len(values)} rows of {', '.join(names)}"]


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rivid", description="Logs for the command line tools of rivid.")
    parser.add_argument("--version", action="version", version=version)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser(
        "convert",
        help="write a log of another format as CSV",
        description="Writes a bag (MCAP, rosbag2, ROS 1), .mat, .npz, .npy, Parquet or Feather file as CSV.",
    )
    command.add_argument("source", type=Path, metavar="LOG")
    command.add_argument("target", type=Path, metavar="LOG.csv", nargs="?")
    command.add_argument("--max-size", type=int, metavar="MIB", help="most memory that LOG takes while it is read [MiB]; default: 2048")
    command.add_argument("--force", action="store_true", help="replace a CSV file of another content")
    command.add_argument("--list", action="store_true", help="print what the file holds, write nothing")
    return parser


def main() -> int:
    """Runs the command line; the exit code is 2 for what can not be used."""
    if sys.argv[1:2] != ["convert"] and PROGRAM.is_file():
        become_the_program()
    parser = _arguments()
    arguments = parser.parse_args()
    if not arguments.list and arguments.target is None:
        parser.error("the CSV file to write is required, or --list")
    try:
        if arguments.max_size is not None:
            limit_inputs(arguments.max_size)
        if arguments.list:
            if is_text(arguments.source):
                raise InputError(f"{arguments.source}: is text, or of a format that is not known")
            print("\n".join(contents(arguments.source)))
        else:
            for note in convert(arguments.source, arguments.target, force=arguments.force):
                print(f"note: {printable(note)}", file=sys.stderr)
    except (InputError, OSError) as error:
        print(f"rivid: error: {printable(str(error))}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
