"""Standard deviations of one log of the UR10e, forecast from another.

Each log is identified; the mean ratio of reported to forecast standard deviations of each joint, with the joint's residual as
noise, says how much its errors are worth more than independent ones of their size. With noise enlarged so the
motions of the other logs are forecast, before their torques are looked at. Printed: the median of forecast over reported
standard deviations of all parameters, and 16 and 84 %.

    python benchmarks/excite_after.py build/test/apps DATA/ur10e        # needs numpy and scipy
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, filtfilt

LOGS = ("ident_30s_12harm", "ident_40s_12harm", "unload_14harm")
RATE = 100.0  # Hz, after resampling
CUTOFF = 7.0  # Hz
TRIM = 50  # samples
ROBOT = """[robot]
urdf = "{data}/ur10e.urdf"
friction = "symmetric"
drive_gain = [11.78, 11.98, 9.82, 10.69, 10.53, 10.63]
"""
LOG = """[log]
files = ["{data}/{log}.csv"]
position = ["q1", "q2", "q3", "q4", "q5", "q6"]
control = ["i1", "i2", "i3", "i4", "i5", "i6"]
irregular = "resample"
resample_hz = 100
[signal]
rows = "paper"
cutoff_hz = 7
order = 4
decimation = 5
trim = 50
[method]
name = "wls"
covariance = "hac"
"""
EXCITATION = """[excitation]
rate_hz = 100
noise = {noise}
noise_rate_hz = 20
"""


def motion_of(data, log, path):
    """The motion of a log as its rows see it: resampled, filtered, without its ends."""
    with open(data / f"{log}.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    time = next(name for name in ("t", "time") if name in rows[0])
    t = np.array([float(row[time]) for row in rows])
    q = np.array([[float(row[f"q{j}"]) for j in range(1, 7)] for row in rows])
    even = np.arange(t[0], t[-1], 1 / RATE)
    smooth = filtfilt(*butter(4, CUTOFF / (RATE / 2)), CubicSpline(t, q)(even), axis=0)[TRIM:-TRIM]
    header = "t," + ",".join(f"q{j}" for j in range(1, 7))
    np.savetxt(path, np.column_stack([even[TRIM:-TRIM], smooth]), delimiter=",", header=header, comments="")


class Study:
    def __init__(self, apps, data, folder):
        self.apps, self.data, self.folder = apps, data, folder

    def experiment(self, name, text, **values):
        file = self.folder / name
        file.write_text((ROBOT + text).format(data=self.data, **values))
        return file

    def run(self, program, *arguments):
        subprocess.run([self.apps / program, *arguments, "--quiet"], check=True, capture_output=True)

    def residuals(self, log):
        self.run("rivid_identify", self.experiment("log.toml", LOG, log=log), "--output", self.folder / "result")
        return json.loads((self.folder / "result/result.json").read_text())

    def check(self, log, noise):
        """Reported over forecast standard deviations of a log."""
        file = self.experiment("motion.toml", EXCITATION, noise=json.dumps(list(noise)))
        motion_of(self.data, log, self.folder / "motion.csv")
        self.run("rivid_excite", "forecast", file, self.folder / "motion.csv", "--output", self.folder / "forecast")
        plan = self.folder / "forecast/forecast.json"
        log_file = self.experiment("log.toml", LOG, log=log)
        self.run("rivid_identify", log_file, "--output", self.folder / "result", "--plan", plan)
        return json.loads((self.folder / "result/plan_check.json").read_text())


def main():
    apps, data = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    with tempfile.TemporaryDirectory() as name:
        study = Study(apps, data, pathlib.Path(name))
        for known in LOGS:
            result = study.residuals(known)
            sigma = np.array([joint["sigma_rho"] for joint in result["fit"]["joints"]])
            worth = [joint["ratio"] for joint in study.check(known, sigma)["joints"]]
            for other in LOGS:
                if other == known:
                    continue
                ratios = [1 / p["ratio"] for p in study.check(other, sigma * worth)["parameters"]]
                low, median, high = np.quantile(ratios, [0.16, 0.5, 0.84])
                print(f"{known} -> {other}: forecast over reported {median:.2f} ({low:.2f}-{high:.2f})", flush=True)


if __name__ == "__main__":
    main()
