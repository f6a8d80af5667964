"""What identify() does, written out with the functions that it is made of; both answers must agree."""

import sys
from pathlib import Path

import numpy as np

import rivid
from rivid import signal

data = Path(sys.argv[1] if len(sys.argv) > 1 else "data/scara")
robot = rivid.Robot.from_urdf(data / "scara.urdf", friction="coulomb", rotor_inertia=False)
log = rivid.read_log(data / "scara_s2.csv", robot).shifted(-0.5)

cutoff_hz = 20.0
n_d = 14
border = 20  # samples that filter and differences spoil at each end
inner = slice(border, len(log) - border)

base = robot.base_parameters()  # (4–6)
whole = signal.differentiate(signal.zero_phase(log.q, log.rate_hz, cutoff_hz), log.rate_hz)
motion = [x[inner] for x in whole]  # q̂ and its derivatives
tau = signal.decimate(robot.effort(log)[inner], n_d)  # (8), then (13)
rows = robot.regressor(*motion)  # (10–12): samples, joints, base parameters
W = np.vstack([signal.decimate(rows[:, j], n_d) for j in range(len(robot))])  # joint by joint (14)
Y = tau.T.ravel()

chi = np.linalg.lstsq(W, Y)[0]  # (15)
# (17), and what the decimation filter has taken from the deviations is given back
sigma_rho = np.linalg.norm(Y - W @ chi) / np.sqrt(len(Y) - len(chi)) / signal.deviation_factor(n_d)
C_chi = sigma_rho**2 * np.linalg.inv(W.T @ W)  # (18)

fit = rivid.identify(
    robot,
    log,
    rivid.Ols(
        rows="paper", cutoff_hz=cutoff_hz, decimation=n_d, trim=[border, border], covariance="classical"
    ),
)
for i, name in enumerate(base):
    print(f"{name}: {chi[i]:.8g} and {fit.chi[i]:.8g}, sigma {np.sqrt(C_chi[i, i]):.4g} and {fit.sigma[i]:.4g}")

# Two factorisations of the same rows are 10 ε κ apart at most; the normal equations above square κ.
condition = np.linalg.cond(W)
tolerance = 10 * np.finfo(float).eps * condition
assert np.linalg.norm(chi - fit.chi) <= tolerance * np.linalg.norm(chi)
assert np.linalg.norm(C_chi - fit.covariance) <= tolerance * condition * np.linalg.norm(C_chi)
