#!/usr/bin/env python3
"""Coverage of the intervals of payloads, through the tools, on the arm of data/six_axis.

    benchmarks/payload_coverage.py build/test/apps/rivid [--runs 100] [--seed 1] [--only wrist]

Each run draws drive gains (1 % off the nominal ones), the encoder noise's seed, a payload of 0.5 to 10 kg with centre
and inertia, and motions: one of 20 s without payload, and with it

  free    ten seconds of all joints
  wrist   ten seconds of the last three joints, the others held
  slow    four poses, with slow moves between them
  static  the rests in four poses alone, a log each
  point   as free, with --model point

and counts the intervals of mass and centre of mass that hold the truth, those of identified payloads alone and of all.
"""

import argparse
import collections
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

DATA = pathlib.Path(__file__).resolve().parents[1] / "data/six_axis"
KINDS = ("free", "wrist", "slow", "static", "point")


def carrying(urdf: str, mass: float, com: np.ndarray, moments: np.ndarray) -> str:
    """The description with a body on the flange."""
    ixx, iyy, izz = moments
    return urdf.replace("</robot>", f"""<link name="load"><inertial><origin xyz="{com[0]} {com[1]} {com[2]}"/><mass value="{mass}"/>
<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/></inertial></link>
<joint name="grasp" type="fixed"><parent link="flange"/><child link="load"/></joint></robot>""")


def fourier(random: np.random.Generator, moving: range, seconds: float) -> str:
    """[reference] of five harmonics."""
    size = np.zeros(6)  # rad, of each harmonic
    size[moving] = [0.2, 0.15, 0.15, 0.3, 0.3, 0.3][moving.start:]
    omega_f = 2 * np.pi / seconds
    parts = {name: (random.normal(size=(6, 5)) * size[:, None] * omega_f * np.arange(1, 6)).round(4).tolist() for name in "AB"}
    middle = [0.0, -1.0, 1.2, 0.0, 0.8, 0.0]
    return f"type = 'fourier'\nomega_f = {omega_f}\nA = {parts['A']}\nB = {parts['B']}\nq0 = {middle}\n"


def poses(random: np.random.Generator) -> str:
    """[reference] of four poses of the wrist, held for three seconds each."""
    arm = random.uniform(-0.5, 0.5, 3) + [0.0, -1.0, 1.2]
    via = [np.concatenate([arm, random.uniform(-1.5, 1.5, 3)]).round(4).tolist() for _ in range(4)]
    return f"type = 'point_to_point'\nvia = {via}\ndurations = 4.0\ndwell = 3.0\n"


def with_gains(log: pathlib.Path, gains: np.ndarray, at_rest: bool) -> list[pathlib.Path]:
    """Writes the torques as drives of other gains report them; returns the log, or those of its rests."""
    with log.open() as file:
        lines = list(csv.reader(file))
    head, table = lines[0], np.array(lines[1:], dtype=float)
    for joint, gain in enumerate(gains):
        table[:, head.index(f"v{joint + 1}")] *= gain
    pieces = [table]
    if at_rest:
        reference = table[:, [head.index(f"qref{j + 1}") for j in range(6)]]
        moves = np.flatnonzero(np.abs(np.diff(reference, axis=0)).max(axis=1) > 0)
        ends = [0, *moves[np.flatnonzero(np.diff(moves) > 1)] + 1, moves[-1] + 1]
        # From half a second after each move, when the loop has settled.
        pieces = [table[end + 500:end + 2900] for end in ends]
    files = [log] if len(pieces) == 1 else [log.with_name(f"rest_{at}.csv") for at in range(len(pieces))]
    for file, piece in zip(files, pieces):
        with file.open("w", newline="") as out:
            csv.writer(out).writerows([head, *piece.tolist()])
    return files


def main() -> int:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("program", type=pathlib.Path)
    asked.add_argument("--runs", type=int, default=100)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--only", choices=KINDS)
    given = asked.parse_args()
    program = given.program.resolve()

    def run(*words: object) -> str:
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
        if done.returncode > 1:
            raise RuntimeError(f"{words}: {done.stderr}")
        return done.stdout

    statuses: dict[str, collections.Counter[str]] = {kind: collections.Counter() for kind in KINDS}
    warnings: dict[str, collections.Counter[str]] = {kind: collections.Counter() for kind in KINDS}
    held: dict[tuple[str, str, bool], list[bool]] = collections.defaultdict(list)
    widths: dict[tuple[str, str], list[float]] = collections.defaultdict(list)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        urdf = (DATA / "six_axis.urdf").read_text()
        (folder / "six_axis.urdf").write_text(urdf)
        before, _, after = (DATA / "simulate.toml").read_text().partition("[reference]")
        after = after[after.index("[simulation]"):]
        for at in range(given.runs):
            random = np.random.default_rng([given.seed, at])
            gains = 1 + 0.01 * random.normal(size=6)
            mass = float(np.exp(random.uniform(np.log(0.5), np.log(10))))
            com = random.uniform(-0.08, 0.08, 3) + [0, 0, 0.08]
            # Of a box, of its density what it may be.
            sides = random.uniform(0.05, 0.25, 3) ** 2
            loaded = folder / "loaded.urdf"
            loaded.write_text(carrying(urdf, mass, com, mass / 12 * (sides.sum() - sides)))

            def simulated(to: str, description: str, reference: str, still: bool = False) -> list[pathlib.Path]:
                (folder / "simulate.toml").write_text(before.replace("six_axis.urdf", description, 1) + "[reference]\n" + reference + after)
                run("simulate", folder / "simulate.toml", "--seed", random.integers(1 << 31), "--output", folder / to, "--quiet", "--force")
                return with_gains(folder / to / "log.csv", gains, still)

            [arm] = simulated("arm", "six_axis.urdf", fourier(random, range(0, 6), 20.0))
            run("init", folder / "six_axis.urdf", arm, "--output", folder / "six_axis.toml", "--force")
            for kind in [given.only] if given.only else KINDS:
                reference = {"wrist": fourier(random, range(3, 6), 10.0), "slow": poses(random), "static": poses(random)}
                logs = simulated("carried", "loaded.urdf", reference.get(kind, fourier(random, range(0, 6), 10.0)), kind == "static")
                try:
                    found = json.loads(run("payload", folder / "six_axis.toml", *[f"--loaded=payload={log}" for log in logs], "--json", "--quiet", "--force", "--output", folder / "out",
                                           *(["--model", "point"] if kind == "point" else [])))
                except RuntimeError as error:
                    statuses[kind]["refused"] += 1
                    print(at, kind, error, file=sys.stderr)
                    continue
                statuses[kind][found["status"]] += 1
                for warning in found["warnings"]:
                    warnings[kind][warning["code"] if "code" in warning else str(warning)] += 1
                values = found["payloads"][0]["values"]
                for key, truth in zip(("mass", "com_x", "com_y", "com_z"), (mass, *com)):
                    if key in values and values[key]["interval_95"] is not None:
                        low, high = values[key]["interval_95"]
                        for all_of_them in (False, True):
                            if all_of_them or found["status"] == "identified":
                                held[kind, key, all_of_them].append(low <= truth <= high)
                        widths[kind, key].append((high - low) / 2 / (mass if key == "mass" else 1e-3))
    for kind in KINDS:
        if not statuses[kind]:
            continue
        print(f"{kind}: " + ", ".join(f"{count} {status}" for status, count in sorted(statuses[kind].items())) +
              "".join(f"; {count} {code}" for code, count in warnings[kind].most_common()))
        for key in ("mass", "com_x", "com_y", "com_z"):
            some, every = held[kind, key, False], held[kind, key, True]
            if every:
                print(f"  {key:6} identified {100 * np.mean(some) if some else float('nan'):5.1f} % of {len(some)}, all {100 * np.mean(every):5.1f} % of "
                      f"{len(every)}, ± {np.median(widths[kind, key]) * (100 if key == 'mass' else 1):.2f} {'%' if key == 'mass' else 'mm'} in median")
    return 0


if __name__ == "__main__":
    sys.exit(main())
