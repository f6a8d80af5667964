"""Methods of identification on the same logs: error on held-out logs, coverage of the intervals, rollouts, time.

    python3 -m venv venv && venv/bin/pip install 'mujoco[sysid]' pin figaroh matplotlib
    PYTHONPATH=build/test/python venv/bin/python benchmarks/methods/methods.py --out FOLDER [--page docs/methods.md]

or in an environment with an installed rivid. FOLDER gets methods.json, methods.md and the pictures; --page puts tables and
pictures into that page too. Robots are drawn from seeds and simulated by MuJoCo; real logs are taken where --data has them.
`--robots 2` is a short run. Exit codes: 1 where fewer than 85 % of the intervals of weighted least squares hold the truth, or its
torque error is above 1 %; 77: a package is missing.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import warnings
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # times are of one processor

try:
    import numpy as np
    import rivid
    from fits import METHODS, NotApplicable
    from judge import HORIZONS, HeldOut, interval, ranks
    from robots import Arm, Log
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

REPOSITORY = Path(__file__).resolve().parents[2]
TRAIN, HELD_OUT = 1, 0  # numbers of the logs
REFERENCE = "rivid WLS"
TRUTH, GUESS = "truth", "description"


def judged(log: Log, held_out: HeldOut, name: str) -> dict:
    """What a method makes of a log."""
    begin = time.process_time()
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            chi, C = METHODS[name](log)
    except NotApplicable as reason:
        return {"not_applicable": str(reason)}
    except Exception as error:  # of whatever package: it is a result
        return {"failed": f"{type(error).__name__}: {error}"[:200]}
    out = {"seconds": time.process_time() - begin, **scored(held_out, chi)}
    if held_out.truth is not None:
        far = np.abs(chi - held_out.truth) / np.sqrt(np.diag(C))
        out |= {"held": int(np.sum(far <= 1.96)), "parameters": len(chi), "rms_of_sigma": float(np.sqrt(np.mean(far**2)))}
    notes = [str(w.message) for w in told if issubclass(w.category, rivid.RividWarning)]
    return out | ({"notes": notes} if notes else {})


def scored(held_out: HeldOut, chi: np.ndarray) -> dict:
    return {"torque_error": held_out.torque_error(chi), "rollout_errors": held_out.rollout_errors(chi)}


def of_description(log: Log) -> np.ndarray:
    return log.robot.base_parameters().from_standard(list(log.robot.standard_parameters.values()))


def simulated(seed: int) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        arm = Arm(seed, Path(folder))
        log, other = arm.log(TRAIN), arm.log(HELD_OUT)
        held_out = HeldOut(other, arm.truth(other), arm.motion)
        found = {name: judged(log, held_out, name) for name in METHODS}
        found[TRUTH] = scored(held_out, arm.truth(log))
        found[GUESS] = scored(held_out, of_description(log))
        said(log, found)
        return {"seed": seed, "joints": arm.n, "encoder_noise": arm.encoder, "methods": found}


def halves(log: rivid.Log, robot: rivid.Robot) -> tuple[dict, dict]:
    tau, half = robot.effort(log), len(log) // 2
    return tuple({"q": log.q[part], "tau": tau[part], "q_r": None if log.q_r is None else log.q_r[part]} for part in (slice(half), slice(half, None)))


def real(data: Path) -> list[tuple[str, Log, Log]]:
    """Logs of real robots: one to fit, another to judge."""
    out = []
    pd = rivid.Pd(k_p=160.18, k_v=243.45 * 35.15065188, v_tau_max=10 * 35.15065188, rate_hz=1000, velocity_filter="central")
    ur10e = {"position": [f"q{j}" for j in range(1, 7)], "control": [f"i{j}" for j in range(1, 7)], "resample_hz": 100}
    gains = [11.78, 11.98, 9.82, 10.69, 10.53, 10.63]
    cases = [
        ("EMPS", "emps/emps.urdf", ["emps/emps_ident.csv"], {"rotor_inertia": False}, {}, {}, pd),
        ("double pendulum", "dfki_double_pendulum/acrobot.urdf", [f"dfki_double_pendulum/run_{k}.csv" for k in (3, 2)], {}, {}, {}, None),
        ("UR10e", "ur10e/ur10e.urdf", [f"ur10e/ident_{k}s_12harm.csv" for k in (30, 40)], {}, ur10e, {"drive_gain": gains}, None),
        ("Panda", "panda/panda.urdf", ["panda/panda_1khz.csv"], {"rotor_inertia": False}, {}, {}, None),
    ]
    for name, urdf, files, keys, columns, drives, control in cases:
        if not (data / urdf).exists():
            print(f"skipped: {name}, no {data / urdf}")
            continue
        keys = {"friction": "symmetric", **keys}
        robot = rivid.Robot.from_urdf(data / urdf, **keys, **drives)
        read = [rivid.read_log(data / file, robot, irregular="resample", **columns) for file in files]
        parts = halves(read[0], robot) if len(read) == 1 else [{"q": one.q, "tau": robot.effort(one)} for one in read]
        make = [Log(data / urdf, read[0].rate_hz, **part, keys=keys, name=name, control=control) for part in parts]
        out.append((name, *make))
    return out


def said(log: Log, found: dict) -> None:
    print(f"{log.name}: {log.q.shape[1]} joints, {len(log.names)} base parameters", flush=True)
    for name, one in found.items():
        if "torque_error" not in one:
            print(f"  {name:20} {one}", flush=True)
            continue
        held = f"{one['held']:4} of {one['parameters']}" if "held" in one else ""
        rollouts = " ".join(f"{1e3 * e:9.3f}" for e in one["rollout_errors"])
        print(f"  {name:20} {100 * one['torque_error']:8.4f} % {rollouts} mrad {one.get('seconds', 0.0):7.2f} s {held} {one.get('notes', '')}", flush=True)


def geometric(values: np.ndarray, axis: int = 0) -> np.ndarray:
    return np.exp(np.mean(np.log(values), axis=axis))


def summary(robots: list[dict]) -> dict:
    """Of each method over the robots: means, with intervals of a bootstrap over the robots."""
    ran = {name: [r for r in robots if "torque_error" in r["methods"][name]] for name in [*METHODS, TRUTH, GUESS]}
    everywhere = [name for name in METHODS if all("not_applicable" not in r["methods"][name] for r in robots)]
    places = ranks({name: [r["methods"][name].get("torque_error", np.inf) for r in robots] for name in everywhere})
    out = {}
    for name, where in ran.items():
        if not where:
            continue
        mine = [r["methods"][name] for r in where]
        one = {"robots": len(where), "rollout_errors": geometric(np.array([m["rollout_errors"] for m in mine])).tolist()}
        if name != TRUTH:
            errors = np.array([m["torque_error"] for m in mine])
            ratio = errors / [r["methods"][REFERENCE]["torque_error"] for r in where]
            one |= {"torque_error": float(geometric(errors)), "over_reference": interval(ratio, geometric)}
        if name in METHODS:
            counts = np.array([[m["held"], m["parameters"]] for m in mine])
            one["coverage"] = interval(counts, lambda c, axis: c[:, 0].sum() / c[:, 1].sum())
            one["seconds"] = float(geometric(np.array([m["seconds"] for m in mine])))
        if name in places:
            one["rank"] = interval(places[name])
        out[name] = one
    return out


def tables(result: dict) -> str:
    lines = [
        f"Simulated, {len(result['robots'])} robots:",
        "",
        "| method | torque error [%] | over that of WLS | mean rank | coverage [%] | rollout error, 0.1 / 0.3 / 1 s [mrad] | time [s] |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, one in result["summary"].items():
        torque = f"{100 * one['torque_error']:.3f}" if "torque_error" in one else "0"
        ratio = spread(one["over_reference"], "{:.2f}") if "over_reference" in one and name != REFERENCE else ""
        place = spread(one["rank"], "{:.1f}") if "rank" in one else ""
        held = spread([100 * c for c in one["coverage"]], "{:.1f}") if "coverage" in one else ""
        rollouts = " / ".join(f"{1e3 * e:.2f}" for e in one["rollout_errors"])
        some = f" ({one['robots']} robots)" if one["robots"] < len(result["robots"]) else ""
        seconds = f"{one['seconds']:.2f}" if "seconds" in one else ""
        lines.append(f"| {name}{some} | {torque} | {ratio} | {place} | {held} | {rollouts} | {seconds} |")
    if result["real"]:
        lines += ["", "Real, torque error [%] and rollout error after 0.3 s [mrad, mm]:", ""]
        lines += ["| method | " + " | ".join(r["name"] for r in result["real"]) + " |", "|---" * (len(result["real"]) + 1) + "|"]
        for name in [*METHODS, GUESS]:
            cells = [cell(r["methods"][name]) for r in result["real"]]
            lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def spread(values: list[float], form: str) -> str:
    middle, low, high = (form.format(x) for x in values)
    return f"{middle} ({low}–{high})"


def cell(one: dict) -> str:
    if "torque_error" not in one:
        return "failed" if "failed" in one else "–"
    return f"{100 * one['torque_error']:.2f}, {1e3 * one['rollout_errors'][1]:.1f}"


def pictures(result: dict, folder: Path) -> None:
    from matplotlib.figure import Figure

    found = {name: one for name, one in result["summary"].items() if name in METHODS}
    colours = ["C0" if name.startswith("rivid") else "C1" for name in found]
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    at = np.arange(len(found))[::-1]
    for axis, key, label, factor in zip(
        axes, ("over_reference", "coverage", "rank"), ("torque error over that of WLS", "coverage of 95 % intervals [%]", "mean rank"), (1, 100, 1)
    ):
        for y, one, colour in zip(at, found.values(), colours):
            if key in one:
                middle, low, high = (factor * x for x in one[key])
                axis.plot([low, high], [y, y], color=colour)
                axis.plot(middle, y, "o", color=colour)
        axis.set_xlabel(label)
        axis.grid(alpha=0.3)
    axes[0].set_xscale("log")
    axes[1].axvline(95, color="0.5", linestyle="--")
    axes[0].set_yticks(at, found)
    figure.savefig(folder / "methods.png", dpi=80)

    figure = Figure(figsize=(6.0, 3.4), layout="constrained")
    axis = figure.subplots()
    shown = [name for name in (REFERENCE, "rivid IV", "FIGAROH", "Pinocchio + NumPy", TRUTH, GUESS) if name in result["summary"]]
    for name in shown:
        axis.loglog(HORIZONS, result["summary"][name]["rollout_errors"], "--" if name in (TRUTH, GUESS) else "o-", label=name)
    axis.set_xticks(HORIZONS, [f"{h:g}" for h in HORIZONS])
    axis.set_xlabel("time from the measured state [s]")
    axis.set_ylabel("rollout error [rad]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")
    figure.savefig(folder / "methods_rollouts.png", dpi=80)


def versions() -> dict[str, str]:
    out = {"rivid": rivid.__version__}
    for package in ("mujoco", "pin", "figaroh", "numpy"):
        try:
            out[package] = version(package)
        except PackageNotFoundError:
            out[package] = "unknown"
    return out


def main() -> int:
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("--out", type=Path, required=True, help="folder of the results")
    ask.add_argument("--robots", type=int, default=12, help="simulated robots, of the seeds 1, 2, …")
    ask.add_argument("--data", type=Path, default=REPOSITORY.parent / "shared/data", help="folder of the real logs")
    ask.add_argument("--methods", nargs="+", choices=list(METHODS), default=list(METHODS), help="only these, and " + REFERENCE)
    ask.add_argument("--resume", action="store_true", help="continue what an ended run left in FOLDER")
    ask.add_argument("--page", type=Path, help="page whose tables and pictures are replaced")
    given = ask.parse_args()
    for name in set(METHODS) - {REFERENCE, *given.methods}:
        del METHODS[name]
    given.out.mkdir(parents=True, exist_ok=True)
    file = given.out / "methods.json"
    result = json.loads(file.read_text(encoding="utf-8")) if given.resume else {"versions": versions(), "robots": [], "real": []}

    def keep() -> None:
        file.write_text(json.dumps(result) + "\n", encoding="utf-8")

    for seed in range(len(result["robots"]) + 1, given.robots + 1):
        result["robots"].append(simulated(seed))
        keep()
    for name, log, other in real(given.data)[len(result["real"]) :]:
        held_out = HeldOut(other)
        found = {method: judged(log, held_out, method) for method in METHODS} | {GUESS: scored(held_out, of_description(log))}
        said(log, found)
        result["real"].append({"name": name, "methods": found})
        keep()
    result["summary"] = summary(result["robots"])
    keep()
    text = tables(result)
    (given.out / "methods.md").write_text(text, encoding="utf-8")
    pictures(result, given.out)
    if given.page:
        before, _, rest = given.page.read_text(encoding="utf-8").partition(BEGIN)
        given.page.write_text(f"{before}{BEGIN}\n\n{text}\n{END}{rest.partition(END)[2]}", encoding="utf-8")
        pictures(result, given.page.parent / "figures")
    print(text)
    reference = result["summary"][REFERENCE]
    return int(reference["coverage"][0] < 0.85 or reference["torque_error"] > 0.01)


BEGIN, END = "<!-- by benchmarks/methods/methods.py -->", "<!-- end -->"

if __name__ == "__main__":
    sys.exit(main())
