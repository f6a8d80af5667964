"""Six-joint arms of position servos, goal and position alone: output error with unknown gains and an unknown delay.

Random arms are moved by Pinocchio's articulated-body algorithm: nothing in the logs comes from rivid. Each joint has armature, dry and
viscous friction and an encoder of 4096 steps, whose positions the law u = K_p e + K_d de/dt and the log have. The law runs at 100 Hz and
its torque comes 0 to 40 ms late. The experiment file has gains off by 10 %, a delay of 20 ms, and a robot description off by 20 %; method
"output_error" estimates gains and delay beside the parameters. Printed of each arm, and of all:

    95 % intervals that hold the true base parameter, gain and delay
    the same without the scale of all, which is one draw of the gains an arm: K_p is known exactly ("known")
    error of the delay in samples, and over its standard deviation
    seconds, status and warnings

    venv/bin/python benchmarks/servos_pinocchio.py build/test/apps/rivid [COUNT [FIRST [known]]]      # packages: pin, numpy
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time
from types import SimpleNamespace

import numpy as np
import pinocchio as pin

JOINTS = 6
RATE = 100.0  # Hz, of law and log
DURATION = 30.0  # s, of the log
HELD = 2.0  # s, at the first goal before it
QUANTUM = 2 * np.pi / 4096
GAIN_SIGMA, DELAY, DELAY_SIGMA, OFF = 0.1, 2.0, 2.0, 0.2  # of what the experiment file says
FRICTION_SPEED = 3e-3  # rad/s: friction is Fc tanh(v / FRICTION_SPEED)
STEPS = 20  # of the integration between two changes of the torque


def urdf(links):
    """Joint axes in turn vertical and horizontal, as the angles say."""
    lines = ['<robot name="arm"><link name="l0"/>']
    for j, link in enumerate(links, 1):
        xx, yy, zz, xy, xz, yz = link.inertia
        lines.append(
            f'<link name="l{j}"><inertial><origin xyz="{" ".join(map(repr, link.com))}"/><mass value="{link.mass!r}"/>'
            f'<inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="{xy!r}" ixz="{xz!r}" iyz="{yz!r}"/></inertial></link>'
            f'<joint name="j{j}" type="revolute"><parent link="l{j - 1}"/><child link="l{j}"/>'
            f'<origin xyz="{" ".join(map(repr, link.at))}" rpy="{link.turn!r} 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" effort="100" velocity="20"/></joint>'
        )
    return "".join(lines) + "</robot>"


def box(mass, size):
    x, y, z = np.square(size)
    return [float(i) for i in mass / 12 * np.array([y + z, x + z, x + y])] + [0.0] * 3


class Arm:
    def __init__(self, seed, folder):
        self.random = random = np.random.default_rng(seed)
        self.links = []
        for j in range(JOINTS):
            length, mass = random.uniform(0.06, 0.15), random.uniform(0.15, 0.5) * (1 - 0.1 * j)
            at = [0.0, 0.0, 0.05] if j == 0 else [float(self.links[-1].length), 0.0, 0.0]
            turn = 0.0 if j == 0 else float(random.choice([np.pi / 2, -np.pi / 2, 0.0]))
            com = [float(x) for x in (length / 2 + random.normal(0, 0.01), *random.normal(0, 0.01, 2))]
            self.links.append(SimpleNamespace(mass=float(mass), com=com, inertia=box(mass, (length, 0.05, 0.05)), at=at,
                                              turn=np.pi / 2 if j == 1 else turn, length=length))  # fmt: skip
        (folder / "true.urdf").write_text(urdf(self.links))
        for link in self.links:
            scale = float(np.exp(OFF * random.normal()))
            link.mass, link.inertia = link.mass * scale, [x * scale for x in link.inertia]
        (folder / "off.urdf").write_text(urdf(self.links))
        self.model = pin.buildModelFromUrdf(str(folder / "true.urdf"))
        self.data = self.model.createData()
        self.Ia = random.uniform(0.01, 0.04, JOINTS)
        self.model.armature[:] = self.Ia
        poses = random.uniform(-1.5, 1.5, (40, JOINTS))
        # What a joint's torque accelerates while all others yield: gains that a late law keeps stable.
        J = np.min([1 / np.diag(np.linalg.inv(pin.crba(self.model, self.data, q))) for q in poses], axis=0)
        self.Fv, self.Fc = J * random.uniform(0.5, 2, JOINTS), J * random.uniform(0.5, 2, JOINTS)
        omega, zeta = random.uniform(7, 10, JOINTS), random.uniform(0.7, 1, JOINTS)
        self.K_p, self.K_d = J * omega**2, 2 * zeta * omega * J
        self.delay = random.uniform(0, 4)  # samples

    def acceleration(self, q, v, tau):
        return pin.aba(self.model, self.data, q, v, tau - self.Fv * v - self.Fc * np.tanh(v / FRICTION_SPEED))

    def moved(self, q, v, tau, duration):
        h = duration / STEPS
        for _ in range(STEPS if duration > 0 else 0):
            middle = v + self.acceleration(q, v, tau) * h / 2
            q, v = q + middle * h, v + self.acceleration(q + v * h / 2, middle, tau) * h
        return q, v

    def goals(self, t):
        """A sum of sines that grows from rest, and its rate."""
        omega = 2 * np.pi / 10 * np.arange(1, 9)
        sines, cosines = self.random.normal(size=(2, JOINTS, len(omega)))

        def at(t):
            out = np.sin(np.outer(t, omega)) @ sines.T + np.cos(np.outer(t, omega)) @ cosines.T
            s = np.clip(t / 2, 0, 1)[:, None]
            return (10 * s**3 - 15 * s**4 + 6 * s**5) * out

        scale = 1.3 / np.abs(at(t)).max(axis=0)
        return scale * at(t), scale * (at(t + 1e-5) - at(t - 1e-5)) / 2e-5

    def log(self, file):
        t = np.arange(-HELD, DURATION, 1 / RATE)
        goal, rate = self.goals(t)
        q, v, before = goal[0].copy(), np.zeros(JOINTS), goal[0].copy()
        whole = int(self.delay)
        part = self.delay - whole
        asked = [self.K_p * 0] * (whole + 2)
        rows = []
        for k in range(len(t)):
            measured = QUANTUM * np.round(q / QUANTUM)
            asked.append(self.K_p * (goal[k] - measured) + self.K_d * (rate[k] - (measured - before) * RATE))
            before = measured
            rows.append(np.concatenate([[t[k]], measured, goal[k]]))
            q, v = self.moved(q, v, asked[-2 - whole], part / RATE)
            q, v = self.moved(q, v, asked[-1 - whole], (1 - part) / RATE)
        rows = [row for row in rows if row[0] >= -1e-9]
        header = ["t"] + [f"{what}{j + 1}" for what in ("q", "qref") for j in range(JOINTS)]
        np.savetxt(file, rows, delimiter=",", header=",".join(header), comments="", fmt="%.9g")
        self.error = float(np.sqrt(np.mean([(row[1 : 1 + JOINTS] - row[1 + JOINTS :]) ** 2 for row in rows])))

    def experiment(self, folder, method, gains, description, off):
        lines = ["[robot]", f'urdf = "{folder}/{description}"', "gravity = [0, 0, -9.81]", 'friction = "coulomb"']
        for j in range(JOINTS):
            Ia, Fv, Fc = (float(x[j] * o) for x, o in zip((self.Ia, self.Fv, self.Fc), off[:, j]))
            lines.append(f"joints.j{j + 1} = {{ rotor_inertia = true, Ia = {Ia!r}, Fv = {Fv!r}, Fc = {Fc!r} }}")
        lines += ["[log]", f'files = ["{folder}/log.csv"]', "[control]", 'law = "pid"', f"rate_hz = {RATE}", f"delay = {DELAY}"]
        lines += [f"{name} = {json.dumps(list(values))}" for name, values in gains.items()]
        unknown = ", ".join(f"{name} = {GAIN_SIGMA}" for name in gains if np.any(gains[name] != getattr(self, name)))
        lines += [f"delay_sigma = {DELAY_SIGMA}", f"gain_sigma = {{ {unknown} }}"]
        lines += ["[method]", f'name = "{method}"', "transient = 2"]
        return "\n".join(lines) + "\n"


def identified(program, folder, text):
    file = folder / "experiment.toml"
    file.write_text(text)
    begin = time.monotonic()
    run = subprocess.run([program, "identify", "--json", str(file)], cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode > 1:
        return SimpleNamespace(failed=run.stderr, seconds=time.monotonic() - begin)
    return SimpleNamespace(failed="", result=json.loads(run.stdout), seconds=time.monotonic() - begin)


def main():
    program, count, first = str(pathlib.Path(sys.argv[1]).resolve()), int((sys.argv[2:] or ["20"])[0]), int((sys.argv[3:] or ["1"])[0])
    known_scale = sys.argv[4:] == ["known"]
    held = {"parameters": [], "K_p": [], "K_d": [], "delay": []}
    scaled, delays, scores, failed = [], [], [], 0
    for seed in range(first, first + count):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            arm = Arm(seed, folder)
            arm.log(folder / "log.csv")
            off = np.exp(OFF * arm.random.normal(size=(3, JOINTS)))
            known = {name: getattr(arm, name) * np.exp(GAIN_SIGMA * arm.random.normal(size=JOINTS)) for name in ("K_p", "K_d")}
            known["K_p"] = arm.K_p if known_scale else known["K_p"]
            truth = identified(program, folder, arm.experiment(folder, "wls", known, "true.urdf", np.ones((3, JOINTS))))
            found = identified(program, folder, arm.experiment(folder, "output_error", known, "off.urdf", off))
        if found.failed or "output_error" not in found.result or found.result["status"] not in ("identified", "doubtful"):
            failed += 1
            print(f"{seed:4} {found.failed or found.result['status'] + ': ' + '; '.join(found.result['reasons'])}", flush=True)
            continue
        mine = {name: [] for name in held}
        for p, true in zip(found.result["parameters"], truth.result["parameters"]):
            assert p["name"] == true["name"]
            mine["parameters"].append(p["interval_95"][0] <= true["a_priori"] <= p["interval_95"][1])
            scaled.append((p["value"] - true["a_priori"]) / p["sigma"])
        for one in found.result["output_error"]["loop"]:
            true = arm.delay if one["name"] == "delay" else getattr(arm, one["name"])[int(one["joint"][1:]) - 1]
            mine[one["name"]].append(one["interval_95"][0] <= true <= one["interval_95"][1])
            if one["name"] == "delay":
                delays.append(one["value"] - true)
                scores.append(delays[-1] / one["sigma"])
                delay = f"delay {true:.3f}, found {one['value']:.4f} ± {one['sigma']:.4f}"
        for name in held:
            held[name] += mine[name]
        codes = sorted({w["code"] for w in found.result["warnings"]})
        counts = ", ".join(f"{name} {sum(mine[name])} of {len(mine[name])}" for name in held)
        print(f"{seed:4} {counts}; {delay}; tracking {1e3 * arm.error:.0f} mrad, {found.seconds:.1f} s, {' '.join(codes)}", flush=True)
    print(f"\n{count - failed} of {count} arms identified")
    for name, hits in ((name, hits) for name, hits in held.items() if hits):
        print(f"{name}: {sum(hits)} of {len(hits)} intervals hold the truth, {100 * np.mean(hits):.1f} %")
    print(f"rms of error over sigma of the parameters: {np.sqrt(np.mean(np.square(scaled))):.2f}")
    print(f"error of the delay [samples]: rms {np.sqrt(np.mean(np.square(delays))):.4f}, largest {np.abs(delays).max():.4f}; "
          f"over sigma: mean {np.mean(scores):.2f}, deviation {np.std(scores):.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
