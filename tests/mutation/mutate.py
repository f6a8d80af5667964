"""Plants the faults of faults.toml, all of them in one build, and asks the tests to notice each.

    python3 tests/mutation/mutate.py --work build/mutation/work [--only WORD] [--check] [--list FILE] [--table FILE]

All faults are written into a copy of the sources, each behind a switch that the environment variable RIVID_FAULT turns on, so that every file
is compiled once. A fault is caught where one of its tests fails with it, and all pass without. Exit code: 0 enough were caught; 1 too few;
2 the list does not fit the sources, does not compile, or a test fails without any fault. --check only looks whether all texts are found.
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import tomllib

SOURCE = pathlib.Path(__file__).resolve().parents[2]
ENOUGH = 0.95  # part of the faults that the tests must catch

SWITCH = """#include <cstdlib>
extern "C" bool rivid_planted(int number) noexcept {
  static const int planted = [] {
    const char* const text = std::getenv("RIVID_FAULT");
    return text == nullptr ? 0 : std::atoi(text);
  }();
  return planted == number;
}
"""
DECLARATION = 'extern "C" bool rivid_planted(int number) noexcept;\n'


class Planted:
    """One fault of the list."""

    def __init__(self, number, entry):
        self.number = number
        self.name = entry["name"]
        self.file = entry["file"]
        self.text = entry["text"].strip()
        self.wrong = entry["with"].strip()
        self.tests = entry["tests"]

    def places(self, content):
        """Where the text is, however it is wrapped."""
        words = [re.escape(word) for word in self.text.split()]
        return [match.span() for match in re.finditer(r"\s+".join(words), content)]

    def complaint(self):
        """What is wrong with it, or None."""
        file = SOURCE / self.file
        if not file.exists():
            return "no such file: " + self.file
        count = len(self.places(file.read_text(encoding="utf-8")))
        if count != 1:
            return f"its text is found {count} times in {self.file}, must be there once"
        return "it changes nothing" if self.text == self.wrong else None

    def switched(self):
        """C++ that is right without the switch and wrong with it: that of the list where it has $fault; else an either-or of
        the condition of an `if`, of statements, or of an expression."""
        fault = f"rivid_planted({self.number})"
        if "$fault" in self.wrong:
            return self.wrong.replace("$fault", fault)
        right, wrong = (re.fullmatch(r"if \((.*)\) \{", text, re.DOTALL) for text in (self.text, self.wrong))
        if right and wrong:
            return f"if ({fault} ? ({wrong[1]}) : ({right[1]})) {{"
        if self.text.endswith(";"):
            return f"if ({fault}) {{ {self.wrong} }} else {{ {self.text} }}"
        return f"({fault} ? ({self.wrong}) : ({self.text}))"


def read_faults(file, only):
    entries = tomllib.loads(file.read_text(encoding="utf-8"))["fault"]
    names = [entry["name"] for entry in entries]
    if len(set(names)) < len(names):
        sys.exit("a name is given twice: " + ", ".join(sorted({n for n in names if names.count(n) > 1})))
    faults = [Planted(number, entry) for number, entry in enumerate(entries, 1)]
    return [fault for fault in faults if only in fault.name or only in fault.file]


def with_faults(content, faults):
    """A file with all its faults behind their switches."""
    for (begin, end), fault in sorted(((fault.places(content)[0], fault) for fault in faults), key=lambda at: at[0],
                                      reverse=True):
        content = content[:begin] + fault.switched() + content[end:]
    return DECLARATION + content


def copy_sources(to, faults):
    """The files that git knows or would add, with the faults; those alone rewritten that differ, so that little is built again."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=SOURCE, capture_output=True, check=True)
    contents = {name: (SOURCE / name).read_bytes()
                for name in listed.stdout.decode().split("\0") if name and (SOURCE / name).is_file()}
    for name in {fault.file for fault in faults}:
        contents[name] = with_faults(contents[name].decode(), [f for f in faults if f.file == name]).encode()
    contents["src/planted_fault.cpp"] = SWITCH.encode()
    for name, content in contents.items():
        target = to / name
        if not target.exists() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            if (SOURCE / name).exists():
                target.chmod((SOURCE / name).stat().st_mode)
    for path in [path for path in to.rglob("*") if path.is_file()]:
        if str(path.relative_to(to)) not in contents:
            path.unlink()


class Tree:
    """The copy and its build."""

    def __init__(self, work, jobs, faults):
        self.source = work / "source"
        self.build = work / "build"
        self.jobs = jobs
        self.took = {}  # seconds of each test without a fault
        copy_sources(self.source, faults)
        subprocess.run(
            ["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
             "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DCMAKE_UNITY_BUILD=ON", "-DRIVID_BUILD_EXAMPLES=OFF",
             "-DRIVID_REAL_DATA=", "-DRIVID_PYTHON=OFF"],
            check=True, stdout=subprocess.DEVNULL)

    def make(self, programs):
        """What the compiler said where the programs could not be built, else None."""
        run = subprocess.run(
            ["cmake", "--build", self.build, "--parallel", str(self.jobs), "--target", *programs],
            capture_output=True, text=True)
        return None if run.returncode == 0 else run.stdout + run.stderr

    def fails(self, test, number):
        """Why a test, "program" or "program:filter", fails with a fault, or None. Fault 0 is none."""
        program, _, names = test.partition(":")
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                run = subprocess.run(
                    [self.build / "tests" / program, "--gtest_filter=" + (names or "*")],
                    capture_output=True, text=True, errors="replace", cwd=folder,
                    timeout=900 if number == 0 else 60 + 10 * self.took[test],
                    env=os.environ | {"GTEST_FAIL_FAST": "1", "RIVID_FAULT": str(number), "TMPDIR": folder,
                                      "TEST_TMPDIR": folder})
            except subprocess.TimeoutExpired:
                return test + " (no end)"
        if number == 0:
            self.took[test] = time.monotonic() - begin
        if run.returncode != 0:
            return test
        return test + " (runs nothing)" if "[  PASSED  ] 0 tests" in run.stdout else None

    def catcher(self, fault):
        """The first test that fails with the fault, the quickest first."""
        return next((why for test in sorted(fault.tests, key=self.took.get) if (why := self.fails(test, fault.number))), None)


def table(faults, survivors):
    """Lines of Markdown: faults and those that were caught, by the module that they were planted in."""
    modules = {}
    for fault in faults:
        parts = pathlib.Path(fault.file).parent.parts
        name = parts[2] if parts[0] == "include" and len(parts) > 2 else parts[1] if len(parts) > 1 else "others"
        name += "/" + parts[2] if name == "identify" and parts[0] == "src" and len(parts) > 2 else ""
        modules.setdefault(name, []).append(fault.name not in survivors)
    lines = ["| planted in | faults | caught |", "|---|---|---|"]
    lines += [f"| {name} | {len(of)} | {sum(of)} |" for name, of in sorted(modules.items())]
    lines.append(f"| all | {len(faults)} | {len(faults) - len(survivors)} |")
    return lines


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--work", type=pathlib.Path, default=SOURCE / "build/mutation/work")
    arguments.add_argument("--list", type=pathlib.Path, default=pathlib.Path(__file__).with_name("faults.toml"))
    arguments.add_argument("--only", default="", help="faults with this in their name or file")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments.add_argument("--check", action="store_true", help="only look whether the texts are found")
    arguments.add_argument("--table", type=pathlib.Path, help="page whose end becomes a table of what was caught, as README.md")
    options = arguments.parse_args()

    faults = read_faults(options.list, options.only)
    wrong = [f"{fault.name}: {why}" for fault in faults if (why := fault.complaint())]
    if wrong or options.check:
        print("\n".join(wrong) or f"{len(faults)} faults fit the sources")
        return 2 if wrong else 0

    begin = time.monotonic()
    # All faults are planted whatever is asked for: another choice builds nothing again.
    tree = Tree(options.work.resolve(), options.jobs, [f for f in read_faults(options.list, "") if not f.complaint()])
    tests = sorted({test for fault in faults for test in fault.tests})
    if said := tree.make(sorted({test.partition(":")[0] for test in tests})):
        print(said[-4000:])
        return 2
    print(f"built in {time.monotonic() - begin:.0f} s", flush=True)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        if failing := [why for why in pool.map(lambda test: tree.fails(test, 0), tests) if why]:
            print("\n".join(why + " fails without any fault" for why in failing))
            return 2
        print(f"the tests took {sum(tree.took.values()):.0f} s without a fault", flush=True)
        survivors = []
        for fault, why in zip(faults, pool.map(tree.catcher, faults)):
            print(f"{fault.name}: {why or 'SURVIVED ' + ', '.join(fault.tests)}", flush=True)
            if not why:
                survivors.append(fault.name)
    caught = len(faults) - len(survivors)
    print(f"{caught} of {len(faults)} faults caught in {time.monotonic() - begin:.0f} s"
          + "".join(f"\nsurvived: {name}" for name in survivors))
    if options.table:
        above = options.table.read_text(encoding="utf-8").partition("| planted in")[0]
        survived = [f"\nSurvived: {'; '.join(survivors)}."] if survivors else []
        options.table.write_text(above + "\n".join(table(faults, survivors) + survived) + "\n", encoding="utf-8")
    return 0 if caught >= ENOUGH * len(faults) else 1


if __name__ == "__main__":
    sys.exit(main())
