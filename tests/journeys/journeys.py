"""The ways of CONTRIBUTING.md gone once: an option, a figure, a friction law, a control law, an export format, a log format and a finding.

    python3 tests/journeys/journeys.py [--check] [--work build/journeys]

Each patch of this folder is one of them. --check applies them all to a copy of the sources and counts their files, at most three each, without what a
test writes or shows: tables of pages, the line of codes of docs/diagnostics.md. Without it the tools are built with all of them and asked for what they have learned.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
SOURCE = FOLDER.parents[1]
MOST_FILES = 3


def copy_with_patches(to):
    """The files that git knows or would add, with all patches; what is wrong with these."""
    shutil.rmtree(to, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            cwd=SOURCE, capture_output=True, check=True)
    for name in listed.stdout.decode().split("\0"):
        if name and (SOURCE / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(SOURCE / name, to / name)
    wrong = []
    for patch in sorted(FOLDER.glob("*.patch")):
        files = [line for line in patch.read_text(encoding="utf-8").splitlines() if line.startswith("+++ ")]
        if len(files) > MOST_FILES:
            wrong.append(f"{patch.name} changes {len(files)} files, {MOST_FILES} are wanted at most")
        # Within a repository git would take the paths for its own.
        applied = subprocess.run(["git", "apply", "-C1", patch], cwd=to, capture_output=True, text=True,
                                 env=os.environ | {"GIT_CEILING_DIRECTORIES": str(to.parent)})
        if applied.returncode != 0:
            wrong.append(f"{patch.name} does not fit the sources: {applied.stderr.strip()}")
    return wrong


def answers(apps, work):
    """What the tools must say, a journey each: arguments and a part of the answer."""
    log = work / "log.csv"
    log.write_text("<stata_dta>", encoding="utf-8")
    scara = SOURCE / "data/scara"
    rivid = apps / "rivid"
    return {
        "control_law": ([rivid, "simulate", scara / "simulate_s1.toml", "--set", "control.law=sprang", "--dry-run"], "spring"),
        "export_format": ([rivid, "export", "--help"], "frictions"),
        "finding": ([rivid, "explain", "long_log"], "More than an hour"),
        "friction_law": ([rivid, "identify", scara / "scara.toml", "--set", "robot.friction=stribeck", "--dry-run"], "stribeck"),
        "log_format": ([rivid, "init", scara / "scara.urdf", log, "--print"], "is a Stata file"),
        "option": ([rivid, "excite", SOURCE / "data/six_axis/excite.toml", "--set", "excitation.usual_noise=0.02", "--dry-run"], "usual_noise"),
    }


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--work", type=pathlib.Path, default=SOURCE / "build/journeys")
    arguments.add_argument("--check", action="store_true", help="only apply the patches and count their files")
    options = arguments.parse_args()
    work = options.work.resolve()
    wrong = copy_with_patches(work / "source")
    if wrong or options.check:
        print("\n".join(wrong) or f"{len(list(FOLDER.glob('*.patch')))} journeys fit the sources")
        return 1 if wrong else 0

    build = work / "build"
    subprocess.run(["cmake", "-S", work / "source", "-B", build, "-G", "Ninja", "-DCMAKE_UNITY_BUILD=ON", "-DRIVID_BUILD_TESTS=OFF",
                    "-DRIVID_BUILD_EXAMPLES=OFF", "-DRIVID_BUILD_BENCHMARKS=OFF"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", build, "--target", "demo"], check=True)
    for name, (command, part) in answers(build / "apps", work).items():
        run = subprocess.run(command, capture_output=True, text=True, cwd=work)
        if part not in run.stdout + run.stderr:
            wrong.append(f"{name}: {' '.join(map(str, command))} says nothing of {part}:\n{run.stdout}{run.stderr}")
    print("\n".join(wrong) or "all journeys arrive")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
