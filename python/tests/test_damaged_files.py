"""Files that are damaged, or made to do harm: each is an InputError that names it, or a log; none crashes, fills the memory or reads another file."""

import faulthandler
import importlib
import io
import os
import random
import struct
import subprocess
import sys
import time
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from test_formats import write_bag

import rivid
from rivid import formats
from rivid.formats import reader
from rivid.formats.columns import printable

N = 40
T = np.arange(N) * 0.01
SERIES = {"t": T, "q": np.column_stack([np.sin(T), np.cos(T)]), "tau": np.column_stack([T, -T])}
COLUMNS = dict(zip(("t", "q1", "q2", "tau1", "tau2"), np.column_stack(list(SERIES.values())).T))
ESCAPE = "\x1b]0;owned\x07"
LINES = "".join(f"{t},{t},{-t},1,2\n" for t in T.tolist())


# Files that libraries raise other errors at
# -------------------------------------------------------------------------


def npz(path, **arrays):
    np.savez(path, **arrays)
    return bytearray(path.read_bytes())


def encrypted_npz(path):
    data = npz(path, **COLUMNS)
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = data.find(mark)
        while at >= 0:
            data[at + flags] |= 1
            at = data.find(mark, at + 4)
    path.write_bytes(data)


def npz_of_another_packing(path):
    data = npz(path, **COLUMNS)
    data[data.find(b"PK\x01\x02") + 10] = 97
    path.write_bytes(data)


def damaged_npz(path):
    np.savez_compressed(path, **COLUMNS)
    data = bytearray(path.read_bytes())
    data[60:100] = bytes(range(40))
    path.write_bytes(data)


def npy_with_a_broken_header(path):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (3,\n"
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + bytes(24))


def mat(path, **variables):
    pytest.importorskip("scipy.io").savemat(path, variables)


def cell_array(path):
    cells = np.empty(N, dtype=object)
    cells[:] = [np.arange(k + 1.0) for k in range(N)]
    mat(path, time=cells, **SERIES)


def words_for_seconds(path):
    frame = pytest.importorskip("pandas").DataFrame({**COLUMNS, "stamp.sec": ["x"] * N, "stamp.nanosec": ["y"] * N})
    frame.drop(columns="t").to_parquet(path)


def mat_that_crashes_scipy(path):
    """The kind of the numbers is one that there is not."""
    mat(path, **SERIES)
    data = bytearray(path.read_bytes())
    data[177] = 1
    path.write_bytes(data)


def looping_db3(path):
    import sqlite3

    base = sqlite3.connect(path)
    base.executescript(
        "CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, data BLOB); CREATE TABLE topics(id INTEGER, name TEXT);"
        "CREATE VIEW schema AS WITH RECURSIVE c(schema_version) AS (SELECT 0 UNION ALL SELECT schema_version + 1 FROM c)"
        " SELECT schema_version FROM c WHERE schema_version < 0;"
    )
    base.close()


def text(content):
    return lambda path: path.write_bytes(content if isinstance(content, bytes) else content.encode())


UNREADABLE = {
    "header_in_latin_1.csv": text("t,q1,Gelenk ä,tau1,tau2\n".encode("latin-1") + b"0,1,2,x,4\n"),
    "dates_in_latin_1.csv": text("Zeit für t,q1\n2024-05-06T07:08:09,ä\n".encode("latin-1")),
    "quote_left_open.csv": text('t,q1,"q2\n' + LINES * 200),
    "quote_in_a_row.csv": text("t,q1,q2,tau1,tau2\n" + LINES + '0.9,"' + "1,2,\n" * 50_000),
    "nulls.csv": text("t,q1,q2\0,tau1,tau2\n0,1,,2\0,3\n"),
    "nothing.csv": text(""),
    "comments.csv": text("# a\n# b\n"),
    "header.csv": text("t,q1,q2,tau1,tau2\n"),
    "utf16.csv": text(("t,q1,q2,tau1,tau2\n" + LINES).encode("utf-16")),
    "encrypted.npz": encrypted_npz,
    "packed.npz": npz_of_another_packing,
    "damaged.npz": damaged_npz,
    "words.npz": lambda path: np.savez(path, t=np.array(["a", "b"])),
    "objects.npz": lambda path: np.savez(path, t=np.array([1, None])),
    "spreadsheet.npz": lambda path: zipfile.ZipFile(path, "w").writestr("sheet.xml", "<xml/>"),
    "header.npy": npy_with_a_broken_header,
    "cells.mat": lambda path: mat(path, q=np.array([[1.0], ["x"]], dtype=object), t=np.array([[np.eye(2)], [np.eye(3)]], dtype=object)),
    "crash.mat": mat_that_crashes_scipy,
    "looping.db3": looping_db3,
}


def written(folder, name):
    (UNREADABLE[name])(folder / name)
    return folder / name


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_can_not_be_read_is_refused_by_name(robot, tmp_path, monkeypatch, name):
    path = written(tmp_path, name)
    monkeypatch.setattr(formats, "_SECONDS", (2, 10))
    with pytest.raises(rivid.InputError, match=name.replace(".", r"\.")):
        rivid.read_logs(path, robot)


@pytest.mark.parametrize("name", ["quote_left_open.csv", "encrypted.npz", "crash.mat"])
def test_rivid_convert_says_so_in_one_line(program, tmp_path, name):
    done = program("convert", written(tmp_path, name), tmp_path / "out.csv")
    assert done.returncode == 2
    assert done.stderr.startswith("rivid: error: ") and done.stderr.count("\n") == 1


@pytest.mark.parametrize(("name", "write"), [("cells.mat", cell_array), ("seconds.parquet", words_for_seconds)])
def test_columns_of_words_and_cells_do_not_hide_the_log(robot, tmp_path, name, write):
    write(tmp_path / name)
    keys = {"rate_hz": 100.0} if name == "seconds.parquet" else {}
    assert np.array_equal(rivid.read_log(tmp_path / name, robot, **keys).q, SERIES["q"])


def test_a_header_in_latin_1_hides_no_log(robot, tmp_path):
    (tmp_path / "run.csv").write_bytes("t,q1,q2,tau1,tau2,Temp °C\n".encode("latin-1") + LINES.replace("\n", ",20\n").encode())
    assert len(rivid.read_log(tmp_path / "run.csv", robot)) == N


# Files that unpack to more than they say
# ----------------------------------------------------------------------------


def npz_bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("q.npy", "w", force_zip64=True) as member:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (12 << 20,)})
        member.write(head.getvalue())
        for _ in range(96):
            member.write(bytes(1 << 20))


def hdf5(path, fill):
    with pytest.importorskip("h5py").File(path, "w") as file:
        fill(file)


def hdf5_bomb(path):
    hdf5(path, lambda file: file.create_dataset("q", shape=(12 << 20,), dtype="f8", chunks=(1 << 17,)))


def filter_bomb(path):
    """A chunk whose compressed bytes unpack to more than the chunk has."""

    def fill(file):
        series = file.create_dataset("q", shape=(1000,), dtype="f8", chunks=(1000,), compression="gzip")
        packed = zlib.compressobj()
        series.id.write_direct_chunk((0,), b"".join(packed.compress(bytes(1 << 20)) for _ in range(96)) + packed.flush())

    hdf5(path, fill)


def parquet_bomb(path):
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    piece = arrow.table({"q": np.zeros(1 << 20)})
    with parquet.ParquetWriter(path, piece.schema, compression="zstd") as writer:
        for _ in range(12):
            writer.write_table(piece)


def mat_bomb(path):
    pytest.importorskip("scipy.io").savemat(path, {"q": np.zeros((12 << 20, 1))}, do_compression=True)


def mcap_bomb(packing, packed):
    """One chunk of a bag that says it has 8 bytes."""

    def write(path):
        if path.exists():
            return
        def string(x):
            return struct.pack("<I", len(x)) + x

        def record(op, content):
            return bytes([op]) + struct.pack("<Q", len(content)) + content

        magic = b"\x89MCAP0\r\n"
        schema = record(3, struct.pack("<H", 1) + string(b"sensor_msgs/msg/JointState") + string(b"") + string(b""))
        channel = record(4, struct.pack("<HH", 1, 1) + string(b"/joint_states") + string(b"cdr") + string(b""))
        chunk = record(6, struct.pack("<QQQI", 0, 9, 8, 0) + string(packing) + struct.pack("<Q", len(packed())) + packed())
        start = magic + record(1, string(b"ros2") + string(b""))
        index = record(8, struct.pack("<QQQQ", 0, 9, len(start), len(chunk)) + string(struct.pack("<HQ", 1, len(start + chunk))) + struct.pack("<Q", 31) + string(packing)
                       + struct.pack("<QQ", len(packed()), 8))
        statistics = record(11, struct.pack("<QHIIIIQQ", 1, 1, 1, 0, 0, 1, 0, 9) + string(struct.pack("<HQ", 1, 1)))
        summary = len(start + chunk)
        end = record(2, struct.pack("<QQI", summary, 0, 0)) + magic
        path.write_bytes(start + chunk + schema + channel + index + statistics + end)

    return write


def zstd_bytes():
    return pytest.importorskip("pyarrow").compress(bytes(96 << 20), "zstd", asbytes=True)


def lz4_bytes():
    return pytest.importorskip("lz4.frame").compress(bytes(96 << 20))


BOMBS = {
    "bomb.npz": npz_bomb,
    "bomb.h5": hdf5_bomb,
    "filter.h5": filter_bomb,
    "bomb.parquet": parquet_bomb,
    "bomb.mat": mat_bomb,
    "zstd.mcap": mcap_bomb(b"zstd", zstd_bytes),
    "lz4.mcap": mcap_bomb(b"lz4", lz4_bytes),
}


@pytest.fixture
def limit():
    """Sets a limit for one test."""
    yield rivid.limit_inputs
    rivid.limit_inputs(16384)
    formats._most_mebibytes = 2048


@pytest.mark.parametrize("name", BOMBS)
def test_what_unpacks_to_more_than_the_limit_is_refused(robot, tmp_path, limit, name):
    path = tmp_path / name
    BOMBS[name](path)
    assert path.stat().st_size < 4 << 20
    limit(64)
    with pytest.raises(rivid.InputError, match=r"takes more than 64 MiB .*rivid\.limit_inputs" if "filter" not in name else name):
        rivid.read_logs(path, robot)


def test_the_limit_is_a_number_of_mebibytes(limit, program, tmp_path):
    for wrong in (0, -1, 1.5, "1", None, 2**42):
        with pytest.raises(rivid.InputError, match="limit_inputs: mebibytes is "):
            limit(wrong)
    hdf5_bomb(tmp_path / "bomb.h5")
    done = program("convert", tmp_path / "bomb.h5", tmp_path / "out.csv", "--max-size", "64")
    assert done.returncode == 2
    assert "takes more than 64 MiB" in done.stderr
    (tmp_path / "run.csv").write_bytes(b"t,q1\n" + b"0.123456789,0.123456789\n" * 100_000)
    limit(1)
    with pytest.raises(rivid.InputError, match=r"run\.csv: has more than 1 MiB"):
        rivid.Robot.from_urdf(tmp_path / "run.csv")


def test_paths_of_links_are_counted(robot, tmp_path):
    """2²⁴ of them in 29 kB."""

    def fill(file):
        group = file.create_group("g")
        for _ in range(24):
            below = group.create_group("a")
            group["b"] = below
            group = below

    hdf5(tmp_path / "links.h5", fill)
    with pytest.raises(rivid.InputError, match=r"links\.h5: has more than 10000 variables"):
        rivid.read_logs(tmp_path / "links.h5", robot)


def test_other_files_are_not_opened(robot, tmp_path):
    h5py = pytest.importorskip("h5py")
    hdf5(tmp_path / "other.h5", lambda file: file.update({"q": SERIES["q"]}))
    np.arange(N, dtype=float).tofile(tmp_path / "raw")

    def links(file):
        file["t"] = T
        file["q"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/q")
        file["by_way"] = h5py.SoftLink("/q")

    def virtual(file):
        layout = h5py.VirtualLayout(shape=(N, 2), dtype="f8")
        layout[:] = h5py.VirtualSource(tmp_path / "other.h5", "q", shape=(N, 2))
        file.create_virtual_dataset("q", layout)

    hdf5(tmp_path / "links.h5", links)
    assert list(formats.read(tmp_path / "links.h5")) == ["t"]
    hdf5(tmp_path / "virtual.h5", virtual)
    hdf5(tmp_path / "raw.h5", lambda file: file.create_dataset("q", (N,), "f8", external=[(str(tmp_path / "raw"), 0, 8 * N)]))
    for name in ("virtual.h5", "raw.h5"):
        with pytest.raises(rivid.InputError, match=rf"{name}: the numbers of /q are in other files"):
            rivid.read_logs(tmp_path / name, robot)


def test_names_of_files_do_not_reach_the_terminal_raw(robot, program, tmp_path):
    hdf5(tmp_path / "run.h5", lambda file: file.update({f"{name}{ESCAPE}\n": values for name, values in SERIES.items()}))
    np.savez(tmp_path / f"run{ESCAPE}.npz", **{f"{ESCAPE}x": T})
    named = pytest.importorskip("pandas").DataFrame({**COLUMNS, f"=cmd{ESCAPE}\r\n9,9": T})
    named.to_parquet(tmp_path / "run.parquet")
    assert program("convert", tmp_path / "run.parquet", tmp_path / "out.csv").returncode == 0
    head, *rows = (tmp_path / "out.csv").read_text().split("\n")
    assert head.endswith(',"=cmd?]0;owned???9,9"') and len(rows) == N + 1
    for path in tmp_path.iterdir():
        done = program("convert", path, "--list")
        assert "\x1b" not in done.stdout + done.stderr and "\x07" not in done.stdout + done.stderr
        with pytest.raises(rivid.InputError) as refused:
            rivid.read_logs(path, robot, position=[f"q{ESCAPE}1", "q2"])
        assert "\x1b" not in str(refused.value)


def test_a_reader_that_waits_for_ever_is_ended(tmp_path, monkeypatch):
    np.savez(tmp_path / "run.npz", **COLUMNS)
    monkeypatch.setattr(formats, "_PATIENCE", 1e-5)
    with pytest.raises(rivid.InputError, match=r"run\.npz: can not be read: it takes .* waits for ever"):
        formats.read(tmp_path / "run.npz")


def test_soft_limits_of_the_process_are_kept(tmp_path):
    """A process that is limited more strictly reads as well."""
    np.savez(tmp_path / "run.npz", **COLUMNS)
    code = f"import resource, rivid.formats, pathlib; resource.setrlimit(resource.RLIMIT_CPU, (50, 50)); print(len(rivid.formats.read(pathlib.Path({str(tmp_path / 'run.npz')!r}))))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "5\n"


# Arguments that are no files
# ----------------------------------------------------------------------------------------


def readers(robot, scara):
    """Functions of one argument, with the words that name it."""
    log = scara / "scara_s2.csv"
    return {
        "Robot.from_urdf: path": rivid.Robot.from_urdf,
        "Robot.from_mdh: table": rivid.Robot.from_mdh,
        "DynamicModel.from_result: path": rivid.DynamicModel.from_result,
        "OnlineModel.from_result: path": rivid.online.OnlineModel.from_result,
        "Experiment: path": rivid.Experiment,
        "Study: path": rivid.Study,
        "excite: path": rivid.excite,
        "simulate: robot": rivid.simulate,
        "identify: robot": lambda path: rivid.identify(path) if isinstance(path, (str, Path)) else rivid.identify(path, log),
        "draft: robot": lambda path: rivid.draft(path, log, "new.toml"),
        "draft: logs": lambda path: rivid.draft(scara / "scara.urdf", path, "new.toml"),
        "read_logs: source": lambda path: rivid.read_logs(path, robot),
        "identify_payloads: arm": lambda path: rivid.identify_payloads(robot, log, arm=path),
    }


def test_what_is_no_path_is_refused_by_the_name_of_the_argument(robot, scara):
    for what, read in readers(robot, scara).items():
        for wrong in (b"run.csv", 3.0, object()):
            with pytest.raises(TypeError) as refused:
                read(wrong)
            assert what in str(refused.value)
        for name in ("a\0b", "a\udce9b"):
            with pytest.raises(rivid.InputError, match="must be UTF-8 without null characters"):
                read(name)
    for call in (lambda: rivid.read_logs(scara / "scara_s2.csv", "robot"), lambda: rivid.check(None, scara / "scara_s2.csv")):
        with pytest.raises(TypeError, match="(read_logs|check): robot is (str|NoneType), must be Robot"):
            call()


def test_folders_devices_and_pipes_are_refused(robot, scara, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero"), tmp_path / "missing", Path()):
        for read in readers(robot, scara).values():
            with pytest.raises(rivid.InputError):
                read(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", "<robot name='ä'>".encode("latin-1"), b"\0" * 100, b"{" * 5000, b"[" * 5000 + b"\xe9"])
def test_other_content_is_refused(robot, scara, tmp_path, content):
    path = tmp_path / "file"
    path.write_bytes(content)
    for read in readers(robot, scara).values():
        with pytest.raises(rivid.InputError):
            read(path)


# Fuzzing
# ------------------------------------------------------------------------------------------------------------

FILES = int(os.environ.get("RIVID_FUZZ_FILES", "160"))
MOST_AT_ONCE = 100


def ros1_bag(path):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    with Writer(path) as writer:
        states = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for k in range(N):
            stamp = types["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=k * 10**7)
            head = types["std_msgs/msg/Header"](seq=k, stamp=stamp, frame_id="")
            message = types["sensor_msgs/msg/JointState"](head, ["joint_1", "joint_2"], SERIES["q"][k], np.zeros(0), SERIES["tau"][k])
            writer.write(states, 1_700_000_000 * 10**9 + k * 10**7, store.serialize_ros1(message, message.__msgtype__))


def seeds(folder):
    """A good file of each kind."""
    pandas, io_ = pytest.importorskip("pandas"), pytest.importorskip("scipy.io")
    np.savez(folder / "stored.npz", **SERIES)
    np.savez_compressed(folder / "packed.npz", **SERIES)
    np.save(folder / "run.npy", np.rec.fromarrays(list(COLUMNS.values()), names=list(COLUMNS)))
    io_.savemat(folder / "run.mat", SERIES)
    cells = np.array([1.0, "s", np.eye(2)], dtype=object)
    io_.savemat(folder / "nested.mat", {"log": {**SERIES, "name": "x", "cells": cells}}, do_compression=True)
    hdf5(folder / "run.h5", lambda file: file.update(SERIES))
    hdf5(folder / "packed.h5", lambda file: [file.create_dataset(f"log/{k}", data=v, compression="gzip", shuffle=True) for k, v in SERIES.items()])
    frame = pandas.DataFrame(COLUMNS)
    frame.to_parquet(folder / "run.parquet")
    frame.assign(x=[[1.0, 2.0]] * N).to_parquet(folder / "lists.parquet", compression="gzip")
    frame.to_feather(folder / "run.feather")
    frame.to_feather(folder / "packed.feather", compression="zstd")
    for name, mcap in (("run.mcap", True), ("run.db3", False)):
        write_bag(folder / f"{name}_", T, SERIES["q"], SERIES["tau"], mcap=mcap, reference=SERIES["q"]).rename(folder / name)
    ros1_bag(folder / "run.bag")
    (folder / "run.csv").write_text("t,q1,q2,tau1,tau2\n" + "".join(f"{t},{q1!r},{q2!r},1,2\n" for t, (q1, q2) in zip(T, SERIES["q"].tolist())))
    rows = zip(T, SERIES["q"].tolist(), ["1", ""] * N)
    dates = "".join(f'"2024-05-06T07:08:{9 + t:09.6f}+02:00",{q1!r},{q2!r},{tau},2\n' for t, (q1, q2), tau in rows)
    (folder / "dates.csv").write_text("time,q1,q2,tau1,tau2\n" + dates)
    return sorted(path for path in folder.iterdir() if path.is_file())


def mutated(rng, data):
    """The bytes with some of them changed, cut out, doubled, or replaced by counts that are too large."""
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        if not out:
            break
        at, other = rng.randrange(len(out)), rng.randrange(len(out))
        kind = rng.randrange(6)
        if kind == 0:
            out[at] = rng.randrange(256)
        elif kind == 1:
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 2:
            del out[at : at + rng.choice((1, 4, 64, 1000))]
        elif kind == 3:
            out[at:at] = out[other : other + rng.choice((1, 8, 64))]
        elif kind == 4:
            count = rng.choice((0, 1, 2**16, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**63 - 1, 2**64 - 1))
            size = rng.choice((4, 8)) if count < 2**32 else 8
            out[at : at + size] = count.to_bytes(size, rng.choice(("little", "big")))
        else:
            out[at : at + 16] = out[other : other + 16]
    return bytes(out)


def read_in_this_process(robot, folder, seed, numbers, answer):
    """Reads mutated files as read_logs does, but without a process for each; one line each to a pipe."""
    faulthandler.disable()
    confine = reader._confine
    reader._confine = lambda mebibytes, _: confine(mebibytes, int(time.process_time()) + 5)

    def answered(function, path):
        head, columns = reader._said(function, *formats.format_of(path), path, 1024, 0)
        if isinstance(head, str):
            raise rivid.InputError(printable(head))
        return head, memoryview(b"".join(np.ascontiguousarray(column).tobytes() for column in columns))

    formats._answer = answered
    data = seed.read_bytes()
    for number in numbers:
        os.write(answer, f"{number} ".encode())
        path = folder / f"{number}_{seed.name}"
        path.write_bytes(mutated(random.Random(f"{seed.name} {number}"), data))
        try:
            rivid.read_logs(path, robot)
            said = "log"
        except rivid.InputError as error:
            said = "InputError" if path.name in str(error) and printable(str(error)) == str(error) else f"names no file: {error}"
        except BaseException as error:
            said = f"{type(error).__name__}: {error}"
        os.write(answer, (said.replace("\n", " ")[:200] + "\n").encode(errors="replace"))
        path.unlink()


def test_mutated_files_are_logs_or_input_errors(robot, tmp_path, monkeypatch):
    """RIVID_FUZZ_FILES of all formats: 100000 are for the night. What ends a reader's process is read once more as users read it."""
    monkeypatch.setattr(formats, "_SECONDS", (5, 10))
    (tmp_path / "seeds").mkdir()
    originals = seeds(tmp_path / "seeds")
    assert all(np.array_equal(rivid.read_log(seed, robot).q[0], SERIES["q"][0]) for seed in originals)
    for seed in originals:
        importlib.import_module(formats.format_of(seed).module)  # once, not in each child
    counts, wrong = {}, []
    for seed in originals:
        number, most = 0, -(-FILES // len(originals))
        while number < most:
            get, put = os.pipe()
            child = os.fork()
            if child == 0:
                try:
                    read_in_this_process(robot, tmp_path, seed, range(number, min(number + MOST_AT_ONCE, most)), put)
                finally:
                    os._exit(0)
            os.close(put)
            with os.fdopen(get) as answer:
                lines = answer.read().split("\n")
            ended_by = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            for line in filter(None, lines):
                number, _, said = line.partition(" ")
                kind = said or f"signal {-ended_by}"
                counts[kind[:20]] = counts.get(kind[:20], 0) + 1
                if kind not in ("log", "InputError") and said:
                    wrong.append(f"{seed.name} {number}: {said}")
            if ended_by < 0:
                path = tmp_path / f"{number}_{seed.name}"
                try:
                    rivid.read_logs(path, robot)
                except rivid.InputError as error:
                    assert path.name in str(error)
            number = int(number) + 1
    print(counts)
    assert not wrong
    assert counts["log"] > 0 and counts["InputError"] > FILES // 4


# Names that are no UTF-8
# --------------------------------------------------------------------------------------------


def test_a_description_in_latin_1_is_a_robot_all_the_same(scara, tmp_path):
    text = (scara / "scara.urdf").read_bytes().replace(b'name="scara"', 'name="scärä"'.encode("latin-1"))
    (tmp_path / "scara.urdf").write_bytes(text)
    rivid.draft(tmp_path / "scara.urdf", scara / "scara_s2.csv", tmp_path / "new.toml")
    of_file = rivid.Experiment(tmp_path / "new.toml", {"signal.decimation": 20})
    for robot in (rivid.Robot.from_urdf(tmp_path / "scara.urdf"), of_file.robot):
        assert robot.name == "sc?r?"
    assert "sc?r?" in rivid.identify(of_file).to_html()
