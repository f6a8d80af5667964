"""The program `rivid` of the package: `convert` writes logs of other formats as CSV, `play` moves a robot; all else is the program in bin/."""

from __future__ import annotations

import argparse
import importlib
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

from rivid._rivid import InputError, version, write_file
from rivid._tools import PROGRAM
from rivid._tools import main as become_the_program
from rivid.experiment import Experiment
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
    parser = argparse.ArgumentParser(prog="rivid", description="What the command line tools of rivid leave to Python.")
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
    command = commands.add_parser("play", help="play a designed motion on a robot, watch and record it")
    command.add_argument("plan", type=Path, metavar="PLAN", help="folder that rivid excite wrote")
    command.add_argument("--on", required=True, metavar="ARM", help="ros, ur:HOST, franka:HOST or simulation")
    command.add_argument("--speeds", type=_numbers, default=[0.1, 0.5, 1.0], metavar="LIST")
    command.add_argument("--tracking", type=float, default=0.1, metavar="RAD")
    command.add_argument("--torque-band", type=_numbers, metavar="LIST")
    command.add_argument("--yes", action="store_true")
    command.add_argument("--force", action="store_true")
    return parser


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split(",")]


def _convert(arguments: argparse.Namespace) -> int:
    if arguments.max_size is not None:
        limit_inputs(arguments.max_size)
    if arguments.list:
        if is_text(arguments.source):
            raise InputError(f"{arguments.source}: is text, or of a format that is not known")
        print("\n".join(contents(arguments.source)))
    else:
        for note in convert(arguments.source, arguments.target, force=arguments.force):
            print(f"note: {printable(note)}", file=sys.stderr)
    return 0


def _arm(word: str, plan: Path) -> Any:
    from rivid import play

    kind, _, host = word.partition(":")
    if (kind in ("ur", "franka")) != bool(host) or kind not in ("ros", "ur", "franka", "simulation"):
        raise InputError(f"--on is {word!r}, must be ros, ur:HOST, franka:HOST or simulation")
    try:
        if kind == "ur":
            return importlib.import_module("rivid.play.ur").UniversalRobot(host)
        if kind == "franka":
            return importlib.import_module("rivid.play.franka").Franka(host)
        robot = Experiment(plan / "experiment.toml").robot
        if kind == "ros":
            return importlib.import_module("rivid.play.ros").RosArm(robot.joints)
    except ImportError as error:
        cure = {"ur": "pip install ur_rtde", "franka": "pip install pylibfranka", "ros": "the setup file of ROS 2 must be sourced"}
        raise InputError(f"--on {word}: {error}; {cure[kind]}") from error
    return play.Simulated(robot, play.Path.of_plan(plan).at(0.0)[0])


def _play(arguments: argparse.Namespace) -> int:
    from rivid import play

    def go(speed: float, last: play.Recording | None) -> bool:
        if last is not None:
            print(f"{last}")
        return arguments.yes or input(f"Play it at {100 * speed:g} % of its speed? [y/N] ").strip().lower() == "y"

    runs = play.play(
        arguments.plan,
        _arm(arguments.on, arguments.plan),
        speeds=arguments.speeds,
        tracking=arguments.tracking,
        torque_band=arguments.torque_band,
        go=go,
        force=arguments.force,
    )
    for run in runs[-1:]:
        print(f"{run}")
        if run.stopped is None and run.speed == 1.0:
            plan = arguments.plan
            print(f"next: rivid identify {plan / 'experiment.toml'} --plan {plan / 'plan.json'}, or rivid init ROBOT.urdf {run.file}")
    return 1 if not runs or runs[-1].stopped is not None else 0


def main() -> int:
    """Runs the command line; the exit code is 2 for what can not be used."""
    if sys.argv[1:2] not in (["convert"], ["play"]) and PROGRAM.is_file():
        become_the_program()
    parser = _arguments()
    arguments = parser.parse_args()
    if arguments.command == "convert" and not arguments.list and arguments.target is None:
        parser.error("the CSV file to write is required, or --list")
    try:
        return _convert(arguments) if arguments.command == "convert" else _play(arguments)
    except (InputError, OSError) as error:
        print(f"rivid: error: {printable(str(error))}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
