#!/usr/bin/env python3
"""Ratios of the benchmarks, release by release.

    history.py record PROGRAMS NAME     measures them and writes NAME.json beside this file
    history.py check PROGRAMS           fails where one has fallen by more than 30 % against the last record of a machine with
                                        the same vector registers; exit code 77 where there is none
    history.py page README.md           fails where the table of the page is not that of the records; --write puts it there

PROGRAMS is the folder of the programs, build/release/benchmarks. A ratio compares two ways to do the same thing within one
process, in turns: other work on the machine meets both. Seconds are not kept.
"""

import argparse
import json
import pathlib
import platform
import re
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parent
# Program: its benchmarks, and the counters that are ratios.
MEASURED = {
    "benchmark_monte_carlo": (".*", ["x_one_by_one"]),
    "benchmark_iv": ("kept_rows", ["x_made_anew"]),
    "benchmark_dynamics": ("scara|tx40|panda", ["kdl_ratio"]),
    "benchmark_streaming_qr": ("^streaming_qr", ["x_one_shot"]),
}
LARGEST_FALL = 0.30
# Other work can take one side of a ratio unawares: what has fallen is measured again.
ATTEMPTS = 3
SKIPPED = 77
BEGIN = "<!-- history: written by benchmarks/history/history.py page --write -->"
END = "<!-- end of history -->"


def measured(programs, name):
    pattern, counters = MEASURED[name]
    command = [programs / name, f"--benchmark_filter={pattern}", "--benchmark_format=json"]
    result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    ratios = {}
    for benchmark in result["benchmarks"]:
        for counter in counters:
            if counter in benchmark:
                title = benchmark["name"].removesuffix("/iterations:1").removesuffix("/manual_time")
                ratios[f"{name.removeprefix('benchmark_')}/{title}/{counter}"] = round(benchmark[counter], 3)
    if not ratios:
        sys.exit(f"history.py: {name} gave none of {', '.join(counters)}")
    return ratios


def machine():
    description = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8") if sys.platform == "linux" else ""
    model = re.search(r"model name\s*: (.*)", description)
    registers = next((name for name in ("avx512f", "avx2") if re.search(rf"\b{name}\b", description)), "none")
    return {"processor": model.group(1) if model else platform.processor(), "registers": registers}


def records():
    """All that are stored, the oldest first."""
    loaded = [json.loads(path.read_text(encoding="utf-8")) for path in FOLDER.glob("*.json")]
    return sorted(loaded, key=lambda record: (record["date"], record["name"]))


def record(arguments):
    ratios = {}
    for name in arguments.only or MEASURED:
        ratios |= measured(arguments.programs, name)
    document = {"name": arguments.name, "date": arguments.date, "machine": machine(), "ratios": ratios}
    path = FOLDER / f"{arguments.name}.json"
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"wrote {path}")
    return 0


def programs_of(ratios):
    """The programs that give these."""
    return [name for name in MEASURED if any(title.startswith(name.removeprefix("benchmark_") + "/") for title in ratios)]


def fallen(before, now):
    """Ratios that are too small, or missing."""
    return {name: value for name, value in before.items() if now.get(name, 0.0) < (1.0 - LARGEST_FALL) * value}


def check(arguments):
    here = machine()["registers"]
    alike = [one for one in records() if one["machine"]["registers"] == here]
    if not alike:
        print(f"history.py: no record of a machine with {here} registers")
        return SKIPPED
    before = alike[-1]["ratios"]
    now = {}
    programs = programs_of(before)
    for _ in range(ATTEMPTS):
        for name in programs:
            for title, value in measured(arguments.programs, name).items():
                now[title] = max(value, now.get(title, 0.0))
        low = fallen(before, now)
        programs = programs_of(low)
        if not programs:
            break
    for title, value in low.items():
        print(f"{title}: {now.get(title, 'not measured')}, was {value} in {alike[-1]['name']}")
    return 1 if low else 0


def table(stored):
    head = ["ratio"] + [f"{one['name']} ({one['machine']['registers']})" for one in stored]
    rows = [head, ["---"] * len(head)]
    for title in sorted({title for one in stored for title in one["ratios"]}):
        rows.append([f"`{title}`"] + [f"{one['ratios'][title]:.3g}" if title in one["ratios"] else "" for one in stored])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def page(arguments):
    text = arguments.page.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    wanted = f"{before}{BEGIN}\n{table(records())}\n{END}{after}"
    if wanted == text:
        return 0
    if arguments.write:
        arguments.page.write_text(wanted, encoding="utf-8")
        return 0
    print(f"{arguments.page}: not the table of the records; run history.py page --write {arguments.page}")
    return 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("record")
    command.add_argument("programs", type=pathlib.Path)
    command.add_argument("name")
    command.add_argument("--only", nargs="+", choices=MEASURED, help="of these programs alone; check then looks at no others")
    command.add_argument("--date", required=True, help="YYYY-MM-DD, by which records are in order")
    command.set_defaults(run=record)
    command = commands.add_parser("check")
    command.add_argument("programs", type=pathlib.Path)
    command.set_defaults(run=check)
    command = commands.add_parser("page")
    command.add_argument("page", type=pathlib.Path)
    command.add_argument("--write", action="store_true")
    command.set_defaults(run=page)
    arguments = parser.parse_args()
    return arguments.run(arguments)


if __name__ == "__main__":
    sys.exit(main())
