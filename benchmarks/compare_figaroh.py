"""FIGAROH and rivid on the same simulated logs of data/six_axis: time, and how many 95 % intervals hold the truth.

    python3 -m venv venv && venv/bin/pip install figaroh
    venv/bin/python benchmarks/compare_figaroh.py build/test/apps [--logs 10]

FIGAROH's side is what its BaseIdentification does, from its own functions: Butterworth filter of order 4 forwards and backwards,
differences, regressor with friction and rotor inertias, elimination of columns, decimation of torques and columns, base parameters by
double QR, least squares, deviations of relative_stdev(). The cut-off and the decimation are those that suit this arm. rivid's side is
rivid_identify with rows chosen by the noise. The truth are the parameters of the simulation.
"""

import argparse
import json
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from figaroh.identification.identification_tools import relative_stdev
from figaroh.tools.qrdecomposition import build_baseRegressor, get_baseParams
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced, get_index_eliminate
from scipy import signal

ARM = Path(__file__).resolve().parents[1] / "data/six_axis"
CUTOFF_HZ, DECIMATION, RATE_HZ, JOINTS = 20.0, 10, 1000.0, 6
ROTORS = [0.362, 0.507, 0.0829, 0.0341, 0.0361, 0.0114]  # kg m², as in simulate.toml


class Arm:
    """What FIGAROH's functions need of a robot."""

    def __init__(self, urdf: Path) -> None:
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.model.gravity.linear = np.array([0, 0, -9.81])
        self.data = self.model.createData()


def truth(model: pin.Model) -> np.ndarray:
    """True standard parameters, in the order of FIGAROH's regressor."""
    bodies = [model.inertias[j + 1].toDynamicParameters() for j in range(JOINTS)]
    return np.concatenate([*bodies, model.damping, model.upperDryFrictionLimit, ROTORS])


def derivatives(q: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = signal.filtfilt(*signal.butter(4, CUTOFF_HZ / (rate / 2)), q, axis=0)
    qd = np.gradient(q, 1 / rate, axis=0)
    return q, qd, np.gradient(qd, 1 / rate, axis=0)


def at_samples(held: np.ndarray) -> np.ndarray:
    """Torques that each act until the next sample, at the samples."""
    return np.vstack([held[:1], (held[:-1] + held[1:]) / 2])


def decimated(rows: np.ndarray, joints: int, factor: int) -> np.ndarray:
    return np.concatenate([signal.decimate(joint, factor, axis=0, zero_phase=True) for joint in np.split(rows, joints)])


@dataclass
class Solved:
    """Base parameters by FIGAROH, and of which columns of its standard regressor they are."""

    gone: list[int]  # columns without influence
    index: list[int]  # base columns among the others
    W: np.ndarray  # decimated, without these columns
    W_b: np.ndarray
    y: np.ndarray
    chi: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """That of relative_stdev(), not rounded."""
        residual = self.y - self.W_b @ self.chi
        return residual @ residual / (len(self.y) - len(self.chi)) * np.linalg.inv(self.W_b.T @ self.W_b)


def solved(arm: Arm, motion: tuple[np.ndarray, ...], tau: np.ndarray, factor: int, **options: bool) -> Solved:
    """FIGAROH's way from a motion and its torques, one row a sample, to base parameters."""
    joints = tau.shape[1]
    terms = {"has_friction": True, "has_actuator_inertia": True, "is_joint_torques": True, "act_idxv": range(joints), **options}
    W = build_regressor_basic(arm, *motion, terms)
    names = {str(k): 0.0 for k in range(W.shape[1])}
    gone, rest = get_index_eliminate(W, names, 1e-6)
    W_d = np.column_stack([decimated(column, joints, factor) for column in build_regressor_reduced(W, gone).T])
    y = decimated(tau.T.ravel(), joints, factor)
    _, _, index = get_baseParams(W_d, rest, names)
    W_b = build_baseRegressor(W_d, index)
    return Solved(gone, index, W_d, W_b, y, np.linalg.lstsq(W_b, y, rcond=None)[0])


def by_figaroh(arm: Arm, log: np.ndarray) -> np.ndarray:
    """Distance of the base parameters from the truth in their deviations."""
    keep = slice(200, -200)
    motion = tuple(x[keep] for x in derivatives(log[:, 1 : 1 + JOINTS], RATE_HZ))
    found = solved(arm, motion, at_samples(log[:, 1 + JOINTS : 1 + 2 * JOINTS])[keep], DECIMATION)
    sigma = np.abs(found.chi) * relative_stdev(found.W_b, found.chi, found.y) / 100
    true = np.linalg.lstsq(found.W_b, found.W @ np.delete(truth(arm.model), found.gone), rcond=None)[0]
    return (found.chi - true) / sigma


def by_rivid(tools: Path, log: Path, folder: str) -> np.ndarray:
    """Whether each 95 % interval holds the truth, which is the experiment's a-priori value."""
    subprocess.run([tools / "rivid_identify", ARM / "six_axis.toml", "--method", "wls", "--set", 'signal.decimation="auto"', "--log", log,
                    "--output", folder, "--quiet"], check=True)
    result = json.loads((Path(folder) / "result.json").read_text(encoding="utf-8"))
    return np.array([p["interval_95"][0] <= p["a_priori"] <= p["interval_95"][1] for p in result["parameters"]])


def main() -> None:
    parser = argparse.ArgumentParser(description="FIGAROH and rivid on the same logs.")
    parser.add_argument("tools", type=Path, help="folder of rivid's tools")
    parser.add_argument("--logs", type=int, default=10)
    given = parser.parse_args()
    arm, tools = Arm(ARM / "six_axis.urdf"), given.tools.resolve()
    hits: dict[str, list[np.ndarray]] = {"FIGAROH": [], "rivid": []}
    seconds = {"FIGAROH": 0.0, "rivid": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, given.logs + 1):
            subprocess.run([tools / "rivid_simulate", ARM / "simulate.toml", "--seed", str(seed), "--output", folder, "--quiet"], check=True)
            path = Path(folder) / "log.csv"
            log = np.loadtxt(path, delimiter=",", skiprows=1)
            start = time.process_time()
            far = by_figaroh(arm, log)
            seconds["FIGAROH"] += time.process_time() - start
            hits["FIGAROH"].append(np.abs(far) <= 1.96)
            start = time.perf_counter()
            hits["rivid"].append(by_rivid(tools, path, folder))
            seconds["rivid"] += time.perf_counter() - start
    for name, found in hits.items():
        share = 100 * np.mean(np.concatenate(found))
        print(f"{name}: {len(found[0])} base parameters, {share:.1f} % of the 95 % intervals hold the truth, {seconds[name] / given.logs:.2f} s a log")


if __name__ == "__main__":
    main()
