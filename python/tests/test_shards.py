"""Sharded rollouts: a cluster of two nodes that loses a worker in the middle writes the bytes of one machine."""

import hashlib
import os
import signal
import threading
import time
import uuid
from pathlib import Path

import pytest

from tactus.shards import rollout

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"
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


def test_two_nodes_and_a_killed_worker_write_the_same_bytes(tmp_path, monkeypatch):
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    # Only workers of this test carry it.
    mark = uuid.uuid4().hex
    monkeypatch.setenv("TACTUS_TEST", mark)
    rollout(HOLD, tmp_path / "one", per_shard=2, **SETTINGS)
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    cluster.add_node(num_cpus=1)
    ray.init(address=cluster.address)
    killed = []

    def kill_a_worker():
        while not killed and threading.main_thread().is_alive():
            time.sleep(0.05)
            for entry in Path("/proc").glob("[0-9]*/cmdline"):
                try:
                    busy = entry.read_bytes().startswith(b"ray::shard")
                    own = mark.encode() in (entry.parent / "environ").read_bytes()
                except OSError:
                    continue
                if busy and own:
                    pid = int(entry.parent.name)
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)
                    return

    try:
        assert len(ray.nodes()) == 2
        killer = threading.Thread(target=kill_a_worker, daemon=True)
        killer.start()
        rollout(HOLD, tmp_path / "two", per_shard=2, cluster=True, **SETTINGS)
        killer.join(timeout=5)
    finally:
        ray.shutdown()
        cluster.shutdown()
    assert killed, "a worker was killed while it ran a shard"
    one, two = bytes_of(tmp_path / "one"), bytes_of(tmp_path / "two")
    assert len(one) == 4 * 8 and one == two, "nothing lost, nothing doubled, the same bytes"
