"""Drawings of a fit on Matplotlib axes, which each function returns; without ``axes`` it makes a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from rivid.fit import Fit
    from rivid.types import LogSource


def panels(axes: Any, count: int, **options: Any) -> Any:
    """Given axes as a list, or those of a new figure, one below the other."""
    if axes is not None:
        return np.ravel(axes)
    import matplotlib.pyplot as plt

    return plt.subplots(count, squeeze=False, layout="constrained", **options)[1][:, 0]


def torques(fit: Fit, axes: Any = None) -> Any:
    """Measured and predicted torques of the first log of the fit, joint by joint; ``fit.predict(log).plot()`` is of another."""
    return fit.predictions[0].plot(axes)


def residuals(fit: Fit, axes: Any = None) -> Any:
    """Measured less predicted torques of the rows, joint by joint, over time."""
    axes = panels(axes, len(fit.robot.joints), sharex=True)
    for axis, joint in zip(axes, fit.fit):
        for log in fit.predictions:
            rows, residual = log.rows(joint["name"])
            axis.plot(log.t[rows], residual, ".", markersize=3, label=log.source)
        axis.set_ylabel(f"{joint['name']} [{joint['unit']}]")
    axes[-1].set_xlabel("t [s]")
    return axes


def friction(fit: Fit, axes: Any = None) -> Any:
    """Friction over velocity, joint by joint: the rows, the law, and its 95 % confidence interval."""
    table = fit.friction_curves
    joints = list(dict.fromkeys(row["joint"] for row in table))
    axes = panels(axes, max(len(joints), 1))
    for axis, joint in zip(axes, joints):
        v, law, low, high, measured = (
            np.array([row[key] for row in table if row["joint"] == joint])
            for key in ("velocity", "friction", "low_95", "high_95", "measured")
        )
        axis.plot(v, measured, ".", label="measured")
        axis.plot(v, law, label="law")
        axis.fill_between(v, low, high, alpha=0.3, label="95 % interval")
        axis.set_ylabel(f"{joint} friction")
    axes[-1].set_xlabel("velocity [rad/s | m/s]")
    axes[0].legend(loc="upper left")
    return axes


def rollout(fit: Fit, log: LogSource, *others: Any, axes: Any = None) -> Any:
    """Position errors of the fit simulated with the torques of a log, over the time since its measured start, joint by joint.

    ``others`` are models to draw beside it: fits, paths of result.json, URDFs or parameter files, see ``compare``.
    """
    from rivid.commands import compare

    found = compare([fit, *others], log, rollout=True)["rollouts"]["found"]
    axes = panels(axes, len(fit.robot.joints), sharex=True)
    for j, (axis, joint) in enumerate(zip(axes, fit.robot.joints)):
        for models in zip(*(one["models"] for one in found)):
            errors = [model["position"][j] if model["position"] else np.nan for model in models]
            axis.loglog([one["horizon"] for one in found], errors, "o-", label=models[0]["name"])
        axis.set_ylabel(f"{joint} rms error [rad | m]")
    axes[-1].set_xlabel("horizon [s]")
    axes[0].legend(loc="upper left")
    return axes


def intervals(fit: Fit, axes: Any = None) -> Any:
    """Half widths of the 95 % confidence intervals in percent of the values; weak parameters in another colour."""
    (axis,) = panels(axes, 1)
    shown = [p for p in fit.parameters if p["sigma"] is not None and p["value"]]
    half = [50.0 * (p["interval_95"][1] - p["interval_95"][0]) / abs(p["value"]) for p in shown]
    axis.barh([p["name"] for p in shown], half, color=["C0" if p["verdict"] == "identified" else "C1" for p in shown])
    axis.set_xscale("log")
    axis.invert_yaxis()
    axis.set_xlabel("95 % confidence interval [± % of the value]")
    return axis


def correlation(fit: Fit, axes: Any = None) -> Any:
    """Correlations of the estimates."""
    (axis,) = panels(axes, 1)
    sigma = np.sqrt(np.diag(fit.covariance))
    image = axis.imshow(fit.covariance / np.outer(sigma, sigma), cmap="RdBu_r", vmin=-1, vmax=1)
    names = fit.parameters["name"]
    axis.set_xticks(range(len(names)), names, rotation=90)
    axis.set_yticks(range(len(names)), names)
    axis.figure.colorbar(image, ax=axis)
    return axis
