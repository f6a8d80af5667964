"""Designed motions on arms that are simulated or faked: what is told, recorded, noticed."""

import importlib
import json
import shutil
import sys
import types

import fake_ros
import numpy as np
import pytest
from conftest import REPOSITORY

import rivid
from rivid import play

FRICTION = 0.4


@pytest.fixture(scope="module")
def designed(scara, tool, tmp_path_factory):
    """A folder with the plan of a motion of 5 s."""
    folder = tmp_path_factory.mktemp("designed")
    plan = folder / "plan.toml"
    arm = (scara / "scara.toml").read_text().split("[log]")[0].replace("scara.urdf", str(scara / "scara.urdf"))
    plan.write_text(
        f"{arm}[excitation]\nduration = 5\nrate_hz = 200\nharmonics = 3\nstarts = 1\nevaluations = 40\nnoise = 0.02\n"
        "[excitation.limits]\nlower = -2\nupper = 2\nvelocity = 3\nacceleration = 10\ntorque = 40\n"
    )
    tool("rivid_excite", plan, "--output", folder / "plan", "--quiet")
    return folder / "plan"


@pytest.fixture
def plan(designed, tmp_path):
    """A copy of it."""
    return shutil.copytree(designed, tmp_path / "plan")


@pytest.fixture
def path(plan):
    return play.Path.of_plan(plan)


@pytest.fixture
def model(plan):
    return rivid.Experiment(plan / "experiment.toml").robot


def heavier(robot, name, value, rate_hz=500.0):
    """The robot with another value of a parameter, as an arm has it."""
    values = robot.standard_parameters
    out = play.Simulated(robot, np.zeros(len(robot)), rate_hz=rate_hz)
    out._dynamics = rivid.InverseDynamics(robot.model({**values, name: values[name] + value}))
    return out


def test_path_is_the_designed_series(plan, path):
    motion = json.loads((plan / "plan.json").read_text())["motion"]
    A, B, w = np.array(motion["A"]), np.array(motion["B"]), motion["omega_f"] * np.arange(1, 4)
    for t in np.linspace(0.0, path.duration, 97):
        s, c = np.sin(w * t), np.cos(w * t)
        q, qd, qdd = path.at(t)
        assert q == pytest.approx(np.array(motion["q0"]) + A @ (s / w) - B @ (c / w), abs=1e-9)
        assert qd == pytest.approx(A @ c + B @ s, abs=1e-7)
        assert qdd == pytest.approx(-A @ (w * s) + B @ (w * c), abs=1e-4)


def test_three_speeds_are_recorded_and_identified(plan, path, model, tool):
    arm = play.Simulated(model, path.at(0.0)[0], rate_hz=500.0, noise=0.01, delay=3)
    asked = []
    runs = play.play(plan, arm, go=lambda speed, last: asked.append((speed, last)) or True)
    assert [run.speed for run in runs] == [0.1, 0.5, 1.0] and all(run.stopped is None for run in runs)
    assert [speed for speed, _ in asked] == [0.1, 0.5, 1.0] and asked[2][1] is runs[1]
    for run, name, seconds in zip(runs, ("log_10.csv", "log_50.csv", "log.csv"), (50.0, 10.0, 5.0)):
        assert run.file == plan / name and np.all(run.tracking < 1e-6) and np.all(run.torque < 0.06)
        comment, *_ = run.file.read_text().splitlines()
        inside = json.loads(comment.removeprefix("# rivid play: "))
        assert inside["speed"] == run.speed and inside["motion"] == json.loads((plan / "plan.json").read_text())["motion"]
        columns = np.genfromtxt(run.file, delimiter=",", names=True, skip_header=1)
        assert columns["t"][-1] == pytest.approx(seconds, abs=4e-3)
        for t, q1, told in zip(columns["t"][::50], columns["q1"][::50], columns["qref1"][::50]):
            assert told == pytest.approx(path.at(run.speed * t)[0][0], abs=1e-6)
            assert q1 == pytest.approx(path.at(run.speed * (t - 0.006))[0][0], abs=1e-6)
    rivid.draft(REPOSITORY / "data/scara/scara.urdf", runs[2].file, plan / "drafted.toml")
    drafted = (plan / "drafted.toml").read_text()
    assert all(f'"{name}"' in drafted for name in ("q2", "tau1", "qref1"))
    fit = rivid.identify(plan / "experiment.toml")
    truth = model.base_parameters().from_standard(list(model.standard_parameters.values()))
    assert np.all(np.abs(fit.chi - truth) < 5.0 * fit.sigma) and fit.status == "identified"


def test_a_heavier_arm_is_stopped_along_the_path(plan, path, model):
    arm = heavier(model, "Fc2", 15.0)
    arm._q = path.at(0.0)[0]
    runs = play.play(plan, arm)
    assert len(runs) == 1 and "joint_2: distance of the torque from the forecast" in runs[0].stopped
    columns = np.genfromtxt(runs[0].file, delimiter=",", names=True, skip_header=1)
    assert 0.02 <= columns["t"][-1] < 0.02 + arm.stop_seconds + 0.3
    assert abs(columns["qd2"][-1]) < 1e-3 and '"stopped": "joint_2' in runs[0].file.read_text()
    on_path = min(np.abs(path.at(s)[0] - [columns["q1"][-1], columns["q2"][-1]]).max() for s in np.linspace(0, 0.2, 2001))
    assert on_path < 1e-5


@pytest.mark.parametrize("samples, stops", [(5, False), (15, True)])
def test_glitches_do_not_stop_it(plan, path, model, samples, stops):
    class Glitch(play.Simulated):
        count = 0

        def step(self):
            state = super().step()
            self.count += 1
            return state._replace(effort=state.effort + 30.0) if state is not None and 400 <= self.count < 400 + samples else state

    (run,) = play.play(plan, Glitch(model, path.at(0.0)[0]), speeds=[1.0])
    assert (run.stopped is not None) == stops


def test_an_arm_that_stands_beside_the_path_is_told_no_step(plan, path, model):
    arm = play.Simulated(model, path.at(0.0)[0] + [0.015, -0.015])
    (run,) = play.play(plan, arm, speeds=[0.5])
    columns = np.genfromtxt(run.file, delimiter=",", names=True, skip_header=1)
    q = np.column_stack([columns["q1"], columns["q2"]])
    assert np.abs(np.diff(q, 2, axis=0)).max() < 5.0 * 0.002**2
    late = columns["t"] > 1.01
    assert q[late] == pytest.approx(np.array([path.at(0.5 * t)[0] for t in columns["t"][late]]), abs=1e-9)


def test_readings_that_are_no_numbers_stop_it(plan, path, model):
    class Blind(play.Simulated):
        def step(self):
            state = super().step()
            return state if state is None else state._replace(effort=state.effort * np.nan)

    assert play.play(plan, Blind(model, path.at(0.0)[0]))[-1].stopped == "a reading is no number"


def test_a_watch_that_fails_leaves_no_moving_arm(plan, path, model, monkeypatch):
    arm = play.Simulated(model, path.at(0.0)[0])
    monkeypatch.setattr(play.Watch, "complaint", lambda self, state: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        play.play(plan, arm)
    assert arm.resting() and '"stopped": "division by zero"' in (plan / "log_10.csv").read_text()


def test_a_joint_that_does_not_follow_is_stopped(plan, path, model):
    class Stuck(play.Simulated):
        def step(self):
            state = super().step()
            return state if state is None else state._replace(q=np.array([self.stuck, state.q[1]]))

    arm = Stuck(model, path.at(0.0)[0])
    arm.stuck = path.at(0.0)[0][0]
    run = play.play(plan, arm, tracking=0.05)[-1]
    assert "joint_1: distance from the positions told" in run.stopped and run.tracking[0] == pytest.approx(0.05, rel=0.5)


def test_no_faster_than_the_torque_allows(plan, path, model):
    arm = heavier(model, "Fc2", 7.0, rate_hz=100.0)
    arm._q = path.at(0.0)[0]
    document = json.loads((plan / "plan.json").read_text())
    most = max(abs(row["value"]) for row in document["limits"] if row["joint"] == "joint_2" and row["quantity"] == "torque")
    document["provenance"]["options"]["excitation"]["limits"]["torque"] = [40.0, most + 6.5]
    (plan / "plan.json").write_text(json.dumps(document))
    with pytest.raises(rivid.InputError, match=r"at 100 % joint_2: the torque foretold is up to .*, and was missed by 7"):
        play.play(plan, arm, torque_band=20.0)
    assert (plan / "log_50.csv").exists() and not (plan / "log.csv").exists()


def test_what_can_not_begin(plan, path, model):
    far = play.Simulated(model, path.at(0.0)[0] + [0.0, 0.2])
    with pytest.raises(rivid.InputError, match=r"joint_2 is at .*, must be within 0.02 of .*, where the motion begins"):
        play.play(plan, far)
    arm = play.Simulated(model, path.at(0.0)[0])
    with pytest.raises(rivid.InputError, match="speeds are .*, must be rising numbers above 0, at most 1"):
        play.play(plan, arm, speeds=[0.5, 2.0])
    with pytest.raises(rivid.InputError, match=r"nowhere.motion.csv is not there"):
        play.play(plan / "nowhere", arm)
    (plan / "log.csv").write_text("mine")
    with pytest.raises(rivid.InputError, match="log.csv: is there already"):
        play.play(plan, arm)
    assert (plan / "log.csv").read_text() == "mine" and not (plan / "log_10.csv").exists()
    assert play.play(plan, arm, speeds=[1.0], go=lambda speed, last: False, force=True) == []
    document = json.loads((plan / "plan.json").read_text())
    document["provenance"]["options"]["excitation"]["limits"]["torque"] = [40.0, np.inf]
    (plan / "plan.json").write_text(json.dumps(document))
    with pytest.raises(rivid.InputError, match="joint_2 has no torque limit, so torque_band must say"):
        play.play(plan, arm, force=True)


@pytest.mark.parametrize("error", [TimeoutError("no state for 0.1 s"), KeyboardInterrupt()])
def test_nothing_is_lost(plan, path, model, error):
    class Breaks(play.Simulated):
        count = 0

        def step(self):
            self.count += 1
            if self.count == 300:
                raise error
            return super().step()

    arm = Breaks(model, path.at(0.0)[0])
    if isinstance(error, KeyboardInterrupt):
        assert play.play(plan, arm)[-1].stopped == "interrupted" and arm.resting()
    else:
        with pytest.raises(TimeoutError):
            play.play(plan, arm)
    assert len((plan / "log_10.csv").read_text().splitlines()) >= 301


def fake_ur(robot, start, gains):
    """The two modules of ur_rtde: an arm that is where it was told, and reads currents."""
    dynamics, arm = rivid.InverseDynamics(robot.model()), types.SimpleNamespace(t=7.0, q=np.array(start), qd=0.0 * start, qdd=0.0 * start, told=[], ended=0)

    class Receive:
        def __init__(self, host, rate_hz):
            assert host == "10.0.0.2" and rate_hz == 500.0

        getTimestamp = staticmethod(lambda: arm.t)
        getActualQ = staticmethod(lambda: arm.q.tolist())
        getActualQd = staticmethod(lambda: arm.qd.tolist())
        getActualCurrent = staticmethod(lambda: (dynamics.torque(arm.q, arm.qd, arm.qdd) / gains).tolist())

    class Control(Receive):
        def initPeriod(self):
            return arm.t

        def waitPeriod(self, started):
            arm.t = started + 0.002

        def servoJ(self, q, speed, acceleration, period, look_ahead, stiffness):
            assert isinstance(q, list) and period == 0.002 and 0.03 <= look_ahead <= 0.2 and 100 <= stiffness <= 2000
            before = arm.qd
            arm.qd, arm.q = (np.array(q) - arm.q) / period, np.array(q)
            arm.qdd = (arm.qd - before) / period
            arm.told.append(q)
            return True

        def servoStop(self):
            arm.ended += 1

    return arm, {"rtde_receive": {"RTDEReceiveInterface": Receive}, "rtde_control": {"RTDEControlInterface": Control}}


def install(monkeypatch, modules):
    for name, content in modules.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)


def test_universal_robots_reads_currents(plan, path, model, monkeypatch):
    gains = np.array([12.0, -9.0])
    arm, modules = fake_ur(model, path.at(0.0)[0], gains)
    install(monkeypatch, modules)
    robot = importlib.import_module("rivid.play.ur").UniversalRobot("10.0.0.2")
    runs = play.play(plan, robot, speeds=[0.5, 1.0], torque_band=25.0)
    assert arm.ended == 2 and [run.stopped for run in runs] == [None, None]
    assert runs[0].unwatched == model.joints and runs[1].unwatched == model.joints[1:] and "not watched: " in str(runs[1])
    # A motor whose current has the other sign has no gain, and is not watched.
    assert runs[0].torque == pytest.approx(0.0) and runs[1].torque[0] < 2.0 and runs[1].torque[1] == 0.0
    assert np.array(arm.told[-1]) == pytest.approx(path.at(path.duration)[0], abs=1e-9)
    columns = np.genfromtxt(plan / "log.csv", delimiter=",", names=True, skip_header=1)
    assert {"v1", "v2", "qref2"} <= set(columns.dtype.names) and "tau1" not in columns.dtype.names


def test_franka_is_told_a_position_each_millisecond(plan, path, model, monkeypatch):
    dynamics, start = rivid.InverseDynamics(model.model()), path.at(0.0)[0]
    arm = types.SimpleNamespace(t=0.0, q=start, dq=0.0 * start, finished=[])

    class JointPositions:
        def __init__(self, q):
            self.q, self.motion_finished = q, False

    def seconds(value):
        return types.SimpleNamespace(to_sec=lambda: value)

    def state():
        tau = dynamics.torque(np.array(arm.q), np.array(arm.dq), 0.0 * start)
        return types.SimpleNamespace(time=seconds(arm.t), q=list(arm.q), dq=list(arm.dq), tau_J=list(tau))

    class Control:
        def readOnce(self):
            arm.t += 0.001
            return state(), seconds(0.001)

        def writeOnce(self, command):
            arm.dq, arm.q = (np.array(command.q) - arm.q) / 0.001, np.array(command.q)
            arm.finished.append(command.motion_finished)

    class Robot:
        def __init__(self, host):
            assert host == "fr3"

        read_once = staticmethod(state)
        start_joint_position_control = staticmethod(lambda mode: Control())

    install(monkeypatch, {"pylibfranka": {"Robot": Robot, "JointPositions": JointPositions, "ControllerMode": types.SimpleNamespace(JointImpedance=1)}})
    franka = importlib.import_module("rivid.play.franka").Franka("fr3")
    (run,) = play.play(plan, franka, speeds=[1.0], torque_band=30.0)
    assert run.stopped is None and arm.finished == [False] * 4999 + [True]


def ros_torques(robot):
    return rivid.InverseDynamics(robot.model()).torque


def test_ros_plays_and_is_recorded(plan, path, model, monkeypatch):
    controller = fake_ros.Controller(model.joints, path.at(0.0)[0], ros_torques(model))
    fake_ros.install(monkeypatch, controller)
    arm = importlib.import_module("rivid.play.ros").RosArm(model.joints)
    runs = play.play(plan, arm, speeds=[0.5, 1.0], torque_band=2.0)
    assert [run.stopped for run in runs] == [None, None] and np.all(runs[1].tracking < 1e-3)
    points = controller.goal.trajectory.points
    for k in (0, 100, len(points) - 1):
        t = points[k].time_from_start.sec + 1e-9 * points[k].time_from_start.nanosec
        for values, wanted in zip((points[k].positions, points[k].velocities, points[k].accelerations), path.at(t)):
            assert values == pytest.approx(wanted, abs=1e-6)
    columns = np.genfromtxt(plan / "log.csv", delimiter=",", names=True, skip_header=1)
    moving = columns["t"] > 0
    assert columns["t"][0] == pytest.approx(-0.5, abs=0.02)
    assert columns["q2"][moving] == pytest.approx([path.at(t)[0][1] for t in columns["t"][moving]], abs=2e-3)


def test_ros_is_cancelled(plan, path, model, monkeypatch):
    torques = ros_torques(model)
    controller = fake_ros.Controller(model.joints, path.at(0.0)[0], lambda *state: torques(*state) + [0.0, 20.0])
    fake_ros.install(monkeypatch, controller)
    run = play.play(plan, importlib.import_module("rivid.play.ros").RosArm(model.joints))[-1]
    assert controller.cancelled and "joint_2: distance of the torque" in run.stopped


@pytest.mark.parametrize("fault", ["refused", "silent", "renamed"])
def test_ros_that_does_not_answer(plan, path, model, monkeypatch, fault):
    controller = fake_ros.Controller(model.joints, path.at(0.0)[0], ros_torques(model), accepts=fault != "refused")
    fake_ros.install(monkeypatch, controller)
    arm = importlib.import_module("rivid.play.ros").RosArm([*model.joints[:1], "wrist"] if fault == "renamed" else model.joints)
    if fault == "silent":
        monkeypatch.setattr("rivid.play.ros._PATIENCE", 0.05)
        controller.tick = lambda: None
    says = {"refused": "does not accept the trajectory", "silent": "no joint states for 0.05 s", "renamed": "joint states have no 'wrist'"}
    with pytest.raises((OSError, rivid.InputError), match=says[fault]):
        play.play(plan, arm)


def test_the_node_of_ros(plan, path, model, monkeypatch, capsys):
    controller = fake_ros.Controller(model.joints, path.at(0.0)[0], ros_torques(model))
    controller.parameters = {"plan": str(plan), "speeds": [1.0]}
    fake_ros.install(monkeypatch, controller)
    monkeypatch.syspath_prepend(REPOSITORY / "ros/rivid_ros")
    assert importlib.import_module("rivid_ros.play").main() == 0
    assert "100 %: done" in capsys.readouterr().out and (plan / "log.csv").exists()


def test_the_command_line(plan, program):
    done = program("play", plan, "--on", "simulation", "--yes", "--speeds", "0.5,1")
    assert done.returncode == 0 and "50 %: done" in done.stdout and "next: rivid identify" in done.stdout
    done = program("play", plan, "--on", "simulation", "--yes")
    assert done.returncode == 2 and "is there already" in done.stderr
    done = program("play", plan, "--on", "kuka:1.2.3.4")
    assert done.returncode == 2 and "must be ros, ur:HOST, franka:HOST or simulation" in done.stderr
