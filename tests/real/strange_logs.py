#!/usr/bin/env python3
"""Real logs and pieces of them as `init` drafts them, beside a sweep over windows. Needs NumPy.

    python3 tests/real/strange_logs.py FOLDER LOGS [--sweep] [--only NAME] [--json FILE]

FOLDER holds rivid_identify and rivid_simulate, LOGS the real logs. Each case is an experiment file as `rivid init` drafts it, fitted to
one log or a piece of it and validated on another. Prints for each: exit code, rows, errors of the fit, found on the other log and forecast there,
and E, the mean error on rows of the other log every 60, 110 and 210 ms, which are the same for all windows. With --sweep also E of the best
of the windows of SPACINGS by weighted least squares, of unweighted least squares on the rows of the result, the worst joint of the result
over that, and E on the test log of the window that is best on a third log: no rule that sees the log of the fit alone can know more.

Exit code: 1 if a case is exit 0 with a validation joint above 100 % or ten times its fit, else 0.
"""

import argparse
import json
import os
import subprocess
import sys

try:
    import numpy as np
except ImportError:
    print("skipped: no NumPy")
    sys.exit(77)

JUDGED = (0.06, 0.11, 0.21)  # s
SPACINGS = (0.010, 0.014, 0.020, 0.028, 0.04, 0.055, 0.08, 0.11, 0.16, 0.22, 0.31, 0.44, 0.6)
RESAMPLED = 'log.irregular="resample"'
# Robot, logs of the same columns, settings that a draft leaves to be filled in.
ROBOTS = {
    "emps": ("emps/emps.urdf", ["emps_ident", "emps_pulses"], ["robot.rotor_inertia=false"]),
    "panda": ("panda/panda.urdf", ["panda_1khz"], ["robot.rotor_inertia=false"]),
    "ur10e": ("ur10e/ur10e.urdf", ["ident_30s_12harm", "ident_40s_12harm", "unload_14harm"], []),
    "tx40": ("tx40/tx40.urdf", ["tx40_ident"], []),
    "kuka": ("kuka_kr300/kr300.urdf", ["kr300_A", "kr300_B"], []),
    "vrep": ("ur10_vrep/ur10.urdf", ["ur10_traj1"], []),
    "kinova": ("kinova_gen3/gen3.urdf", ["opti_1", "opti_2"], [RESAMPLED]),
    "kinova_norotor": ("kinova_gen3/gen3.urdf", ["opti_1", "opti_2"], ["robot.rotor_inertia=false", RESAMPLED]),
    "kinova_coulomb": ("kinova_gen3/gen3.urdf", ["opti_1", "opti_2"],
                       ["robot.rotor_inertia=false", RESAMPLED] + [f"robot.joints.joint_{j}.friction=\"coulomb\"" for j in (2, 5, 6)]),
    "double": ("dfki_double_pendulum/acrobot.urdf", ["run_1", "run_2", "run_3", "run_4", "run_5"], [RESAMPLED]),
    "simple": ("dfki_simple_pendulum/pendulum.urdf", ["energy_shaping", "pd_sysid", "gravity_compensation"], [RESAMPLED]),
    "bam": ("bam_servo/pendulum.urdf", ["xl330_1", "xl330_2", "xl330_3", "xl330_4"], ['log.control=["load"]']),
}
WHOLE = "whole"


def simulated(programs, folder):
    """The six-axis arm with joint 6 held by friction, two logs of it."""
    data = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "six_axis")
    reference = np.genfromtxt(os.path.join(data, "six_axis_reference.csv"), delimiter=",", names=True)
    out = []
    for seed, sign in ((1, 1.0), (2, -1.0)):
        name = os.path.join(folder, f"held_{seed}")
        values = np.column_stack([reference[n] for n in reference.dtype.names])
        for c, column in enumerate(reference.dtype.names):
            if column.endswith("6"):
                values[:, c] *= 0.1
            elif sign < 0:
                values[:, c] *= 0.9
        np.savetxt(name + "_reference.csv", values, delimiter=",", header=",".join(reference.dtype.names), comments="")
        run([os.path.join(programs, "rivid_simulate"), os.path.join(data, "simulate.toml"), "--set", f'reference.file="{os.path.abspath(name)}_reference.csv"',
             "--set", f"simulation.seed={seed}", "-o", name, "--force", "-q"])
        os.replace(os.path.join(name, "log.csv"), name + ".csv")
        out.append(name + ".csv")
    return os.path.join(data, "six_axis.urdf"), out


def run(command):
    return subprocess.run(command, check=False, capture_output=True, text=True)


def pieces(file, folder, parts):
    """Files of so many pieces of a log."""
    with open(file, encoding="utf-8") as text:
        head, *rows = text.readlines()
    out = []
    for k in range(parts):
        name = os.path.join(folder, f"{os.path.splitext(os.path.basename(file))[0]}_{k + 1}of{parts}.csv")
        with open(name, "w", encoding="utf-8") as text:
            text.writelines([head] + rows[k * len(rows) // parts:(k + 1) * len(rows) // parts])
        out.append(name)
    return out


def cases(logs, folder, programs):
    robots = {name: (os.path.join(logs, urdf), [os.path.join(logs, os.path.dirname(urdf), log + ".csv") for log in names], settings)
              for name, (urdf, names, settings) in ROBOTS.items()}
    robots["held"] = (*simulated(programs, folder), [])
    for name, (urdf, files, settings) in robots.items():
        for k, file in enumerate(files):
            if len(files) > 1:
                yield name, WHOLE, urdf, file, files[(k + 1) % len(files)], files[(k + 2) % len(files)], settings
            for parts in (2, 3):
                cut = pieces(file, folder, parts)
                for j, piece in enumerate(cut):
                    yield name, f"{j + 1}/{parts}", urdf, piece, cut[(j + 1) % parts], cut[(j + 2) % parts], settings


class Case:
    def __init__(self, programs, folder, case):
        self.robot, self.part, self.urdf, self.train, self.test, self.third, self.settings = case
        self.program, self.folder = os.path.join(programs, "rivid_identify"), folder
        self.name = f"{self.robot} {self.part} {os.path.splitext(os.path.basename(self.train))[0]}"
        self.file = os.path.join(folder, "case.toml")

    def draft(self, logs):
        run([self.program, "init", self.urdf, *logs, "-o", self.file, "--force"])

    def identify(self, *options):
        """Exit code and result, or nothing."""
        folder = os.path.join(self.folder, "result")
        settings = [a for s in (*self.settings,) for a in ("--set", s)]
        if os.path.exists(os.path.join(folder, "result.json")):
            os.remove(os.path.join(folder, "result.json"))
        done = run([self.program, self.file, "-q", "-o", folder, "--force", "--threads", "1", *settings, *options])
        try:
            with open(os.path.join(folder, "result.json"), encoding="utf-8") as text:
                return done, json.load(text)
        except OSError:
            return done, None

    def error(self, log, f):
        """Mean over JUDGED rows of a log of the error of all joints, and of each joint, by the result that is there."""
        total, joints = [], []
        for spacing in JUDGED:
            done = run([self.program, "validate", os.path.join(self.folder, "result"), log, "--json", "--set", f"signal.decimation={max(round(spacing * f), 1)}",
                        "--set", "signal.torque_held=false"])
            try:
                model = json.loads(done.stdout)["models"][0]
            except (ValueError, KeyError, IndexError):
                continue
            total.append(model["relative_error"])
            joints.append([np.nan if e is None else e for e in model["joints"]])
        return (float(np.mean(total)), np.mean(joints, axis=0)) if total else (None, None)

    def sampling(self, log):
        with open(log, encoding="utf-8") as text:
            names = text.readline().strip().split(",")
            column = next(i for i, n in enumerate(names) if n in ("t", "time"))
            t = [float(line.split(",")[column]) for line in text]
        return 1.0 / np.median(np.diff(t))


def judged(case, sweep):
    case.draft([case.train, case.test])
    done, result = case.identify()
    out = {"case": case.name, "exit": done.returncode}
    if result is None:
        out["says"] = done.stderr.strip().splitlines()[-1][:200] if done.stderr.strip() else ""
        return out
    fit, validation = result["fit"], (result["validation"] or [None])[0]
    choice = result.get("row_choice") or {}
    out |= {"status": result["status"], "rows": fit["rows"], "parameters": len(result["parameters"]), "n_d": choice.get("decimation"),
            "fit": fit["relative_error"], "codes": sorted({w["code"] for w in result["warnings"]}), "answer": "physical" if (result.get("physical") or {}).get("better") else "estimate",
            "identified": sum(p["verdict"] == "identified" for p in result["parameters"])}
    if validation:
        if out["answer"] == "physical":
            out["plain"] = validation["relative_error"]
            fit, validation = result["physical"]["fit"], validation["physical"] | {"forecast": validation["forecast"]}
        out |= {"found": validation["relative_error"], "forecast": (validation.get("forecast") or {}).get("relative_error"),
                "ratio": max((v["sigma_rho"] or 0.0) / f["sigma_rho"] for v, f in zip(validation["joints"], fit["joints"]) if f["sigma_rho"]),
                "worst": max(v["relative_error"] or 0.0 for v in validation["joints"])}
    if not sweep:
        return out
    f = case.sampling(case.test)
    out["E"], joints = case.error(case.test, f)
    if out["E"] is None:
        return out
    _, ols = case.identify("--set", 'method.name="ols"', "--set", f"signal.decimation={choice.get('decimation')}")
    if ols:
        out["E_ols"], of_ols = case.error(case.test, f)
        out["over_ols"] = float(np.nanmax(joints / of_ols))
    windows = []
    for spacing in SPACINGS:
        case.draft([case.train])
        _, one = case.identify("--set", f"signal.decimation={max(round(spacing * f), 1)}")
        e = case.error(case.test, f)[0] if one else None
        if e is not None:
            windows.append((e, spacing, case.error(case.third, f)[0] if case.third != case.train else None))
    if windows:
        out["best"], out["at"], _ = min(windows)
        third = [(on_third, e) for e, _, on_third in windows if on_third is not None]
        if third:
            out["by_third"] = min(third)[1]
        out["windows"] = windows
    return out


def near(error, case):
    """Whether an error on the test log is that of the best window."""
    return error <= max(1.05 * case["best"], case["best"] + 0.0015)


def main():
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("programs")
    ask.add_argument("logs")
    ask.add_argument("--sweep", action="store_true")
    ask.add_argument("--only", default="")
    ask.add_argument("--folder", default="strange_logs")
    ask.add_argument("--json")
    args = ask.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    found = []
    for case in cases(args.logs, args.folder, args.programs):
        one = Case(args.programs, args.folder, case)
        if args.only in one.name:
            found.append(judged(one, args.sweep))
            print(" ".join(f"{k}={v:.4g}" if isinstance(v, float) else f"{k}={v}" for k, v in found[-1].items() if k != "windows"), flush=True)
    if args.json:
        with open(args.json, "w", encoding="utf-8") as text:
            json.dump(found, text)
    wrong = [c["case"] for c in found if c["exit"] == 0 and "found" in c and (c["worst"] > 1.0 or c["ratio"] > 10.0)]
    print(f"{len(found)} cases, {sum(c['exit'] == 0 for c in found)} with exit 0; exit 0 with a validation joint above 100 % or ten times its fit: {wrong}")
    foretold = [c["found"] / c["forecast"] for c in found if c.get("forecast") and c.get("found")]
    if foretold:
        good = sum(1 / 1.5 <= f <= 1.5 for f in foretold)
        print(f"forecast within a factor 1.5: {good} of {len(foretold)}")
    changed = [c for c in found if "plain" in c]
    if changed:
        worse = [c["case"] for c in changed if c["found"] > 1.02 * c["plain"]]
        print(f"physical answers predict worse than the estimate by 2 %: {len(worse)} of {len(changed)}: {worse}")
    swept = [c for c in found if "best" in c]
    for name, some in (("all", swept), ("exit 0", [c for c in swept if c["exit"] == 0])):
        if some:
            over = [c["case"] for c in some if c.get("over_ols", 0.0) > 2.0]
            print(f"{name}: E within 0.15 points or 5 % of the best window: {sum(near(c['E'], c) for c in some)} of {len(some)}; E over it "
                  f"{np.exp(np.mean([np.log(c['E'] / c['best']) for c in some])):.3f} on average; a joint worse than OLS by 2: {over}")
        third = [c for c in some if "by_third" in c]
        if third:
            print(f"{name} with a third log: {sum(near(c['E'], c) for c in third)} of {len(third)}; chosen by the third log "
                  f"{sum(near(c['by_third'], c) for c in third)}, E over the best {np.exp(np.mean([np.log(c['by_third'] / c['best']) for c in third])):.3f}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
