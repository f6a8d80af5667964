"""Plants the faults of faults.toml one at a time and asks the tests to notice.

    python3 tests/mutation/mutate.py --work build/mutation/work [--only WORD] [--check] [--list FILE]

Each fault is planted in a copy of the sources, its test programs are built and run, and the sources are mended again. A
fault survives where all its tests pass. Exit code: 0 all were caught; 1 some survived; 2 the list does not fit the sources,
does not compile, or a test fails without any fault. --check only looks whether all texts are found.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import time
import tomllib

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def read_faults(file, only):
    faults = tomllib.loads(file.read_text(encoding="utf-8"))["fault"]
    names = [fault["name"] for fault in faults]
    if len(set(names)) < len(names):
        sys.exit("a name is given twice: " + ", ".join(n for n in names if names.count(n) > 1))
    return [fault for fault in faults if only in fault["name"] or only in fault["file"]]


def complaint(fault):
    """What is wrong with a fault of the list, or None."""
    file = SOURCE / fault["file"]
    if not file.exists():
        return "no such file: " + fault["file"]
    count = file.read_text(encoding="utf-8").count(fault["text"])
    if count != 1:
        return f"its text is found {count} times in {fault['file']}, must be there once"
    if fault["text"] == fault["with"]:
        return "it changes nothing"
    return None


def copy_sources(to):
    """The files that git knows or would add, those alone rewritten that differ, so that little is built again."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=SOURCE, capture_output=True, check=True)
    wanted = {name for name in listed.stdout.decode().split("\0") if name and (SOURCE / name).is_file()}
    for name in wanted:
        content = (SOURCE / name).read_bytes()
        target = to / name
        if not target.exists() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            target.chmod((SOURCE / name).stat().st_mode)
    for path in [path for path in to.rglob("*") if path.is_file()]:
        if str(path.relative_to(to)) not in wanted:
            path.unlink()


class Tree:
    """The copy and its build."""

    def __init__(self, work, jobs):
        self.source = work / "source"
        self.build = work / "build"
        self.jobs = jobs
        copy_sources(self.source)
        subprocess.run(
            ["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
             "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DRIVID_BUILD_EXAMPLES=OFF",
             "-DRIVID_REAL_DATA=", "-DRIVID_PYTHON=OFF"],
            check=True, stdout=subprocess.DEVNULL)

    def make(self, programs):
        """Whether the programs could be built, and what the compiler said."""
        run = subprocess.run(
            ["cmake", "--build", self.build, "--parallel", str(self.jobs), "--target", *programs],
            capture_output=True, text=True)
        return run.returncode == 0, run.stdout + run.stderr

    def failing(self, tests):
        """The first test, "program" or "program:filter", that fails, or None."""
        for test in tests:
            program, _, names = test.partition(":")
            try:
                run = subprocess.run(
                    [self.build / "tests" / program, "--gtest_filter=" + (names or "*")],
                    capture_output=True, text=True, timeout=900, cwd=self.build,
                    env=os.environ | {"GTEST_FAIL_FAST": "1"})
            except subprocess.TimeoutExpired:
                return test + " (no end)"
            if run.returncode != 0:
                return test
            if "[  PASSED  ] 0 tests" in run.stdout:
                return test + " (runs nothing)"
        return None


def programs_of(faults):
    return sorted({test.partition(":")[0] for fault in faults for test in fault["tests"]})


def plant(tree, fault):
    """One line on what became of a fault, and whether it was caught; None for a fault that does not compile."""
    file = tree.source / fault["file"]
    healthy = file.read_text(encoding="utf-8")
    file.write_text(healthy.replace(fault["text"], fault["with"]), encoding="utf-8")
    try:
        built, said = tree.make(programs_of([fault]))
        if not built:
            return said[-2000:], None
        caught = tree.failing(fault["tests"])
        return caught or "SURVIVED " + ", ".join(fault["tests"]), caught is not None
    finally:
        file.write_text(healthy, encoding="utf-8")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--work", type=pathlib.Path, default=SOURCE / "build/mutation/work")
    arguments.add_argument("--list", type=pathlib.Path, default=pathlib.Path(__file__).with_name("faults.toml"))
    arguments.add_argument("--only", default="", help="faults with this in their name or file")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments.add_argument("--check", action="store_true", help="only look whether the texts are found")
    options = arguments.parse_args()

    faults = read_faults(options.list, options.only)
    wrong = [f"{fault['name']}: {why}" for fault in faults if (why := complaint(fault))]
    if wrong or options.check:
        print("\n".join(wrong) or f"{len(faults)} faults fit the sources")
        return 2 if wrong else 0

    tree = Tree(options.work.resolve(), options.jobs)
    built, said = tree.make(programs_of(faults))
    if not built:
        print(said[-4000:])
        return 2
    if failing := tree.failing(sorted({test for fault in faults for test in fault["tests"]})):
        print(f"{failing} fails without any fault")
        return 2

    survivors = []
    for number, fault in enumerate(faults, 1):
        begin = time.monotonic()
        outcome, caught = plant(tree, fault)
        print(f"[{number}/{len(faults)}] {fault['name']}: {outcome} ({time.monotonic() - begin:.0f} s)", flush=True)
        if caught is None:
            return 2
        if not caught:
            survivors.append(fault["name"])
    print(f"{len(faults) - len(survivors)} of {len(faults)} faults caught"
          + "".join(f"\nsurvived: {name}" for name in survivors))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
