"""Draws the figures of the documentation from data in the repository.

    python docs/site/figures.py --tools build/test/apps --out docs/figures [--quick] [--only NAME …]

Each figure is a function: it runs the built tools, reads their JSON and CSV, and draws. Torques are those of the C headers that
rivid_identify writes, compiled by `cc`. --quick makes fewer simulations, for the test. report.png is a screenshot; it is left out
where no Chromium is, guide.png, rollouts.png and samples.png without the logs of --data.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SCARA = ROOT / "data/scara"
ARM = ROOT / "data/six_axis"
MEASURED, MODEL, RESIDUAL, OTHER = "#33415c", "#e4572e", "#8d99ae", "#1f8a70"
FIGURES: dict[str, Callable[[Workshop], None]] = {}
Array = np.ndarray


class Model:
    """Torques of an identified robot, by the C header of rivid_identify export."""

    def __init__(self, header: Path, joints: int) -> None:
        self._name, self._joints = header.stem, joints
        source, library = header.with_suffix(".c"), header.with_suffix(".so")
        source.write_text(f'#include <math.h>\n#define static\n#define inline\n#include "{header.name}"\n', encoding="utf-8")
        compiler = os.environ.get("CC", "cc")
        subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
        self._library = ctypes.CDLL(str(library))

    def _torques(self, function: str, *series: Array, smoothing: bool = False) -> Array:
        call = getattr(self._library, f"{self._name}_{function}")
        out = np.zeros_like(series[0])
        for k in range(len(out)):
            rows = [np.ascontiguousarray(x[k]) for x in (*series, out)]
            arguments = [x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for x in rows]
            if smoothing:
                arguments.insert(-1, None)
            call(*arguments)
            out[k] = rows[-1]
        return out

    def torque(self, q: Array, qd: Array, qdd: Array) -> Array:
        return self._torques("inverse_dynamics", q, qd, qdd)

    def rigid_body(self, q: Array, qd: Array, qdd: Array) -> Array:
        return self._torques("rigid_body", q, qd, qdd)

    def gravity(self, q: Array) -> Array:
        return self._torques("gravity", q)

    def friction(self, qd: Array) -> Array:
        return self._torques("friction", qd, smoothing=True)


class Log:
    """A CSV log; motion and torques averaged over a Hann window, as rows are.

    With drive gains the torques are currents `i1` … times these, resampled at 100 Hz; else control signals `v1` … of a sampled
    controller.
    """

    def __init__(self, path: Path, window: int, gains: list[float] | None = None) -> None:
        table = np.genfromtxt(path, delimiter=",", names=True)
        joints = sum(re.fullmatch(r"q\d+", name) is not None for name in table.dtype.names)
        names = ("q", "v", "qref") if gains is None else ("q", "i")
        self._columns = {name: np.column_stack([table[f"{name}{j + 1}"] for j in range(joints)]) for name in names}
        weights = np.hanning(window + 2)[1:-1]
        self._weights = weights / weights.sum()
        self.t_all = table["t"]
        if gains is not None:
            self.t_all = np.arange(table["t"][0], table["t"][-1], 0.01)
            for name, series in self._columns.items():
                self._columns[name] = np.column_stack([np.interp(self.t_all, table["t"], column) for column in series.T])
            tau = self._columns["i"] * gains
        else:
            # The control signal acts from its sample to the next, so that it is centred half a sample later.
            held = self._columns["v"]
            tau = np.vstack([held[:1], (held[:-1] + held[1:]) / 2])
        border = window // 2
        self.t = self.t_all[border : len(self.t_all) - border]
        self.tau = self.averaged(tau)
        self.q = self.averaged(self._columns["q"])
        self.qd = np.gradient(self.q, self.t, axis=0)
        self.qdd = np.gradient(self.qd, self.t, axis=0)

    def __getitem__(self, name: str) -> Array:
        return self._columns[name]

    def averaged(self, series: Array) -> Array:
        return np.column_stack([np.convolve(column, self._weights, mode="valid") for column in series.T])


class Fit:
    """A result.json and the model of the same run."""

    def __init__(self, document: dict[str, Any], model: Model) -> None:
        self.document, self.model = document, model
        self.parameters: dict[str, dict[str, Any]] = {p["name"]: p for p in document["parameters"]}
        self.names = list(self.parameters)
        self.chi = np.array([p["value"] for p in document["parameters"]])
        self.covariance = np.array(document["covariance"]["C_chi"])


class Workshop:
    """Folder to work in, the tools, and the logs and results that several figures share."""

    def __init__(self, tools: Path, work: Path, out: Path, quick: bool, data: Path | None = None) -> None:
        self.tools, self.work, self.out, self.quick = tools.resolve(), work.resolve(), out.resolve(), quick
        self.data = data.resolve() if data else None
        self._results: dict[tuple[str, ...], dict[str, Any]] = {}
        self._folders: dict[int, Path] = {}

    def run(self, tool: str, *arguments: object, statuses: tuple[int, ...] = (0,)) -> str:
        done = subprocess.run([self.tools / tool, *map(str, arguments)], cwd=self.work, capture_output=True, text=True)
        if done.returncode not in statuses:
            raise SystemExit(f"figures: {tool} {' '.join(map(str, arguments))} ended with {done.returncode}\n{done.stderr}")
        return done.stdout

    def result(self, file: Path, *arguments: object, **settings: object) -> dict[str, Any]:
        """result.json of an experiment file with other settings: signal__decimation=5 is --set signal.decimation=5."""
        given = [str(a) for a in arguments]
        for key, value in settings.items():
            given += ["--set", f"{key.replace('__', '.')}={json.dumps(value)}"]
        key = (str(file), *given)
        if key not in self._results:
            folder = self.work / f"result_{len(self._results)}"
            self.run("rivid_identify", file, "--output", folder, "--quiet", *given, statuses=(0, 1))
            self._results[key] = json.loads((folder / "result.json").read_text(encoding="utf-8"))
            self._folders[id(self._results[key])] = folder
        return self._results[key]

    def fit(self, name: str, file: Path, *arguments: object) -> Fit:
        header = self.work / f"{name}.h"
        document = self.result(file, *arguments)
        self.run("rivid_identify", "export", self._folders[id(document)], "--to", "header", "--output", header, "--quiet")
        return Fit(document, Model(header, len(document["robot"]["joints"])))

    def scara(self) -> Fit:
        return self.fit("scara", SCARA / "scara.toml")

    def arm(self) -> Fit:
        return self.fit("arm", ARM / "six_axis.toml", "--log", self.arm_log())

    def arm_log(self) -> Path:
        """The log of data/six_axis/simulate.toml."""
        if not (self.work / "arm_log/log.csv").exists():
            self.run("rivid_simulate", ARM / "simulate.toml", "--output", "arm_log", "--quiet")
        return self.work / "arm_log/log.csv"

    def save(self, name: str) -> None:
        path = self.out / f"{name}.png"
        plt.savefig(path, dpi=110)
        plt.close("all")
        shrink(path)


def shrink(path: Path) -> None:
    """A picture of few colours is a third as large."""
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(128, dither=Image.Dither.NONE)
    small.save(path, optimize=True)


def figure(function: Callable[[Workshop], None]) -> Callable[[Workshop], None]:
    FIGURES[function.__name__] = function
    return function


def truth() -> dict[str, float]:
    return {name: p["value"] for name, p in json.loads((SCARA / "truth.json").read_text())["parameters"].items()}


def ticks(axis: plt.Axes, at: tuple[float, ...]) -> None:
    axis.set_xticks(at, [f"{x:g}" for x in at])
    axis.minorticks_off()


def parameter(document: dict[str, Any], name: str) -> dict[str, Any]:
    return next(p for p in document["parameters"] if p["name"] == name)


def friction_band(fit: Fit, joint: int, qd: Array) -> tuple[Array, Array]:
    """Fv q̇ + Fc sign q̇ + off of the estimate, as far as it has them, and half its 95 % interval."""
    kinds = [(kind, column) for kind, column in (("Fv", qd), ("Fc", np.sign(qd)), ("off", np.ones_like(qd))) if f"{kind}{joint + 1}" in fit.parameters]
    at = [fit.names.index(f"{kind}{joint + 1}") for kind, _ in kinds]
    columns = np.column_stack([column for _, column in kinds])
    variance = np.einsum("ki,ij,kj->k", columns, fit.covariance[np.ix_(at, at)], columns)
    return columns @ fit.chi[at], fit.document["covariance"]["quantile_975"] * np.sqrt(variance)


def draw_friction(axis: plt.Axes, fit: Fit, log: Log, joint: int) -> None:
    measured = log.tau[:, joint] - fit.model.rigid_body(log.q, log.qd, log.qdd)[:, joint]
    moving = np.abs(log.qd[:, joint]) > 0.1
    at = np.flatnonzero(moving)[::8]
    axis.plot(log.qd[at, joint], measured[at], ".", ms=4, color=MEASURED, alpha=0.5, label="measured − rigid body")
    for side in (-1, 1):
        grid = side * np.linspace(1e-6, np.abs(log.qd[:, joint]).max(), 50)
        middle, half = friction_band(fit, joint, grid)
        axis.fill_between(grid, middle - half, middle + half, color=MODEL, alpha=0.3, lw=0, label="95 % confidence band" if side > 0 else None)
        axis.plot(grid, middle, color=MODEL, label="model" if side > 0 else None)
    axis.set(xlabel="joint velocity [rad/s]", ylabel="friction torque [N·m]", title=f"Friction of joint_{joint + 1}")
    axis.legend(loc="upper left")


def draw_fit(axis: plt.Axes, fit: Fit, log: Log, joint: int) -> None:
    measured, predicted = log.tau[:, joint], fit.model.torque(log.q, log.qd, log.qdd)[:, joint]
    axis.plot(log.t, measured, color=MEASURED, lw=2.2, alpha=0.6, label="measured")
    axis.plot(log.t, predicted, "--", color=MODEL, label="predicted")
    axis.plot(log.t, measured - predicted, color=RESIDUAL, lw=0.8, label="residual")
    axis.set(xlabel="t [s]", ylabel="torque [N·m]", title=f"Torque of joint_{joint + 1}, averaged over 0.1 s")
    axis.legend(loc="upper right", ncols=3)


@figure
def fit_and_friction(shop: Workshop) -> None:
    """Measured and predicted torque of the SCARA, and the friction curve of its second joint."""
    fit, log = shop.scara(), Log(SCARA / "scara_s2.csv", 39)
    _, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), width_ratios=(3, 2), layout="constrained")
    draw_fit(left, fit, log, 1)
    draw_friction(right, fit, log, 1)
    shop.save("fit_and_friction")


@figure
def validation(shop: Workshop) -> None:
    """The torques of the log that was not used in the fit."""
    fit, log = shop.scara(), Log(SCARA / "scara_validation.csv", 39)
    _, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
    for joint, axis in enumerate(axes):
        draw_fit(axis, fit, log, joint)
    axes[0].set_xlabel("")
    shop.save("validation")


@figure
def intervals(shop: Workshop) -> None:
    """Estimates with their confidence intervals beside the true values."""
    parameters, true = shop.result(SCARA / "scara.toml")["parameters"], truth()
    _, axis = plt.subplots(figsize=(7, 3), layout="constrained")
    for k, p in enumerate(parameters):
        scale = 100 / true[p["name"]]
        low, high = ((x - true[p["name"]]) * scale for x in p["interval_95"])
        axis.plot([low, high], [k, k], color=MODEL, lw=5, solid_capstyle="butt", alpha=0.5)
        axis.plot((p["value"] - true[p["name"]]) * scale, k, "o", color=MODEL, ms=5)
    axis.axvline(0, color=MEASURED, lw=1)
    axis.set_xscale("symlog", linthresh=1)
    ticks = (-30, -10, -3, -1, 0, 1, 3, 10)
    axis.set_xticks(ticks, [f"{x}" for x in ticks])
    axis.minorticks_off()
    axis.set(yticks=range(len(parameters)), yticklabels=[p["name"] for p in parameters], xlabel="distance from the true value [% of it]",
             title="Estimate and 95 % confidence interval")
    axis.invert_yaxis()
    shop.save("intervals")


@figure
def correlation(shop: Workshop) -> None:
    """Correlation of the estimates of the six-joint arm."""
    fit = shop.arm()
    sigma = np.sqrt(np.diag(fit.covariance))
    _, axis = plt.subplots(figsize=(7.5, 6.6), layout="constrained")
    image = axis.imshow(fit.covariance / np.outer(sigma, sigma), cmap="RdBu_r", vmin=-1, vmax=1)
    axis.grid(visible=False)
    axis.set_xticks(range(len(fit.names)), fit.names, rotation=90, fontsize=5.5)
    axis.set_yticks(range(len(fit.names)), fit.names, fontsize=5.5)
    axis.set_title("Correlation of the estimates, six-joint arm")
    plt.colorbar(image, shrink=0.8)
    shop.save("correlation")


@figure
def residual(shop: Workshop) -> None:
    """Residual of one joint: against time, its distribution, its autocorrelation."""
    fit, log = shop.scara(), Log(SCARA / "scara_s2.csv", 39)
    at = np.flatnonzero(np.abs(log.qd[:, 1]) > 0.1)[::20]
    rho = 1000 * (log.tau - fit.model.torque(log.q, log.qd, log.qdd))[at, 1]
    _, axes = plt.subplots(1, 3, figsize=(10, 2.8), layout="constrained")
    axes[0].plot(log.t[at], rho, ".", ms=4, color=MEASURED)
    axes[0].set(xlabel="t [s]", ylabel="residual [mN·m]", title="Residual of joint_2")
    rho = rho - rho.mean()
    axes[1].hist(rho, bins=20, density=True, color=RESIDUAL)
    grid = np.linspace(rho.min(), rho.max(), 100)
    axes[1].plot(grid, np.exp(-0.5 * (grid / rho.std()) ** 2) / (rho.std() * np.sqrt(2 * np.pi)), color=MODEL)
    axes[1].set(xlabel="residual [mN·m]", yticks=[], title="Distribution and normal one")
    lags = np.arange(1, 21)
    axes[2].bar(lags, [(rho[k:] * rho[:-k]).sum() / (rho @ rho) for k in lags], color=MEASURED, width=0.5)
    for bound in (-1.96, 1.96):
        axes[2].axhline(bound / np.sqrt(len(rho)), color=MODEL, lw=1, ls="--")
    axes[2].set(xlabel="lag [rows]", title="Autocorrelation")
    shop.save("residual")


@figure
def rows(shop: Workshop) -> None:
    """What the window of the rows does to least squares: bias at one end, loss of rows at the other."""
    true = truth()
    windows = (4, 20, 50) if shop.quick else (4, 6, 8, 12, 20, 30, 50)
    _, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for axis, name in zip(axes, ("ZZ1R", "MX2")):
        for kind, label, color in (("exact", "exact rows, no filter", MODEL), ("paper", "paper's rows, 20 Hz", RESIDUAL)):
            found = []
            for n_d in windows:
                document = shop.result(SCARA / "scara.toml", signal__decimation=n_d, signal__cutoff_hz="off" if kind == "exact" else 20,
                                       signal__rows=kind, signal__torque_held=kind == "exact")
                found.append(parameter(document, name))
            value, sigma = (np.array([p[key] for p in found]) / true[name] for key in ("value", "sigma"))
            axis.errorbar(windows, 100 * (value - 1), 200 * sigma, fmt="o-", ms=4, capsize=2, color=color, label=label)
        axis.axhline(0, color=MEASURED, lw=1)
        axis.set(xscale="log", xlabel="decimation n_d", ylabel="error [%]", title=f"{name}, estimate ± 2 σ")
        ticks(axis, windows)
    axes[0].legend()
    shop.save("rows")


@figure
def cutoff(shop: Workshop) -> None:
    """Least squares and instrumental variables by the cut-off of the position filter."""
    true = truth()
    cuts = (2, 20, 80) if shop.quick else (1, 2, 5, 10, 20, 40, 80)
    _, axis = plt.subplots(figsize=(7, 3.2), layout="constrained")
    for method, color in (("ols", RESIDUAL), ("iv", MODEL)):
        for name, style in (("ZZ1R", "-o"), ("MX2", "--s")):
            ratio = []
            for hz in cuts:
                document = shop.result(SCARA / "scara_iv.toml", method__name=method, signal__rows="paper", signal__cutoff_hz=hz,
                                       signal__decimation=1, signal__torque_held=False)
                ratio.append(parameter(document, name)["value"] / true[name])
            axis.plot(cuts, ratio, style, ms=4, color=color, label=f"{method.upper()}, {name}")
    axis.axhline(1, color=MEASURED, lw=1)
    axis.set(xscale="log", xlabel="cut-off frequency [Hz]", ylabel="estimate / true value", title="The paper's rows, not decimated")
    ticks(axis, cuts)
    axis.legend(ncols=2)
    shop.save("cutoff")


@figure
def iterations(shop: Workshop) -> None:
    """Parameters of IDIM-IV by iteration, from a start that knows nothing."""
    document, true = shop.result(SCARA / "scara_iv.toml"), truth()
    chi = np.array([i["chi"] for i in document["iterations"]])
    _, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for k, name in enumerate(p["name"] for p in document["parameters"]):
        axes[0].plot(chi[:, k] / true[name], "o-", ms=4, label=name)
    axes[0].axhline(1, color=MEASURED, lw=1)
    axes[0].set(xlabel="iteration", ylabel="value / true value", title="Parameters", xticks=range(len(chi)), ylim=(-0.5, 3))
    axes[0].legend(ncols=4, fontsize=7)
    axes[1].semilogy([100 * i["relative_error"] for i in document["iterations"]], "o-", color=MODEL)
    axes[1].set(xlabel="iteration", ylabel="‖Y − V χ‖ / ‖Y‖ [%]", title="Torque error", xticks=range(len(chi)))
    shop.save("iterations")


@figure
def coverage(shop: Workshop) -> None:
    """Share of confidence intervals that hold the truth, by rivid_montecarlo."""
    runs = 20 if shop.quick else 200
    shop.run("rivid_montecarlo", SCARA / "montecarlo_s1.toml", "--set", f"montecarlo.runs={runs}", "--output", "coverage", "--quiet")
    trials = json.loads((shop.work / "coverage/summary.json").read_text())["trials"]
    wanted = ("WLS; exact rows", "IV; exact rows", "WLS; the paper's rows")
    _, axis = plt.subplots(figsize=(8, 3.4), layout="constrained")
    for k, (label, color) in enumerate(zip(wanted, (MODEL, OTHER, RESIDUAL))):
        trial = next(t for t in trials if t["label"] == label)
        names = [p["name"] for p in trial["parameters"]]
        share = np.array([100 * p["coverage"] for p in trial["parameters"]])
        axis.plot(np.arange(len(names)) + 0.15 * (k - 1), share, "o", color=color, label=label.replace("; ", ", "))
    axis.axhline(95, color=MEASURED, lw=1)
    axis.set(xticks=range(len(names)), ylim=(0, 103), ylabel="coverage [%]", title=f"95 % intervals that hold the truth, {runs} simulated logs")
    axis.set_xticklabels(names)
    axis.legend(loc="lower left")
    shop.save("coverage")


@figure
def simulation(shop: Workshop) -> None:
    """A simulated closed loop: reference and motion, and the control signal."""
    shop.run("rivid_simulate", SCARA / "simulate_s2.toml", "--output", "scara", "--quiet")
    log = Log(shop.work / "scara/log.csv", 3)
    _, axes = plt.subplots(2, 2, figsize=(9, 4.2), sharex=True, layout="constrained")
    for j in range(2):
        axes[0, j].plot(log.t_all, log["qref"][:, j], color=RESIDUAL, label="reference")
        axes[0, j].plot(log.t_all, log["q"][:, j], color=MODEL, label="measured")
        axes[0, j].set(title=f"joint_{j + 1}", ylabel="position [rad]")
        axes[1, j].plot(log.t_all, log["v"][:, j], color=MEASURED, lw=0.6)
        axes[1, j].set(xlabel="t [s]", ylabel="control signal [N·m]")
    axes[0, 0].legend()
    shop.save("simulation")


@figure
def stiction(shop: Workshop) -> None:
    """A reversal with stiction: the joint stops and sticks until the torque exceeds Fc."""
    shop.run("rivid_simulate", SCARA / "simulate_s2.toml", "--output", "quiet", "--quiet", "--set", "simulation.position_noise=0",
             "--set", "simulation.disturbance=0")
    log = Log(shop.work / "quiet/log.csv", 3)
    qd = np.gradient(log["q"][:, 1], log.t_all)
    rest = np.abs(qd) < 1e-9
    edges = np.flatnonzero(np.diff(rest.astype(int)))
    begin, end = max(((a, b) for a, b in zip(edges, edges[1:]) if rest[a + 1] and a > 200), key=lambda s: s[1] - s[0])
    span = slice(begin - 80, end + 80)
    _, axes = plt.subplots(2, 1, figsize=(7, 3.8), sharex=True, layout="constrained")
    axes[0].plot(log.t_all[span], qd[span], color=MODEL)
    axes[0].set(ylabel="velocity [rad/s]", title="joint_2 of the SCARA sticks (shaded) at a reversal")
    axes[1].plot(log.t_all[span], log["v"][span, 1], color=MEASURED)
    axes[1].set(xlabel="t [s]", ylabel="control signal [N·m]")
    for axis in axes:
        axis.axvspan(log.t_all[begin + 1], log.t_all[end], color=RESIDUAL, alpha=0.3, lw=0)
    shop.save("stiction")


def designed(shop: Workshop) -> Path:
    folder = shop.work / "plan"
    if not (folder / "plan.json").exists():
        evaluations = 20 if shop.quick else 400
        shop.run("rivid_excite", ARM / "excite.toml", "--output", "plan", "--quiet", "--set", f"excitation.evaluations={evaluations}")
    return folder


@figure
def excitation(shop: Workshop) -> None:
    """The motion that rivid_excite designs for the six-joint arm, as shares of the limits."""
    folder = designed(shop)
    motion = np.genfromtxt(folder / "motion.csv", delimiter=",", names=True)
    limits = json.loads((folder / "plan.json").read_text())["limits"]
    _, axes = plt.subplots(1, 2, figsize=(10, 3.4), width_ratios=(3, 2), layout="constrained")
    for j in range(6):
        axes[0].plot(motion["t"], motion[f"q{j + 1}"], label=f"joint_{j + 1}")
    axes[0].set(xlabel="t [s]", ylabel="position [rad]", title="Designed motion")
    axes[0].legend(ncols=3, fontsize=7)
    for k, quantity in enumerate(("position", "velocity", "acceleration", "torque")):
        share = [100 * max(x["share"] for x in limits if x["joint"] == f"joint_{j + 1}" and x["quantity"] == quantity) for j in range(6)]
        axes[1].bar(np.arange(6) + 0.2 * (k - 1.5), share, width=0.18, label=quantity)
    axes[1].set(xticks=range(6), xticklabels=[f"{j + 1}" for j in range(6)], xlabel="joint", ylabel="share of the limit [%]", title="Limits used")
    axes[1].legend(fontsize=7, ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    shop.save("excitation")


@figure
def forecast(shop: Workshop) -> None:
    """Standard deviations that the design forecasts, beside those of an identification from that motion."""
    folder = designed(shop)
    shop.run("rivid_simulate", folder / "experiment.toml", "--output", folder, "--quiet", "--set", "simulation.position_noise=1e-7",
             "--set", "simulation.disturbance=[0.4,0.5,0.2,0.1,0.1,0.05]")
    document = shop.result(folder / "experiment.toml", method__name="wls")
    planned = {p["name"]: p["sigma"] for p in json.loads((folder / "plan.json").read_text())["parameters"]}
    found = {p["name"]: p["plain_sigma"] for p in document["parameters"]}
    names = [name for name in planned if name in found]
    x, y = (np.array([of[name] for name in names]) for of in (planned, found))
    _, axis = plt.subplots(figsize=(4.6, 4), layout="constrained")
    axis.loglog(x, y, "o", color=MODEL, ms=4)
    axis.loglog([x.min(), x.max()], [x.min(), x.max()], color=MEASURED, lw=1)
    axis.set(xlabel="forecast standard deviation", ylabel="standard deviation of the fit", title="Before and after the motion")
    shop.save("forecast")


@figure
def torque_shares(shop: Workshop) -> None:
    """Which part of each joint's torque is gravity, inertia, Coriolis, friction."""
    model, log = shop.arm().model, Log(shop.arm_log(), 41)
    q, qd, qdd = (x[::20] for x in (log.q, log.qd, log.qdd))
    still = np.zeros_like(q)
    gravity, inertia = model.gravity(q), model.rigid_body(q, still, qdd) - model.gravity(q)
    parts = np.array([gravity, inertia, model.rigid_body(q, qd, qdd) - gravity - inertia, model.friction(qd)])
    parts = np.sqrt((parts**2).mean(axis=1))
    _, axis = plt.subplots(figsize=(7, 3), layout="constrained")
    left = np.zeros(6)
    for name, part, color in zip(("gravity", "inertia", "Coriolis, centrifugal", "friction"), 100 * parts / parts.sum(axis=0),
                                 (MEASURED, MODEL, OTHER, RESIDUAL)):
        axis.barh(range(6), part, left=left, color=color, label=name)
        left += part
    axis.set(yticks=range(6), yticklabels=[f"joint_{j + 1}" for j in range(6)], xlabel="share of the torque, rms [%]", xlim=(0, 100))
    axis.set_title("What the torques of the six-joint arm consist of", pad=24)
    axis.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    axis.invert_yaxis()
    shop.save("torque_shares")


def heavy(shop: Workshop) -> Path:
    """The URDF of the six-joint arm with masses that are 50 % too large."""
    path = shop.work / "heavy.urdf"
    text = (ARM / "six_axis.urdf").read_text(encoding="utf-8")
    path.write_text(re.sub(r'<mass value="([^"]+)"', lambda m: f'<mass value="{1.5 * float(m.group(1)):.12g}"', text), encoding="utf-8")
    return path


@figure
def physical(shop: Workshop) -> None:
    """Masses of the links: of the description, of the physically consistent estimate, true."""
    names = [f"link_{j + 1}" for j in range(6)]
    true = [float(x) for x in re.findall(r'<mass value="([^"]+)"', (ARM / "six_axis.urdf").read_text())][-6:]
    document = shop.result(ARM / "six_axis.toml", "--log", shop.arm_log(), robot__urdf=str(heavy(shop)), method__name="wls",
                           method__physical=True)
    links = document["physical"]["links"]
    rows = [[p for p in link["parameters"] if p["name"] == f"M{j + 1}"][0] for j, link in enumerate(links)]
    _, axis = plt.subplots(figsize=(7, 3), layout="constrained")
    series = (("true", true, MEASURED), ("description, 50 % too heavy", [r["a_priori"] for r in rows], RESIDUAL),
              ("physically consistent estimate", [r["value"] for r in rows], MODEL))
    for k, (label, values, color) in enumerate(series):
        axis.bar(np.arange(6) + 0.27 * (k - 1), values, width=0.25, color=color, label=label)
    axis.set(xticks=range(6), xticklabels=names, ylabel="mass [kg]", title="Masses that the torques and the description leave")
    axis.legend()
    shop.save("physical")


def with_payload(shop: Workshop, mass: float) -> Path:
    """A log of the arm with a point-like body on its last link."""
    urdf = (ARM / "six_axis.urdf").read_text()
    body = (f'<link name="load"><inertial><origin xyz="0.03 0 0.08"/><mass value="{mass}"/>'
            '<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.002"/></inertial></link>'
            '<joint name="grasp" type="fixed"><parent link="flange"/><child link="load"/></joint></robot>')
    (shop.work / "loaded.urdf").write_text(urdf.replace("</robot>", body))
    folder = shop.work / f"loaded_{mass:g}"
    shop.run("rivid_simulate", ARM / "simulate.toml", "--set", f'robot.urdf="{shop.work / "loaded.urdf"}"', "--seed", "77", "--output", folder, "--quiet")
    return folder / "log.csv"


@figure
def payload(shop: Workshop) -> None:
    """Masses of payloads that the arm carries, with their intervals."""
    masses = (0.2, 2.0) if shop.quick else (0.1, 0.2, 0.5, 1.0, 2.0)
    _, axis = plt.subplots(figsize=(5.5, 3.2), layout="constrained")
    for mass in masses:
        out = shop.work / f"payload_{mass:g}"
        shop.run("rivid_identify", "payload", ARM / "six_axis.toml", "--log", shop.arm_log(), "--loaded", with_payload(shop, mass), "--output", out, "--quiet")
        found = json.loads((out / "payload.json").read_text())
        one = found["payloads"][0]["values"]["mass"]
        low, high = one["interval_95"]
        axis.plot([mass, mass], [100 * (low / mass - 1), 100 * (high / mass - 1)], color=MODEL, lw=4, alpha=0.6, solid_capstyle="butt")
        axis.plot(mass, 100 * (one["value"] / mass - 1), "o", color=MODEL)
    axis.axhline(0, color=MEASURED, lw=1)
    axis.set(xscale="log", xlabel="mass of the payload [kg]", ylabel="error of the estimate [%]", title="Payload, estimate and 95 % interval")
    ticks(axis, masses)
    shop.save("payload")


@figure
def online(shop: Workshop) -> None:
    """The mass that a control loop estimates while the arm moves with a payload."""
    mass = 2.0
    document = shop.result(ARM / "six_axis.toml", "--log", shop.arm_log())
    shop.run("rivid_online", with_payload(shop, mass), "--result", shop._folders[id(document)] / "result.json", "--output", "online", "--quiet", statuses=(0, 1))
    table = np.genfromtxt(shop.work / "online/online.csv", delimiter=",", names=True)
    t, estimate, half = table["t"], table["mass"], table["mass_half_width"]
    _, axis = plt.subplots(figsize=(6.5, 2.8), layout="constrained")
    axis.fill_between(t, estimate - half, estimate + half, color=MODEL, alpha=0.25, lw=0, label="95 % interval")
    axis.plot(t, estimate, color=MODEL, label="estimate")
    axis.axhline(mass, color=MEASURED, lw=1, label="true mass")
    axis.set(xlim=(0, 3), ylim=(0, 2 * mass), xlabel="t [s]", ylabel="payload [kg]")
    axis.legend()
    shop.save("online")


def with_column(source: Path, target: Path, change: Callable[[list[str], Array], None]) -> Path:
    """A copy of a CSV log whose numbers are changed."""
    with source.open(encoding="utf-8") as lines:
        names = lines.readline().strip().split(",")
    values = np.loadtxt(source, delimiter=",", skiprows=1)
    change(names, values)
    np.savetxt(target, values, delimiter=",", header=",".join(names), comments="")
    return target


@figure
def planted_faults(shop: Workshop) -> None:
    """Wrong torque gains, planted in the arm's log, and the sizes that the score tests report."""
    gains = (0.2,) if shop.quick else (-0.2, -0.1, -0.05, 0.05, 0.1, 0.2)
    _, axis = plt.subplots(figsize=(5, 3.4), layout="constrained")
    for joint, color in ((2, OTHER), (3, MODEL)):
        for gain in gains:

            def change(names: list[str], values: Array, factor: float = 1 + gain) -> None:
                values[:, names.index(f"v{joint}")] *= factor

            log = with_column(shop.arm_log(), shop.work / f"gain_{joint}_{gain}.csv", change)
            document = shop.result(ARM / "six_axis.toml", "--log", log, method__name="wls")
            for other in document.get("alternatives", []):
                if other["code"] == "torque_gain" and other["subject"] == f"joint_{joint}":
                    label = f"joint_{joint}" if gain == gains[-1] else None
                    size, half = 100 * other["estimate"][0], 196 * other["sigma"][0]
                    axis.errorbar(100 * gain, size, half, fmt="o", color=color, capsize=2, label=label)
    axis.plot([-20, 20], [-20, 20], color=MEASURED, lw=1)
    axis.set(xlabel="planted error of the gain [%]", ylabel="reported [%]", title="Score test torque_gain")
    axis.legend()
    shop.save("planted_faults")


@figure
def outliers(shop: Workshop) -> None:
    """Least squares and robust estimates of a log with spikes in the torques."""
    true = truth()
    shares = (0, 0.01) if shop.quick else (0, 0.001, 0.002, 0.005, 0.01, 0.02)
    generator = np.random.default_rng(5)
    spikes = generator.normal(size=(4001, 2)) * (12, 3)
    when = generator.random((4001, 2))
    _, axis = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
    for loss, color in (("off", RESIDUAL), ("huber", OTHER), ("bisquare", MODEL)):
        error = []
        for share in shares:
            def change(names: list[str], values: Array, share: float = share) -> None:
                for j in range(2):
                    values[:, names.index(f"v{j + 1}")] += np.where(when[:, j] < share, spikes[:, j], 0)
            log = with_column(SCARA / "scara_s2.csv", shop.work / f"spikes_{share}.csv", change)
            document = shop.result(SCARA / "scara.toml", "--log", log, signal__cutoff_hz="off", method__robust=loss)
            names = ("ZZ1R", "ZZ2", "MX2", "Fc1", "Fc2")
            error.append(100 * max(abs(parameter(document, name)["value"] / true[name] - 1) for name in names))
        axis.plot([100 * s for s in shares], error, "o-", color=color, label="least squares" if loss == "off" else loss)
    axis.set(xlabel="samples with a spike [%]", ylabel="largest error [%]", title="ZZ1R, ZZ2, MX2, Fc1, Fc2 of the SCARA")
    axis.legend()
    shop.save("outliers")


@figure
def log_length(shop: Workshop) -> None:
    """Relative standard deviations by the length of the log."""
    lengths = (4, 10) if shop.quick else (2, 3, 4, 5, 6, 8, 10)
    table: dict[str, list[float]] = {name: [] for name in ("ZZ1R", "Fc1", "Fv1", "Ia4", "Fc6")}
    for seconds in lengths:
        document = shop.result(ARM / "six_axis.toml", "--log", shop.arm_log(), method__name="wls", signal__window=[0, seconds])
        for name, values in table.items():
            values.append(parameter(document, name)["relative_sigma_percent"])
    _, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for name, values in table.items():
        axis.loglog(lengths, values, "o-", ms=4, label=name)
    axis.set(xlabel="length of the log [s]", ylabel="standard deviation [% of the value]", title="Six-joint arm, by the length of the log")
    ticks(axis, lengths)
    axis.legend()
    shop.save("log_length")


@figure
def torque_lag(shop: Workshop) -> None:
    """Planted time offsets between torque and motion, and their estimates."""
    lags = (-1, 1) if shop.quick else (-1, -0.5, 0, 0.5, 1, 2)
    _, axis = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
    for joint_lag in lags:
        document = shop.result(SCARA / "scara.toml", log__torque_lag=joint_lag, signal__cutoff_hz="off")
        lag = document["tests"]["torque_lag"]
        axis.errorbar(-joint_lag, lag["samples"], 1.96 * lag["sigma"], fmt="o", color=MODEL, capsize=2)
    axis.plot([-max(lags), -min(lags)], [-max(lags), -min(lags)], color=MEASURED, lw=1)
    axis.set(xlabel="planted offset [samples]", ylabel="estimated offset [samples]", title="Time offset of the torques")
    shop.save("torque_lag")


@figure
def gallery(shop: Workshop) -> None:
    """The robots of the repository and the errors of their joints."""
    _, axes = plt.subplots(1, 2, figsize=(9, 3), width_ratios=(1, 2), layout="constrained")
    results = (shop.result(SCARA / "scara_iv.toml"), shop.arm().document)
    for axis, document, title in zip(axes, results, ("SCARA", "six-joint arm")):
        joints = document["fit"]["joints"]
        axis.bar([j["name"] for j in joints], [100 * j["relative_error"] for j in joints], color=MODEL)
        axis.set(ylabel="relative torque error [%]", title=f"{title}, IDIM-IV")
        axis.tick_params(axis="x", labelsize=8)
    shop.save("gallery")


@figure
def comparison(shop: Workshop) -> None:
    """Errors of a result and of two descriptions of the six-joint arm on a new log, by rivid_identify compare."""
    shop.run("rivid_simulate", ARM / "simulate.toml", "--seed", 9, "--output", "new_log", "--quiet")
    shop.run("rivid_identify", ARM / "six_axis.toml", "--log", shop.arm_log(), "--output", "identified", "--quiet")
    document = json.loads(shop.run("rivid_identify", "compare", "identified", ARM / "six_axis.urdf", heavy(shop), "--log", "new_log/log.csv", "--json"))
    labels = ("identified", "true URDF, without rotor inertias", "URDF, 50 % too heavy")
    _, axis = plt.subplots(figsize=(7.5, 3), layout="constrained")
    for k, (model, label, color) in enumerate(zip(document["models"], labels, (MODEL, OTHER, RESIDUAL))):
        errors = [100 * error for error in model["joints"]]
        axis.bar(np.arange(len(errors)) + 0.27 * (k - 1), errors, width=0.25, color=color, label=label)
    axis.set(xticks=range(len(errors)), xticklabels=document["joints"], yscale="log", ylabel="relative torque error [%]", title="Three models on a new log")
    axis.set_yticks((0.5, 1, 2, 5, 10, 20, 50), ("0.5", "1", "2", "5", "10", "20", "50"))
    axis.minorticks_off()
    axis.legend(fontsize=7, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.1))
    shop.save("comparison")


@figure
def friction_laws(shop: Workshop) -> None:
    """The friction laws of experiment files, as curves."""
    qd = np.concatenate([np.linspace(-1, -1e-4, 200), [0], np.linspace(1e-4, 1, 200)])
    sign = np.sign(qd)
    curves = {
        "coulomb": 0.6 * qd + 0.5 * sign,
        "symmetric": 0.6 * qd + 0.5 * sign + 0.15,
        "asymmetric": np.where(qd > 0, 0.4 * qd + 0.4, 0.8 * qd - 0.6) * np.abs(sign),
        "root": 0.2 * qd + 0.6 * np.sqrt(np.abs(qd)) * sign + 0.3 * sign,
    }
    _, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), sharey=True, layout="constrained")
    for name, torque in curves.items():
        left.plot(qd, torque, label=f'"{name}"')
    for load, style in ((0.0, "-"), (2.0, "--"), (5.0, ":")):
        right.plot(qd, 0.6 * qd + (0.3 + 0.08 * load) * sign, style, color=MODEL, label=f"load torque {load:g} N·m")
    left.set(ylabel="friction torque [N·m]", title="Laws of the velocity")
    right.set(title='"load": Fl = 0.08')
    for axis in (left, right):
        axis.set_xlabel("joint velocity [rad/s]")
        axis.legend(loc="upper left")
    shop.save("friction_laws")


@figure
def guide(shop: Workshop) -> None:
    """Torque and friction of the UR10e of docs/guide.md; its logs are not in the repository."""
    if shop.data is None or not (shop.data / "ur10e/ur10e.urdf").exists():
        print("figures: skipped guide: no logs of the UR10e")
        return
    if not (shop.work / "ur10e").exists():
        (shop.work / "ur10e").symlink_to(shop.data / "ur10e")
    first, more = re.findall(r"^```toml\n(.*?)^```", (ROOT / "docs/guide.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (shop.work / "ur10e.toml").write_text(first.replace("\n[signal]", f"{more}\n[signal]"), encoding="utf-8")
    fit = shop.fit("ur10e", Path("ur10e.toml"))
    gains = [joint["drive_gain"] for joint in fit.document["robot"]["joints"]]
    log = Log(shop.work / "ur10e/unload_14harm.csv", 15, gains)
    _, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), width_ratios=(3, 2), layout="constrained")
    draw_fit(left, fit, log, 2)
    left.set(xlim=(5, 25), title="UR10e, elbow: a log that was not used in the fit")
    draw_friction(right, fit, log, 2)
    right.set_title("UR10e, friction of the elbow")
    shop.save("guide")


@figure
def rollouts(shop: Workshop) -> None:
    """Rollout error of real robots on held-out logs, open loop; the logs are not in the repository."""
    folders = ("ur10e", "panda", "dfki_double_pendulum", "dfki_simple_pendulum")
    if shop.data is None or not all((shop.data / f).is_dir() for f in folders):
        print("figures: skipped rollouts: no logs of real robots")
        return
    for folder in folders[:2]:
        shutil.copyfile(ROOT / f"tests/real/{folder}.toml", shop.work / f"rollouts_{folder}.toml")
        if not (shop.work / folder).exists():
            (shop.work / folder).symlink_to(shop.data / folder)
    head, *rows = (shop.data / "panda/panda_1khz.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    for name, part in (("fit", rows[:12000]), ("held_out", rows[12000:])):
        (shop.work / f"panda_{name}.csv").write_text(head + "".join(part), encoding="utf-8")
    double, simple = (shop.data / f for f in folders[2:])
    for name, urdf, position, torque in (("double", double / "acrobot.urdf", ["q1", "q2"], ["tau1", "tau2"]),
                                         ("simple", simple / "pendulum.urdf", ["position"], ["torque"])):
        (shop.work / f"rollouts_{name}.toml").write_text(
            f'[robot]\nurdf = "{urdf}"\nfriction = "symmetric"\n[log]\nfiles = ["run.csv"]\ntime = "time"\nposition = {position}\ntorque = {torque}\n'
            'irregular = "resample"\n[method]\nname = "wls"\n', encoding="utf-8")
    ur10e = shop.data / "ur10e"
    robots = (("UR10e", "rollouts_ur10e", [ur10e / "ident_30s_12harm.csv"], ur10e / "unload_14harm.csv"),
              ("Panda, first 12 s, then 9 s", "rollouts_panda", ["panda_fit.csv", "--physical"], "panda_held_out.csv"),
              ("Double pendulum", "rollouts_double", [double / "run_1.csv", "--log", double / "run_2.csv"], double / "run_3.csv"),
              ("Simple pendulum", "rollouts_simple", [simple / "pd_sysid.csv"], simple / "energy_shaping.csv"))
    _, axes = plt.subplots(1, 4, figsize=(12, 3.2), sharey=True, layout="constrained")
    for axis, (title, name, fit, held_out) in zip(axes, robots, strict=True):
        shop.run("rivid_identify", f"{name}.toml", "--log", *fit, "--output", name, "--quiet", "--force", statuses=(0, 1))
        document = json.loads(shop.run("rivid_identify", "validate", name, held_out, "--rollout", "--json", statuses=(0, 1)))
        found = [one for one in document["rollouts"]["found"] if one["drive"] == "torques" and all(m["position"] for m in one["models"])]
        for k, (label, colour) in enumerate((("identified", MODEL), ("robot description", RESIDUAL))):
            errors = [np.linalg.norm(one["models"][k]["position"]) for one in found]
            print(f"rollouts: {title}, {label}:", *(f"{e:.3g} rad after {one['horizon']} s," for e, one in zip(errors, found, strict=True)))
            axis.loglog([one["horizon"] for one in found], errors, "o-", color=colour, label=label)
        axis.axhline(np.pi, color=MEASURED, linewidth=0.8, linestyle=":")  # half a turn: the motion is lost
        axis.set(title=title, xlabel="horizon [s]", xticks=[0.1, 0.3, 1, 3], xticklabels=["0.1", "0.3", "1", "3"], ylim=(1e-3, 1e5))
        axis.minorticks_off()
    axes[0].set_ylabel("error of all joints [rad]")
    axes[0].legend()
    shop.save("rollouts")


@figure
def samples(shop: Workshop) -> None:
    """Description, estimate and samples of it in MuJoCo, by the torques of a log that was not used in the fit, beside that log."""
    try:
        import mujoco
    except ImportError:
        print("figures: skipped samples: no MuJoCo")
        return
    if shop.data is None or not (shop.data / "dfki_double_pendulum").is_dir():
        print("figures: skipped samples: no logs of real robots")
        return
    folder = shop.data / "dfki_double_pendulum"
    (shop.work / "samples.toml").write_text(
        f'[robot]\nurdf = "{folder}/acrobot.urdf"\nfriction = "symmetric"\n[log]\nfiles = ["{folder}/run_1.csv", "{folder}/run_2.csv"]\n'
        'time = "time"\nposition = ["q1", "q2"]\ntorque = ["tau1", "tau2"]\nirregular = "resample"\n[method]\nname = "wls"\n', encoding="utf-8")
    shop.run("rivid_identify", "samples.toml", "--physical", "--output", "samples", "--quiet", "--force", statuses=(0, 1))
    for options in (("--output", "samples/estimate.xml"), ("--output", "samples/drawn.xml", "--samples", 64)):
        shop.run("rivid_identify", "export", "samples", "--to", "mjcf", "--force", *options)
    table = np.genfromtxt(folder / "run_3.csv", delimiter=",", names=True)
    step, length = 0.002, 150
    t = np.arange(table["time"][0], table["time"][-1], step)
    q, tau = (np.column_stack([np.interp(t, table["time"], table[f"{what}{j}"]) for j in (1, 2)]) for what in ("q", "tau"))
    starts = range(1000, 2000, length)

    def moved(file: Path) -> Array:
        """Positions in windows of the log, each from its measured start; one row of gaps between them."""
        model = mujoco.MjModel.from_xml_path(str(file))
        model.opt.timestep = step
        out = []
        for first in starts:
            data = mujoco.MjData(model)
            near = first + np.arange(-5, 6)
            data.qpos[:], data.qvel[:] = q[first], np.polyfit(t[near], q[near], 1)[0]
            for k in range(first, first + length):
                out.append(data.qpos.copy())
                data.qfrc_applied[:] = tau[k]
                mujoco.mj_step(model, data)
            out[-1][:] = np.nan
        return np.array(out)

    shown = np.arange(starts[0], starts[-1] + length)
    drawn = [moved(shop.work / f"samples/drawn_{k:03}.xml") for k in range(64)]
    models = (("robot description", OTHER, moved(folder / "acrobot.urdf")), ("estimate", MODEL, moved(shop.work / "samples/estimate.xml")))
    _, axes = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
    for j, axis in enumerate(axes):
        for k, one in enumerate(drawn):
            axis.plot(t[shown], one[:, j], color=RESIDUAL, lw=0.5, alpha=0.6, label=None if k else "64 samples")
        for label, colour, one in models:
            axis.plot(t[shown], one[:, j], color=colour, lw=1.8, label=label)
        axis.plot(t[shown], q[shown, j], "--", color="black", lw=1.5, label="log")
        axis.set(ylabel=f"joint {j + 1} [rad]")
    axes[0].set_title("Double pendulum in MuJoCo by logged torques, each 0.3 s anew from the measured state")
    axes[0].legend(ncols=4)
    axes[1].set_xlabel("t [s]")
    shop.save("samples")


@figure
def report(shop: Workshop) -> None:
    """The first screen of report.html."""
    shop.arm_log()
    chromium = next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if p), None)
    if chromium is None:
        print("figures: skipped report: no Chromium")
        return
    for name in ("six_axis.toml", "six_axis.urdf"):
        shutil.copyfile(ARM / name, shop.work / name)
    shop.run("rivid_identify", "six_axis.toml", "--log", "arm_log/log.csv", "--report", "--output", "report", "--quiet")
    subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--window-size=1280,900", "--virtual-time-budget=5000",
                    f"--screenshot={shop.out / 'report.png'}", f"file://{shop.work}/report/report.html"], check=True, capture_output=True, timeout=300)
    shrink(shop.out / "report.png")


def main() -> int:
    parser = argparse.ArgumentParser(description="Draws the figures of the documentation.")
    parser.add_argument("--tools", type=Path, required=True, help="folder of the built tools")
    parser.add_argument("--out", type=Path, required=True, help="folder for the figures")
    parser.add_argument("--work", type=Path, help="folder for logs and results; default: work beside the figures")
    parser.add_argument("--data", type=Path, help="folder with the logs of real robots")
    parser.add_argument("--quick", action="store_true", help="fewer simulations")
    parser.add_argument("--only", nargs="*", default=[], choices=list(FIGURES), help="these figures alone")
    given = parser.parse_args()
    work = given.work or given.out.resolve().parent / "figures_work"
    for folder in (work, given.out):
        folder.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.alpha": 0.25,
                         "legend.frameon": False, "lines.linewidth": 1.2})
    shop = Workshop(given.tools, work, given.out, given.quick, given.data)
    for name in given.only or FIGURES:
        FIGURES[name](shop)
        print(f"figures: {name}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
