"""h5 keypoint files of DeepLabCut and SLEAP, and hostile ones: nothing is unpickled."""

from __future__ import annotations

import contextlib
import pickle
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_keypoints_files import make_trial

from bluekoi.data import BODY_PART_NAMES
from bluekoi.errors import InputError
from bluekoi.keypoints import deeplabcut, sleap
from bluekoi.keypoints.files.pickle_literals import NotLiteral, parse_literal
from keypoint_files import read_all_parts


@pytest.mark.parametrize("content", [b"", b"\x89HDF\r\n\x1a\n" + b"\0" * 90, b"scorer\n"])
def test_damaged_h5_is_a_fault(tmp_path, content):
    path = tmp_path / "k.h5"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"k\.h5"):
        deeplabcut.read_keypoints_of_trial(path, make_trial())


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("k.csv", b"\x89HDF\r\n\x1a\n" + bytes(90), "found an HDF5 file.*ending .h5"),
        ("k.csv", b"PK\x03\x04" + bytes(90), "found a workbook.*Save it as CSV UTF-8"),
        ("k.h5", b"PK\x03\x04" + bytes(90), "found a workbook.*ending must be that"),
        ("k.h5", b"scorer,net\n", "found text, as in a csv file.*ending must be that"),
    ],
)
def test_a_file_with_the_ending_of_another_format_is_recognised(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=words):
        deeplabcut.read_keypoints_of_trial(tmp_path / name, make_trial())


def write_fixed_h5(path: Path, **changes) -> Path:
    """A DataFrame in pandas' fixed format, as DeepLabCut's older files are."""
    names = {
        "scorer": ["s"],
        "bodyparts": list(BODY_PART_NAMES),
        "coords": ["x", "y", "likelihood"],
    }
    codes = {
        "scorer": np.zeros(15), "bodyparts": np.repeat(np.arange(5), 3),
        "coords": np.tile(np.arange(3), 5),
    }  # fmt: skip
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.attrs.update({"pandas_type": "frame", "nblocks": 1, "block0_items_nlevels": 3})
        for k, level in enumerate(names):
            group[f"block0_items_level{k}"] = np.array(names[level], dtype="S")
            group[f"block0_items_label{k}"] = codes[level].astype(np.int8)
        group["block0_values"] = changes.get("values", np.full((6, 15), 0.5))
        group["axis1"] = np.arange(6)
        for name, item in changes.get("more", {}).items():
            del group[name]
            group[name] = item
    return path


def test_fixed_h5(tmp_path):
    values = np.arange(90, dtype=float).reshape(6, 15)
    values[:, 2::3] = 0.5
    found = deeplabcut.read_keypoints_of_trial(
        write_fixed_h5(tmp_path / "k.h5", values=values), make_trial()
    )
    assert found.names == BODY_PART_NAMES
    assert found.xy_px[2, 1] == pytest.approx(values[2, 3:5])


def test_an_h5_without_a_frame_is_refused(tmp_path):
    empty = {"axis1": np.arange(0)}
    path = write_fixed_h5(tmp_path / "k.h5", values=np.zeros((1, 0)), more=empty)
    with pytest.raises(InputError, match=r"k\.h5: found a file without a single frame"):
        deeplabcut.read_keypoints_of_trial(path, make_trial())


def test_links_out_of_an_h5_are_refused(tmp_path):
    link = h5py.ExternalLink("/etc/other.h5", "/values")
    path = write_fixed_h5(tmp_path / "k.h5", more={"block0_values": link})
    with pytest.raises(InputError, match="link to elsewhere"):
        deeplabcut.read_keypoints_of_trial(path, make_trial())


class MaliciousPickle:
    def __reduce__(self):
        return (Path.touch, (Path("unpickled"),))


def write_table_h5(path: Path, names: bytes) -> Path:
    rows = np.zeros(4, dtype=[("index", "<i8"), ("values_block_0", "<f8", (15,))])
    rows["index"] = np.arange(4)
    rows["values_block_0"] = np.arange(15) / 20
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.attrs["pandas_type"] = "frame_table"
        group["table"] = rows
        group["table"].attrs["values_block_0_kind"] = np.bytes_(names)
    return path


@pytest.mark.parametrize("protocol", [0, 1, 2])
def test_column_names_of_a_table_are_read_not_unpickled(tmp_path, protocol, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = [("s", p, c) for p in BODY_PART_NAMES for c in ("x", "y", "likelihood")]
    good = write_table_h5(tmp_path / "k.h5", pickle.dumps(names, 0))
    assert deeplabcut.read_keypoints_of_trial(good, make_trial()).names == BODY_PART_NAMES
    bad = write_table_h5(tmp_path / "e.h5", pickle.dumps([*names[:-1], MaliciousPickle()], 0))
    with pytest.raises(InputError, match="no readable h5"):
        deeplabcut.read_keypoints_of_trial(bad, make_trial())
    with pytest.raises(NotLiteral):
        parse_literal(pickle.dumps(MaliciousPickle(), protocol))
    assert not (tmp_path / "unpickled").exists()


@given(
    st.recursive(
        st.one_of(st.text(max_size=9), st.integers(-(2**40), 2**40), st.booleans(), st.none()),
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.tuples(inner, inner)),
        max_leaves=12,
    ),
    st.integers(0, 5),
)
@settings(max_examples=60, deadline=None)
def test_literals_are_what_pickle_would_give(value, protocol):
    assert parse_literal(pickle.dumps(value, protocol)) == value


@pytest.mark.parametrize(
    "content",
    [
        b"(.",
        b"](a.",
        b"](\x85a.",
        b"X\x01\x00\x00\x00aX\x01\x00\x00\x00ba.",
        b"}K\x01(s.",
        b"(q\x00.",
    ],
)
def test_a_mark_or_a_step_out_of_place_is_no_literal(content):
    with pytest.raises(NotLiteral):
        parse_literal(content)


@given(st.binary(max_size=200))
@settings(max_examples=150, deadline=None)
def test_any_bytes_are_a_literal_or_refused(content):
    with contextlib.suppress(NotLiteral):
        assert isinstance(parse_literal(content), (str, int, float, list, tuple, dict, type(None)))


def write_sleap_h5(path: Path, tracks: int = 1) -> Path:
    values = np.arange(tracks * 2 * 5 * 7, dtype=float).reshape(tracks, 2, 5, 7)
    values[:1, :, 2, 3] = np.nan
    with h5py.File(path, "w") as file:
        file["tracks"] = values
        file["node_names"] = np.array(BODY_PART_NAMES, dtype="S")
        file["track_names"] = np.array([f"fish{i}" for i in range(tracks)], dtype="S")
        file["point_scores"] = np.full((tracks, 5, 7), 0.8)
    return path


def test_sleap_is_distinguished_from_deeplabcut(tmp_path):
    path = write_sleap_h5(tmp_path / "a.analysis.h5")
    found = deeplabcut.read_keypoints_of_trial(path, make_trial())
    assert found.names == BODY_PART_NAMES
    assert found.xy_px[4, 1] == pytest.approx([7 + 4, 35 + 7 + 4])
    assert found.likelihood[3, 2] == 0.0
    np.testing.assert_array_equal(
        sleap.read_keypoints_of_trial(path, make_trial()).xy_px, found.xy_px
    )


def test_sleap_of_two_tracks_takes_one_and_reports_it(tmp_path):
    found = deeplabcut.read_keypoints_of_trial(
        write_sleap_h5(tmp_path / "a.h5", tracks=2), make_trial()
    )
    assert any("fish" in remark for remark in found.remarks)


def test_sleap_without_a_track_is_reported(tmp_path):
    with pytest.raises(InputError, match="no tracked animal"):
        deeplabcut.read_keypoints_of_trial(
            write_sleap_h5(tmp_path / "a.h5", tracks=0), make_trial()
        )


@pytest.mark.recordings
def test_csv_and_h5_of_the_same_network_agree(recordings):
    folder = recordings / "openfield_mouse" / "predictions"
    stem = "m3v1mp4DLC_resnet50_openfieldAug20shuffle1_30000"
    a = read_all_parts(folder / f"{stem}.csv", 30.0)
    b = read_all_parts(folder / f"{stem}.h5", 30.0)
    assert a.names == b.names == ("snout", "leftear", "rightear", "tailbase")
    np.testing.assert_allclose(a.xy_px, b.xy_px)
