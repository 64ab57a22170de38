"""Data sets from Python."""

import logging
import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

import tactus


@pytest.fixture(scope="module")
def folder(data_set):
    return data_set.folder


def test_a_data_set_is_made_once(two, data_set):
    assert data_set.report["computed"] == 10 and data_set.told[-1] == (30, 30), "frames"
    assert tactus.dataset(two, data_set.folder)["computed"] == 0, "it goes on where it was"


def same(a, b):
    assert a.keys() == b.keys() == tactus.StoredGrasp.__annotations__.keys()
    return all(np.array_equal(a[name], b[name]) for name in a)


def test_a_data_set_is_a_sequence_of_its_grasps(folder):
    data = tactus.DataSet(folder)
    reached = [(name, grasp) for name in data.objects() for grasp in data.reached(name)]
    assert len(data) == len(reached) > 5 and data.damaged() == []
    assert [(g["object"], g["grasp"]) for g in data] == reached
    assert same(data[-1], data.grasp(*reached[-1]))
    with pytest.raises(IndexError):
        data[len(data)]
    grasp, (left, right) = data[0], data.pads("ball")
    assert grasp["displacement_m"].shape == (3, 2, len(left.rest_m), 3) and np.array_equal(left.tets, right.tets)
    assert "Sphere" in data.scene("ball") and len(data.surface("ball").triangles) > 0
    with pytest.raises(ValueError, match="has no object 'cup'; it has: ball, box"):
        data.reached("cup")


def test_it_is_indexed_by_integers_slices_and_names(folder):
    data = tactus.DataSet(folder)
    some = data[1:-1:2]
    assert isinstance(some, tactus.DataSet) and len(some) == len(range(1, len(data) - 1, 2)) and len(data[:0]) == 0
    assert same(some[1], data[3]) and same(some[::-1][0], some[-1]) and same(data[np.int64(2)], data[2])
    again = pickle.loads(pickle.dumps(some))
    assert len(again) == len(some) and same(again[1], some[1])
    name, number = "box", data.reached("box")[0]
    assert same(data[name, number], data.grasp(name, number))
    for wrong, found in ((1.5, "float"), ("box", "str"), ([0, 1], "list"), ((0, 1), "tuple"), (None, "NoneType")):
        with pytest.raises(TypeError, match=rf"by an integer, a slice, or \(object, grasp\).* not by {found}"):
            data[wrong]
    with pytest.raises(ValueError, match='has no object "cup"; it has: ball, box'):
        data["cup", 0]


def test_its_parts_are_those_of_the_split(folder):
    train, test = tactus.DataSet(str(folder), "train"), tactus.DataSet(folder, part="test")
    assert len(train) + len(test) == len(tactus.DataSet(folder)) and len(test) > 0
    assert [(g["object"], g["grasp"]) for g in test] == test.split(test=True)
    with pytest.raises(ValueError, match='allowed: "all"'):
        tactus.DataSet(folder, "some")


def test_it_pickles(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    data = tactus.DataSet("set", "test")
    packed = pickle.dumps(data)
    monkeypatch.chdir("/")
    again = pickle.loads(packed)
    assert repr(again) == repr(data) and same(again[0], data[0])


def read(data, indices, to):
    to.put([data[i]["displacement_m"].tobytes() for i in indices])


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_processes_read_beside_each_other(folder, start):
    data = tactus.DataSet(folder)
    indices = list(range(len(data))) * 5
    expected = [data[i]["displacement_m"].tobytes() for i in indices]
    context = multiprocessing.get_context(start)
    to = context.Queue()
    children = [context.Process(target=read, args=(data, indices, to)) for _ in range(3)]
    [child.start() for child in children]
    try:
        assert [to.get(timeout=120) for _ in children] == [expected] * 3
        assert [data[i]["displacement_m"].tobytes() for i in indices] == expected
    finally:
        [child.join(timeout=30) for child in children]


def test_torch_takes_it(folder):
    torch = pytest.importorskip("torch")
    # Objects differ in the shape of their surface arrays, but their pads are the same.
    loader = torch.utils.data.DataLoader(tactus.DataSet(folder), batch_size=4, num_workers=2, shuffle=True)
    batches = list(loader)
    assert sum(len(batch["object"]) for batch in batches) == len(tactus.DataSet(folder))
    assert batches[0]["displacement_m"].dtype == torch.float32 and batches[0]["displacement_m"].shape[0] == 4


def test_what_is_damaged_is_left_out_and_logged(folder, tmp_path, caplog):
    import shutil

    shutil.copytree(folder, tmp_path / "set")
    (file,) = (tmp_path / "set" / "dgs_output").glob("box*")
    file.write_bytes(file.read_bytes()[:-1])
    with caplog.at_level(logging.WARNING, logger="tactus"):
        data = tactus.DataSet(tmp_path / "set")
    assert data.objects() == ["ball"] and len(data.damaged()) == 1
    assert data.damaged()[0] in caplog.text
    report = tactus.inspect(tmp_path / "set")
    assert not report.good and report["inspection"]["damaged"]
    with pytest.raises(ValueError, match="contains no data set"):
        tactus.DataSet(tmp_path)
