"""Sharded rollouts and data sets: a cluster of two nodes with a killed worker writes the same bytes as one machine."""

import hashlib
import os
import signal
import threading
import time
import uuid
from pathlib import Path

import pytest

from tactus.shards import dataset, rollout

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"
SMALL = HOLD.parents[1] / "paper_small.ron"
SETTINGS = dict(num_envs=8, steps=6, seed=5, objects=["sphere"], max_steps=4)


def bytes_of(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(Path(folder).rglob("*.npy"))
    }


def test_a_shard_that_is_there_is_not_made_again(tmp_path):
    first = rollout(HOLD, tmp_path, per_shard=4, **SETTINGS)
    before = {p: os.stat(p).st_mtime_ns for p in first}
    assert first == rollout(HOLD, tmp_path, per_shard=4, **SETTINGS)
    assert before == {p: os.stat(p).st_mtime_ns for p in first}


def test_a_data_set_in_parts_has_the_bytes_of_one_made_at_once(tmp_path):
    assert dataset(SMALL, tmp_path / "one", parts=1) == 12
    assert dataset(SMALL, tmp_path / "two", parts=5) == 12
    assert dataset(SMALL, tmp_path / "two", parts=5) == 0
    assert files_of(tmp_path / "one") == files_of(tmp_path / "two")


def files_of(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(Path(folder).rglob("*")) if p.is_file()}


@pytest.fixture
def cluster_that_loses_a_worker(monkeypatch):
    """Starts a cluster of two nodes with one core each; a worker that runs a task with the given name is killed."""
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    # Identifies the workers of this test.
    mark = uuid.uuid4().hex
    monkeypatch.setenv("TACTUS_TEST", mark)
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    cluster.add_node(num_cpus=1)
    ray.init(address=cluster.address)
    assert len(ray.nodes()) == 2
    killed = []

    def kill_a_worker(task, once):
        while not killed and threading.main_thread().is_alive():
            time.sleep(0.05)
            for entry in Path("/proc").glob("[0-9]*/cmdline"):
                try:
                    busy = entry.read_bytes().startswith(b"ray::" + task)
                    own = mark.encode() in (entry.parent / "environ").read_bytes()
                except OSError:
                    continue
                if busy and own and once():
                    pid = int(entry.parent.name)
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)
                    return

    def start(task, once=lambda: True):
        killer = threading.Thread(target=kill_a_worker, args=(task, once), daemon=True)
        killer.start()
        return lambda: (killer.join(timeout=5), killed)[1]

    yield start
    ray.shutdown()
    cluster.shutdown()


def test_rollouts_of_two_nodes_and_a_killed_worker_have_the_same_bytes(tmp_path, cluster_that_loses_a_worker):
    rollout(HOLD, tmp_path / "one", per_shard=2, **SETTINGS)
    killed = cluster_that_loses_a_worker(b"shard")
    rollout(HOLD, tmp_path / "two", per_shard=2, cluster=True, **SETTINGS)
    assert killed(), "a worker was killed while it ran a shard"
    one, two = bytes_of(tmp_path / "one"), bytes_of(tmp_path / "two")
    assert len(one) == 4 * 8 and one == two, "nothing lost, nothing doubled, the same bytes"


def test_a_data_set_of_two_nodes_and_a_killed_worker_has_the_same_bytes(tmp_path, cluster_that_loses_a_worker):
    dataset(SMALL, tmp_path / "one", parts=1)
    # The worker is killed when some grasps are finished and others are not.
    some = lambda: 2 <= len(list((tmp_path / "two").glob(".progress/*/*.json"))) < 12
    killed = cluster_that_loses_a_worker(b"part", some)
    ran = dataset(SMALL, tmp_path / "two", parts=3, cluster=True)
    assert killed(), "a worker was killed while it ran a part"
    assert ran <= 12, "what was finished did not run again"
    assert files_of(tmp_path / "one") == files_of(tmp_path / "two"), "nothing lost, nothing doubled, the same bytes"
