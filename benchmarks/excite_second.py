"""What a second motion is worth that is designed for what the first one leaves open.

For each experiment file: the first motion, the first motion run twice, and second designs of three seeds that know the log of the
first. Printed: nats of log det above running the first twice, and processor seconds of a design.

    python benchmarks/excite_second.py build/test/apps/rivid_excite data/six_axis/excite.toml [more.toml …] [--second KEY=VALUE …]
"""

import argparse
import json
import pathlib
import resource
import subprocess
import tempfile

SEEDS = (11, 21, 31)
LOG = ["--set", 'log.files="none.csv"', "--set", 'signal.cutoff_hz="off"', "--set", "signal.decimation=10"]


def run(arguments):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*arguments, "--quiet"], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def log_det(file):
    return json.loads(file.read_text())["log_det"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("excite")
    parser.add_argument("files", nargs="+")
    parser.add_argument("--second", action="append", default=[], help="setting of the second design alone")
    to = parser.parse_args()
    excite = to.excite
    second = [word for setting in to.second for word in ("--set", setting)]
    for file in to.files:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            seconds = [run([excite, file, *LOG, "--threads", "1", "--output", folder / "first"])]
            known = [*LOG, "--set", f'excitation.known=["{folder / "first/motion.csv"}"]']
            run([excite, "forecast", file, folder / "first/motion.csv", *known, "--output", folder / "twice"])
            twice = log_det(folder / "twice/forecast.json")
            gains = []
            for seed in SEEDS:
                output = folder / f"second_{seed}"
                seconds.append(
                    run([excite, file, *known, *second, "--threads", "1", "--seed", str(seed), "--output", output])
                )
                gains.append(log_det(output / "plan.json") - twice)
            first = log_det(folder / "first/plan.json")
        print(
            f"{file}: first {first:.1f}, twice {twice:.1f}, second designs "
            + ", ".join(f"{gain:+.1f}" for gain in gains)
            + f"; {sum(seconds) / len(seconds):.1f} s a design",
            flush=True,
        )


if __name__ == "__main__":
    main()
