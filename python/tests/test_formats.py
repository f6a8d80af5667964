"""Logs in the formats that robots write; the files are written by the libraries that own the formats."""

import csv
import datetime
import json
import re
from pathlib import Path

import numpy as np
import pytest

import rivid

METHOD = rivid.Wls(torque_held=True, decimation=20)


@pytest.fixture(scope="module")
def series(columns):
    """Time, positions and torques of the SCARA's log; its control signals are torques."""
    return {
        "t": columns["t"],
        "q": np.column_stack([columns["q1"], columns["q2"]]),
        "tau": np.column_stack([columns["v1"], columns["v2"]]),
    }


@pytest.fixture(scope="module")
def expected(robot, series):
    """Their parameters."""
    return rivid.identify(robot, rivid.Log(series["t"], series["q"], series["tau"]), METHOD).chi


def assert_same(robot, source, expected, **keys):
    """The log has all of its samples, and no number was lost."""
    log = rivid.read_log(source, robot, **keys)
    assert np.array_equal(rivid.identify(robot, log, METHOD).chi, expected)
    return log


NAMES = ("t", "q1", "q2", "tau1", "tau2")


@pytest.fixture(scope="module")
def table(series):
    return dict(zip(NAMES, np.column_stack([series["t"], series["q"], series["tau"]]).T))


def test_npz(robot, series, table, expected, tmp_path):
    np.savez(tmp_path / "run.npz", **series)
    assert_same(robot, tmp_path / "run.npz", expected)
    np.savez_compressed(tmp_path / "columns.npz", **table)
    assert_same(robot, tmp_path / "columns.npz", expected)


def test_npy(robot, table, expected, tmp_path):
    rows = np.rec.fromarrays(list(table.values()), names=list(table))
    np.save(tmp_path / "run.npy", rows)
    assert_same(robot, tmp_path / "run.npy", expected)
    np.save(tmp_path / "nameless.npy", np.zeros((4, 5)))
    with pytest.raises(rivid.InputError, match="without names of columns"):
        rivid.read_log(tmp_path / "nameless.npy", robot)


def test_mat_v5_with_nested_structs(robot, series, expected, tmp_path):
    io = pytest.importorskip("scipy.io")
    io.savemat(tmp_path / "run.mat", {"log": {"joint": {"q": series["q"], "tau": series["tau"]}, "t": series["t"]}})
    log = assert_same(robot, tmp_path / "run.mat", expected)
    assert any("position taken from log.joint.q1" in note for note in log.notes)
    # One column a sample, as some write it.
    io.savemat(tmp_path / "turned.mat", {"q": series["q"].T, "tau": series["tau"].T, "t": series["t"][None]})
    assert_same(robot, tmp_path / "turned.mat", expected)


def test_mat_v73(robot, series, expected, tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("log")
        # MATLAB stores by columns: HDF5 has its matrices turned.
        for name in ("q", "tau"):
            group.create_dataset(name, data=series[name].T).attrs["MATLAB_class"] = np.bytes_("double")
        group.create_dataset("t", data=series["t"][None]).attrs["MATLAB_class"] = np.bytes_("double")
        text = file.create_dataset("robot", data=np.array([[ord(c)] for c in "scara"], dtype=np.uint16))
        text.attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    assert_same(robot, path, expected)


@pytest.mark.parametrize("name", ["run.parquet", "run.feather"])
def test_parquet_and_feather(robot, table, expected, tmp_path, name):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    frame = pandas.DataFrame(table)
    if name == "run.parquet":
        frame.to_parquet(tmp_path / name)
    else:
        frame.to_feather(tmp_path / name)
    assert_same(robot, tmp_path / name, expected)


def test_lerobot_lists_in_parquet(robot, series, expected, tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = {
        "timestamp": series["t"],
        "observation.state": list(series["q"]),
        "observation.effort": list(series["tau"]),
        "action": list(series["q"]),
    }
    parquet.write_table(pyarrow.table(rows), tmp_path / "episode.parquet")
    log = assert_same(robot, tmp_path / "episode.parquet", expected)
    assert np.array_equal(log.q_r, series["q"])


def test_frames_in_memory(robot, table, expected):
    pandas, polars, pyarrow = map(pytest.importorskip, ("pandas", "polars", "pyarrow"))
    by_time = pandas.DataFrame(table).set_index("t")
    for frame in (pandas.DataFrame(table), by_time, polars.DataFrame(table), pyarrow.table(table), table):
        assert_same(robot, frame, expected)


@pytest.mark.parametrize(
    ("positions", "torques"),
    [
        (["actual_q_0", "actual_q_1"], ["target_moment_0", "actual_moment_1"]),
        (["qpos0", "qpos1"], ["qfrc_actuator0", "qfrc_actuator1"]),
        (["/joint_states/joint_1/position", "/joint_states/joint_2/position"],
         ["/joint_states/joint_1/effort", "/joint_states/joint_2/effort"]),
        (["q_0", "q_1"], ["tau_J_0", "tau_J_1"]),
        (["observation.state.0", "observation.state.1"], ["observation.effort.0", "observation.effort.1"]),
    ],
)
def test_names_of_robots_and_programs(robot, table, expected, positions, torques):
    if torques[0] == "target_moment_0":  # UR's real-time interface
        torques = ["actual_moment_0", "actual_moment_1"]
    named = dict(zip(["timestamp", *positions, *torques], table.values()))
    assert_same(robot, named, expected)


@pytest.mark.parametrize("clock", ["t", "time", "timestamp"])
def test_joints_that_are_counted_from_0(robot, table, expected, clock, tmp_path):
    """q1 is the second of them, and no default name."""
    named = dict(zip([clock, "q0", "q1", "tau0", "tau1"], table.values()))
    log = assert_same(robot, named, expected)
    assert any("position taken from q0 to q1" in note for note in log.notes)
    np.savetxt(tmp_path / "run.csv", np.column_stack(list(named.values())), delimiter=",", header=",".join(named), comments="")
    assert len(rivid.read_log(tmp_path / "run.csv", robot)) == len(log)


@pytest.mark.parametrize("names", [["AxisAct.A1", "AxisAct.A2"], ["AxisActReal.A1", "AxisActReal.A2"], ["rax_1", "rax_2"]])
def test_positions_in_degrees(robot, table, names):
    degrees = {"time": table["t"], names[0]: np.degrees(table["q1"]), names[1]: np.degrees(table["q2"]),
               "torque_1": table["tau1"], "torque_2": table["tau2"]}
    log = rivid.read_log(degrees, robot)
    assert np.allclose(log.q[:, 1], table["q2"], rtol=0, atol=1e-15 * 200)
    assert np.array_equal(log.tau[:, 0], table["tau1"])


def test_seconds_and_nanoseconds(robot, table, expected, tmp_path):
    nanoseconds = np.round(table["t"] * 1e9).astype(np.int64) + 1_700_000_000 * 10**9
    stamped = {"header.stamp.sec": nanoseconds // 10**9, "header.stamp.nanosec": nanoseconds % 10**9}
    rest = {name: table[name] for name in NAMES[1:]}
    for times in (stamped, {"timestamp": nanoseconds}):
        log = rivid.read_log({**times, **rest}, robot)
        assert np.allclose(log.t, table["t"] - table["t"][0], rtol=0, atol=1e-9)
        assert len(log) == len(table["t"])


def test_iso_time_stamps(robot, table):
    pandas = pytest.importorskip("pandas")
    start = datetime.datetime(2024, 5, 6, 7, 8, 9)
    times = [(start + datetime.timedelta(seconds=t)).isoformat() for t in table["t"].tolist()]
    frame = pandas.DataFrame({"time": times, **{name: table[name] for name in NAMES[1:]}})
    log = rivid.read_log(frame, robot)
    assert np.allclose(log.t, table["t"] - table["t"][0], rtol=0, atol=1e-6)
    frame["time"] = pandas.to_datetime(frame["time"], format="ISO8601")
    assert np.array_equal(rivid.read_log(frame, robot).t, log.t)


def test_empty_cells_of_merged_topics(robot, table, expected):
    """Torques that come between the positions."""
    n = len(table["t"])
    t = np.repeat(table["t"], 2)
    t[1::2] += 0.4 * (table["t"][1] - table["t"][0])
    merged = {name: np.full(2 * n, np.nan) for name in NAMES[1:]}
    for name in ("q1", "q2"):
        merged[name][::2] = table[name]
    for name in ("tau1", "tau2"):
        merged[name][1::2] = table[name]
    log = rivid.read_log({"t": t, **merged}, robot)
    assert len(log) == n - 1  # the first positions are before any torque
    assert np.array_equal(log.q[:, 0], table["q1"][1:])
    between = 0.4 * table["tau1"][:-1] + 0.6 * table["tau1"][1:]
    assert np.allclose(log.tau[:, 0], between, rtol=0, atol=1e-9 * np.abs(between).max())
    assert any("empty cells" in note for note in log.notes)


def written(path, header, columns):
    """A CSV file of these columns, words or numbers, the empty ones NaN."""
    def cell(value):
        return value if isinstance(value, str) else "" if np.isnan(value) else str(value)

    rows = [header, *zip(*(map(cell, np.asarray(column).tolist()) for column in columns))]
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    return path


def test_csv_with_dates(robot, table, tmp_path):
    start = datetime.datetime(2024, 5, 6, 23, 59, 58)
    times = [(start + datetime.timedelta(seconds=t)).isoformat(timespec="microseconds") for t in table["t"].tolist()]
    rest = [table[name] for name in NAMES[1:]]
    for ending in ("", "Z", "+02:00", "-0930", " +02"):
        path = written(tmp_path / "run.csv", ["timestamp", *NAMES[1:]], [[t + ending for t in times], *rest])
        log = rivid.read_log(path, robot)
        assert np.allclose(log.t - log.t[0], table["t"] - table["t"][0], rtol=0, atol=1e-6), ending
        assert np.array_equal(log.q[:, 0], table["q1"])
    # The clocks go back within the log.
    turned = [t + ("+02:00" if k < 100 else "+01:00") for k, t in enumerate(times)]
    turned[100:] = [t.replace("T", " ").replace(".", ",") for t in turned[100:]]
    path = written(tmp_path / "turned.csv", ["timestamp", *NAMES[1:]], [[f'"{t}"' for t in turned], *rest])
    with_gap = rivid.read_logs(path, robot, irregular="resample")
    assert len(with_gap) == 2 and len(with_gap[0]) == 100
    assert len(with_gap[1]) == pytest.approx(len(times) - 100, abs=1)  # on a clock of its own


def test_csv_with_seconds_and_nanoseconds(robot, table, tmp_path, program):
    nanoseconds = np.round(table["t"] * 1e9).astype(np.int64) + 1_700_000_000 * 10**9
    header = ["header.stamp.sec", "header.stamp.nanosec", *NAMES[1:]]
    path = written(tmp_path / "run.csv", header, [nanoseconds // 10**9, nanoseconds % 10**9, *(table[n] for n in NAMES[1:])])
    log = rivid.read_log(path, robot)
    assert np.allclose(log.t - log.t[0], table["t"] - table["t"][0], rtol=0, atol=1e-9)
    assert program("convert", path, tmp_path / "plain.csv").returncode == 0
    assert np.allclose(rivid.read_log(tmp_path / "plain.csv", robot).t, table["t"] - table["t"][0], rtol=0, atol=1e-9)


def test_csv_with_empty_cells(robot, table, tmp_path, program):
    n = len(table["t"])
    t = np.repeat(table["t"], 2)
    t[1::2] += 0.4 * (table["t"][1] - table["t"][0])
    columns = [t]
    for name in NAMES[1:]:
        columns.append(np.full(2 * n, np.nan))
        columns[-1][(0 if name[0] == "q" else 1)::2] = table[name]
    path = written(tmp_path / "merged.csv", list(NAMES), columns)
    log = rivid.read_log(path, robot)
    assert len(log) == n - 1
    assert np.array_equal(log.q[:, 0], table["q1"][1:])
    assert any("empty cells" in note for note in log.notes)
    assert program("convert", path, tmp_path / "plain.csv").returncode == 0
    assert np.array_equal(rivid.read_log(tmp_path / "plain.csv", robot).tau, log.tau)


def test_csv_that_is_wrong_otherwise_is_refused_as_by_the_tools(robot, table, tmp_path):
    path = written(tmp_path / "run.csv", list(NAMES), table.values())
    lines = path.read_text().split("\n")
    lines[5] = lines[5].replace(lines[5].split(",")[1], "x", 1)
    path.write_text("\n".join(lines))
    with pytest.raises(rivid.InputError, match=r"run.csv:6:2: column \"q1\" holds \"x\""):
        rivid.read_log(path, robot)
    path.write_text("t,q1,q2\n0,1\n")
    with pytest.raises(rivid.InputError, match="run.csv:2: the line has 2 fields"):
        rivid.read_log(path, robot)


def test_no_torque_is_invented_over_a_long_gap(robot, table):
    gap = {name: values.copy() for name, values in table.items()}
    for name in ("tau1", "tau2"):
        gap[name][500:700] = np.nan
    logs = rivid.read_logs(gap, robot, irregular="resample")
    assert [len(log) for log in logs] == [500, len(table["t"]) - 700]


def test_columns_that_are_missing_or_no_numbers(robot, table):
    with pytest.raises(rivid.InputError, match=r"no column 'q9'.*'tau1'"):
        rivid.read_log(table, robot, position=["q1", "q9"], torque=["tau1", "tau2"])
    words = {**table, "tau1": np.array(["x"] * len(table["t"]))}
    with pytest.raises(rivid.InputError, match=r"'tau1' holds .*must hold numbers"):
        rivid.read_log(words, robot, position=["q1", "q2"], torque=["tau1", "tau2"])
    with pytest.raises(rivid.InputError, match="position"):
        rivid.read_log({"t": table["t"], "x": table["q1"]}, robot)
    with pytest.raises(TypeError, match="DataFrame"):
        rivid.read_log(3.0, robot)


def test_units_and_signs_are_those_of_experiment_files(robot, table, expected):
    turned = {**table, "q2": -np.degrees(table["q2"]), "q1": np.degrees(table["q1"])}
    keys = {"position": ["q1", {"column": "q2", "sign": -1}], "torque": ["tau1", "tau2"], "units": {"position": "deg"}}
    chi = rivid.identify(robot, rivid.read_log(turned, robot, **keys), METHOD).chi
    assert np.allclose(chi, expected, rtol=1e-9)
    with pytest.raises(rivid.InputError, match=r"\[log\.units\] position: .*\"dge\""):
        rivid.read_log(turned, robot, position=["q1", "q2"], torque=["tau1", "tau2"], units={"position": "dge"})


# Bags
# --------------------------------------------------------------------------------------------------------------

CONTROLLER_STATE = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
trajectory_msgs/JointTrajectoryPoint error
trajectory_msgs/JointTrajectoryPoint output
"""
TYPE = "control_msgs/msg/JointTrajectoryControllerState"


def write_bag(path, t, q, tau, *, mcap, reference=None, order=(0, 1), controller_offset=0.0):
    """A bag of JointState messages, and of a controller's where there is a reference."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(CONTROLLER_STATE, TYPE))
    types = store.types
    Header, Time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    Point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    names = [f"joint_{j + 1}" for j in order]
    nothing = np.zeros(0)

    def header(at):
        ns = round(at * 1e9) + 1_700_000_000 * 10**9
        return Header(stamp=Time(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""), ns

    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        states = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        controller = writer.add_connection("/arm_controller/controller_state", TYPE, typestore=store)
        for k in range(len(t)):
            head, ns = header(t[k])
            message = types["sensor_msgs/msg/JointState"](
                header=head, name=names, position=q[k, order], velocity=nothing, effort=tau[k, order]
            )
            # Recorded late and in bursts: the stamps of the headers count.
            recorded = ns - ns % 10**7 + 10**7
            writer.write(states, recorded, store.serialize_cdr(message, message.__msgtype__))
            if reference is not None:
                head, _ = header(t[k] + controller_offset)
                empty = Point(nothing, nothing, nothing, nothing, types["builtin_interfaces/msg/Duration"](0, 0))
                wanted = Point(reference[k, order], nothing, nothing, nothing, empty.time_from_start)
                message = types[TYPE](head, names, wanted, empty, empty, empty)
                writer.write(controller, recorded, store.serialize_cdr(message, TYPE))
    return next(Path(path).glob("*.mcap" if mcap else "*.db3"))


@pytest.mark.parametrize("mcap", [True, False])
def test_bags(robot, series, expected, tmp_path, mcap):
    file = write_bag(tmp_path / "bag", series["t"], series["q"], series["tau"], mcap=mcap, order=[1, 0])
    for source in (file, tmp_path / "bag"):
        log = rivid.read_log(source, robot)
        assert np.array_equal(log.q, series["q"])
        assert np.array_equal(log.tau, series["tau"])
        assert np.allclose(log.t, series["t"] - series["t"][0], rtol=0, atol=1e-9)
    # Stamps are rounded to nanoseconds.
    assert np.allclose(rivid.identify(robot, log, METHOD).chi, expected, rtol=1e-5)


def test_the_reference_of_a_controller_is_joined_by_stamps(robot, series, tmp_path):
    period = series["t"][1] - series["t"][0]
    file = write_bag(
        tmp_path / "bag", series["t"], series["q"], series["tau"], mcap=True,
        reference=series["q"] + 1.0, controller_offset=0.5 * period,
    )
    log = rivid.read_log(file, robot)
    between = 1.0 + 0.5 * (series["q"][:-1] + series["q"][1:])
    assert np.allclose(log.q_r, between, rtol=0, atol=1e-6)
    assert np.array_equal(log.q, series["q"][1:])


def test_a_bag_without_joints_says_what_it_holds(robot, tmp_path):
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(tmp_path / "bag", version=9) as writer:
        connection = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=store)
        message = store.types["std_msgs/msg/String"]("hello")
        writer.write(connection, 1, store.serialize_cdr(message, "std_msgs/msg/String"))
    with pytest.raises(rivid.InputError, match=r"neither JointState .*/chatter \(std_msgs/msg/String\)"):
        rivid.read_log(tmp_path / "bag", robot)


# Files that can not be read
# ------------------------------------------------------------------------------------------


def damaged_files(folder, series, table):
    """A file of each format, by its name."""
    pandas = pytest.importorskip("pandas")
    io = pytest.importorskip("scipy.io")
    h5py = pytest.importorskip("h5py")
    np.savez(folder / "run.npz", **series)
    np.save(folder / "run.npy", np.rec.fromarrays(list(table.values()), names=list(table)))
    io.savemat(folder / "run5.mat", series)
    with h5py.File(folder / "run73.mat", "w") as file:
        for name, values in series.items():
            file.create_dataset(name, data=values)
    frame = pandas.DataFrame(table)
    frame.to_parquet(folder / "run.parquet")
    frame.to_feather(folder / "run.feather")
    write_bag(folder / "mcap", series["t"][:50], series["q"][:50], series["tau"][:50], mcap=True).rename(folder / "run.mcap")
    write_bag(folder / "db3", series["t"][:50], series["q"][:50], series["tau"][:50], mcap=False).rename(folder / "run.db3")
    return [path for path in folder.iterdir() if path.is_file()]


def test_damaged_files_are_refused_by_name(robot, series, table, tmp_path):
    files = damaged_files(tmp_path, series, table)
    assert len(files) == 8
    for file in files:
        whole = file.read_bytes()
        for part in (len(whole) // 2, 40):
            file.write_bytes(whole[:part])
            with pytest.raises(rivid.InputError, match=re.escape(file.name)):
                rivid.read_log(file, robot)


# rivid convert
# -------------------------------------------------------------------------------------------------------


def test_convert_writes_what_the_tools_read(robot, series, expected, scara, tool, program, tmp_path):
    file = write_bag(tmp_path / "bag", series["t"], series["q"], series["tau"], mcap=True)
    done = program("convert", file, tmp_path / "run.csv")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "run.csv").open() as text:
        assert next(csv.reader(text)) == [
            "t", "joint_1/position", "joint_2/position", "joint_1/effort", "joint_2/effort"
        ]
    assert np.array_equal(rivid.read_log(tmp_path / "run.csv", robot).q, series["q"])
    tool("rivid_identify", "init", scara / "scara.urdf", tmp_path / "run.csv", "--output", tmp_path / "new.toml")
    tool("rivid_identify", tmp_path / "new.toml", "--output", tmp_path / "result", "--quiet")
    assert json.loads((tmp_path / "result" / "result.json").read_text())["status"] == "identified"


def test_convert_lists_what_a_file_holds(series, program, tmp_path):
    file = write_bag(tmp_path / "bag", series["t"][:20], series["q"][:20], series["tau"][:20], mcap=False)
    done = program("convert", file, "--list")
    assert done.returncode == 0, done.stderr
    assert "/joint_states  sensor_msgs/msg/JointState, 20 messages: joint_1, joint_2" in done.stdout
    np.savez(tmp_path / "run.npz", **series)
    assert "q  float64" in program("convert", tmp_path / "run.npz", "--list").stdout


def test_convert_refuses_what_it_can_not_read(program, scara, tmp_path):
    refused = program("convert", scara / "scara_s2.csv", tmp_path / "out.csv")
    assert refused.returncode == 2
    assert "is text" in refused.stderr
    assert program("convert", tmp_path / "missing.mcap", tmp_path / "out.csv").returncode == 2
    assert not (tmp_path / "out.csv").exists()
    merged = tmp_path / "merged.csv"
    merged.write_text("t,q1\n0,1\n1,\n2,3\n")
    for target, words in ((merged, "is an input of this run"), (scara / "scara.toml", "is no .csv file")):
        refused = program("convert", merged, target)
        assert refused.returncode == 2
        assert words in refused.stderr
    assert merged.read_text() == "t,q1\n0,1\n1,\n2,3\n"


def test_convert_replaces_a_table_of_others_by_force_alone(program, tmp_path):
    merged, target = tmp_path / "merged.csv", tmp_path / "run.csv"
    merged.write_text("t,q1\n0,1\n1,\n2,3\n")
    for _ in range(2):
        assert program("convert", merged, target).returncode == 0
    converted = target.read_text()
    target.write_text("mine")
    refused = program("convert", merged, target)
    assert refused.returncode == 2
    assert "run.csv: is there already, with another content" in refused.stderr
    assert target.read_text() == "mine"
    assert program("convert", merged, target, "--force").returncode == 0
    assert target.read_text() == converted


def test_the_tools_name_the_command(series, tool, scara, tmp_path):
    file = write_bag(tmp_path / "bag", series["t"][:20], series["q"][:20], series["tau"][:20], mcap=True)
    said = tool("rivid_identify", "init", scara / "scara.urdf", file, "--output", tmp_path / "new.toml", code=2).stderr
    assert f"rivid convert {file} {file.with_suffix('.csv')}" in said
    assert not (tmp_path / "new.toml").exists()
