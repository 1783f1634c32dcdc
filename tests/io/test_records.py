"""TDMS, LVM, WAV and miniSEED: rate, names, units; what does not belong together is refused."""

import struct

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import refused, unsuitable

RNG = np.random.default_rng(5)
ROWS = RNG.standard_normal((3, 400))


def same(read, rows=ROWS, fs_hz=512.0, tolerance=1e-12):
    assert read.fs_hz == fs_hz
    np.testing.assert_allclose(read.responses, rows, rtol=0, atol=tolerance * np.abs(rows).max())


def tdms(path, groups, start="2026-05-04T12:00:00"):
    """``groups``: {group: {channel: (values, properties)}}."""
    nptdms = pytest.importorskip("nptdms")
    begun = {"wf_start_time": np.datetime64(start)}
    with nptdms.TdmsWriter(path) as file:
        for group, channels in groups.items():
            rows = ((name, values, begun | more) for name, (values, more) in channels.items())
            file.write_segment([nptdms.ChannelObject(group, *row[:2], properties=row[2]) for row in rows])
    return path


def acc(fs_hz=512.0, **more):
    return {"wf_increment": 1.0 / fs_hz, "unit_string": "m/s2", **more}


def test_tdms_with_force_and_units(tmp_path, own_process):
    force = RNG.standard_normal(400)
    run = {"tip": (ROWS[0], acc()), "mid": (ROWS[1] / 9.80665, acc(unit_string="g"))}
    file = tdms(tmp_path / "a.tdms", {"run": run | {"hammer": (force, acc(unit_string="N"))}})
    read = ar.read_tdms(file)
    same(read, ROWS[:2])
    assert read.dofs == ("tip", "mid")
    np.testing.assert_array_equal(read.force, force)
    assert ar.read_tdms(file, responses="m*", dofs=[4]).dofs == (4,)
    slow = {"t": (ROWS[1][:40], acc(10.0))}
    same(ar.read_tdms(tdms(tmp_path / "b.tdms", {"fast": run, "slow": slow}), responses="fast/t*"), ROWS[:1])


def test_tdms_takes_the_rate_of_a_channel_of_time_or_asks_for_it(tmp_path):
    time = np.arange(400) / 512.0
    named = {"unit_string": "m/s2"}
    file = tdms(tmp_path / "a.tdms", {"run": {"Time": (time, {}), "a": (ROWS[0], named)}})
    same(ar.read_tdms(file), ROWS[:1])
    file = tdms(tmp_path / "b.tdms", {"run": {"a": (ROWS[0], named)}})
    same(ar.read_tdms(file, fs_hz=512.0), ROWS[:1])


@pytest.mark.parametrize("kept", [3, 30, 1000, -1])
def test_a_cut_tdms_file_is_refused(tmp_path, kept):
    file = tdms(tmp_path / "a.tdms", {"run": {"a": (ROWS[0], acc())}})
    file.write_bytes(file.read_bytes()[:kept])
    unsuitable("segment", ar.read_tdms, file)
    if kept > 1000 or kept < 0:
        with pytest.warns(ar.AntiresWarning, match="segment 1 is cut"):
            assert 2 < ar.read_tdms(file, partial=True).n_samples < 400


@pytest.mark.parametrize(
    ("dtype", "tolerance"), [("<i2", 1e-4), ("<i4", 1e-8), ("<f4", 1e-7), ("<f8", 1e-15), ("u1", 1e-2)]
)
def test_wav_of_every_form(tmp_path, dtype, tolerance):
    from scipy.io import wavfile

    rows = np.clip(ROWS[:2] / 4.0, -0.99, 0.99)
    if dtype == "u1":
        stored = np.round(rows * 128 + 128).astype(dtype)
    elif dtype[1] == "i":
        stored = np.round(rows * 2.0 ** (8 * np.dtype(dtype).itemsize - 1)).astype(dtype)
    else:
        stored = rows.astype(dtype)
    wavfile.write(tmp_path / "a.wav", 512, stored.T)
    read = ar.read_wav(tmp_path / "a.wav", unit="m/s2", full_scale=20.0)
    same(read, 20.0 * rows, tolerance=tolerance)
    assert read.dofs == ("channel 1", "channel 2")


def test_wav_of_24_bits_and_its_scale(tmp_path, own_process):
    rows = np.array([[0, 2**22, -(2**22), 1], [5, 6, 7, 8]])
    samples = b"".join(int(v).to_bytes(3, "little", signed=True) for v in rows.T.ravel())
    form = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 2, 512, 512 * 6, 6, 24)
    body = b"WAVE" + form + b"data" + struct.pack("<I", len(samples)) + samples
    (tmp_path / "a.wav").write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    read = ar.read_wav(tmp_path / "a.wav", unit="g", full_scale=[2.0, 1.0], dofs=[3, 7])
    same(read, 9.80665 * rows / 2.0**23 * [[2.0], [1.0]])
    force = ar.read_wav(tmp_path / "a.wav", unit="g", full_scale=100.0, force="channel 2").force
    np.testing.assert_allclose(force, 100.0 * rows[1] / 2.0**23)


def test_wav_without_a_unit_warns_and_a_wrong_scale_is_refused(tmp_path):
    from scipy.io import wavfile

    wavfile.write(tmp_path / "a.wav", 512, ROWS.T)
    with pytest.warns(ar.AntiresWarning, match="in which unit"):
        ar.read_wav(tmp_path / "a.wav")
    for wrong in (0.0, [1.0, 2.0], "much", np.nan):
        refused("full_scale: got", ar.read_wav, tmp_path / "a.wav", unit="g", full_scale=wrong)
    whole = (tmp_path / "a.wav").read_bytes()
    for kept in (2, 20, 60, len(whole) - 1):
        (tmp_path / "b.wav").write_bytes(whole[:kept])
        unsuitable("b.wav", ar.read_wav, tmp_path / "b.wav", unit="g")


def lvm(path, segments, columns="No", sign="\t", point=".", comment="", multi="Yes", x0=None, dates=None):
    """Write segments, (n_channels, n_samples) each, at 512 Hz, as LabVIEW does."""
    separator = {"\t": "Tab", ",": "Comma"}[sign]
    head = {"Writer_Version": 2, "Separator": separator, "Decimal_Separator": point, "Multi_Headings": multi}
    head |= {"X_Columns": columns, "Time_Pref": "Relative", "Date": "2026/05/04"}
    lines = ["LabVIEW Measurement" + sign, *(f"{name}{sign}{value}" for name, value in head.items())]
    lines += ["***End_of_Header***" + sign, sign]
    starts, times = x0 or [0.0] * len(segments), dates or ["12:00:00.0"] * len(segments)
    for number, (rows, start, time) in enumerate(zip(segments, starts, times, strict=True)):
        count, size = rows.shape
        if number == 0 or multi == "Yes":
            own = {"Samples": size, "Date": "2026/05/04", "Time": time, "Y_Unit_Label": "m/s^2"}
            own |= {"X_Dimension": "Time", "X0": start, "Delta_X": repr(1.0 / 512.0).replace(".", point)}
            lines.append(f"Channels{sign}{count}")
            lines += [sign.join([name, *[str(value)] * count]) for name, value in own.items()]
            lines.append("***End_of_Header***" + sign)
            names = [f"acc{i}" for i in range(count)]
            if columns == "Multi":
                names = [title for name in names for title in ("X_Value", name)]
            lines.append(sign.join([*["X_Value"] * (columns != "Multi"), *names, "Comment"]))
        for i in range(size):
            x = f"{i / 512.0 + start:.6f}"
            fields = [x if columns == "One" else "", *(repr(float(value)) for value in rows[:, i])]
            if columns == "Multi":
                fields = [field for value in fields[1:] for field in (x, value)]
            row = sign.join(field.replace(".", point) for field in fields)
            lines.append(row + f"{sign}{comment}" * (i == 0))
        lines.append("")
    path.write_text("\r\n".join([*lines, ""]), newline="")
    return path


@pytest.mark.parametrize("columns", ["No", "One", "Multi"])
@pytest.mark.parametrize(("sign", "point"), [("\t", "."), ("\t", ","), (",", ".")])
def test_lvm_of_every_form(tmp_path, columns, sign, point):
    read = ar.read_lvm(lvm(tmp_path / "a.lvm", [ROWS], columns, sign, point, comment="the first knock"))
    same(read)
    assert read.dofs == ("acc0", "acc1", "acc2")
    special = f"***Start_Special***\nBinaryData{sign}7\n***End_Special***\nChannels{sign}3"  # passed over
    file = tmp_path / "a.lvm"
    file.write_text(file.read_text().replace(f"Channels{sign}3", special))
    same(ar.read_lvm(file))


def test_lvm_segments_are_joined_or_chosen(tmp_path):
    parts, x0 = [ROWS[:, :150], ROWS[:, 150:]], [0.0, 150 / 512.0]
    same(ar.read_lvm(lvm(tmp_path / "a.lvm", parts, "One", x0=x0)))
    halves = [ROWS[:, :200], ROWS[:, 200:]]  # under one heading
    same(ar.read_lvm(lvm(tmp_path / "d.lvm", halves, "One", x0=[0.0, 200 / 512.0], multi="No")))
    same(ar.read_lvm(lvm(tmp_path / "b.lvm", parts, dates=["12:00:00.0", "12:00:00.29296875"])))
    hits = lvm(tmp_path / "c.lvm", parts, dates=["12:00:00", "12:00:20.5"])
    unsuitable(r"segment 2 of 2 .* begins \+20.21 s after", ar.read_lvm, hits)
    same(ar.read_lvm(hits, run=2), parts[1])
    for wrong in (0, 3, True, "1"):
        refused("run: got", ar.read_lvm, hits, run=wrong)


def test_a_cut_or_damaged_lvm_file_is_refused(tmp_path):
    lines = lvm(tmp_path / "a.lvm", [ROWS]).read_text().splitlines()
    row = lines.index(next(line for line in lines if line.startswith("X_Value"))) + 10
    file = tmp_path / "b.lvm"
    file.write_text("\n".join(lines[:row]) + "\n")
    unsuitable(r"'acc0' has 9 of 400 samples", ar.read_lvm, file)
    with pytest.warns(ar.AntiresWarning, match="9 of 400"):
        assert ar.read_lvm(file, partial=True).n_samples == 9
    for line, said in (
        ("\tone\ttwo\tthree", "float: 'one'"),
        ("\t\t1.0\t2.0", "'acc0' has what is no number"),
    ):
        file.write_text("\n".join([*lines[:row], line, *lines[row + 1 :]]) + "\n")
        unsuitable(said, ar.read_lvm, file)


def mseed(path, traces):
    """``traces``: (station, values, seconds after the start)."""
    obspy = pytest.importorskip("obspy")
    made = []
    for station, values, late in traces:
        trace = obspy.Trace(np.asarray(values, dtype=np.float64))
        trace.stats.update({"network": "XX", "station": station, "channel": "HNX", "sampling_rate": 512.0})
        trace.stats.starttime = obspy.UTCDateTime(2026, 5, 4) + late
        made.append(trace)
    obspy.Stream(made).write(str(path), format="MSEED")
    return path


def test_miniseed_joins_what_follows_and_refuses_gaps(tmp_path, own_process):
    file = mseed(tmp_path / "a.mseed", [("T1", ROWS[0], 0.0), ("T2", ROWS[1], 0.0005), ("T3", ROWS[2], 0.0)])
    read = ar.read_miniseed(file, unit="m/s2")
    same(read)
    assert read.dofs == ("XX.T1..HNX", "XX.T2..HNX", "XX.T3..HNX")
    with pytest.warns(ar.AntiresWarning, match="'counts'"):
        same(ar.read_miniseed(file, responses="*T2*"), ROWS[1:2])
    halves = [("T1", ROWS[0][:200], 0.0), ("T1", ROWS[0][200:], 200 / 512.0)]
    same(ar.read_miniseed(mseed(tmp_path / "b.mseed", halves), unit="m/s2"), ROWS[:1])
    for traces, said in (
        (
            [halves[0], ("T1", ROWS[0][200:], 3.0)],
            "1 gaps or overlaps, the first between 2026-05-04T00:00:00.38",
        ),
        ([("T1", ROWS[0], 0.0), ("T2", ROWS[1], 1.0)], "begin together"),
    ):
        unsuitable(said, ar.read_miniseed, mseed(tmp_path / "c.mseed", traces), unit="m/s2")
