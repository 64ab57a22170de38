"""Ctrl-C interrupts computations in Rust with KeyboardInterrupt and leaves all objects usable."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import tactus

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"

# Takes half a minute or more without an interruption.
LONG = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    grasps: Antipodal(count: 40, seed: 1),
    gripper: (pads: GelSightMini(spacing: 2.0e-3)),
    loading: Squeeze(force: 15.0, frames: 50),
)"""

# Time limit of an interruption, s: far longer than it takes, far shorter than the work.
SOON = 5.0


@pytest.fixture
def long(tmp_path):
    path = tmp_path / "long.ron"
    path.write_text(LONG)
    return path


def interrupted(work, after=1.5):
    """Runs `work` until Ctrl-C interrupts it; returns the time from the signal to the end, s."""
    sent = []

    def send():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(after, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
        took = time.perf_counter() - sent[0]
    finally:
        timer.cancel()
        timer.join()
    assert took < SOON, f"{took:.1f} s"
    print(f"ended {took:.3f} s after the signal")
    return took


def test_a_run_ends_and_the_next_one_works(long):
    interrupted(lambda: tactus.run(long))
    assert [g.status for g in tactus.run(HOLD, object="sphere")] == ["reached"] * 2


def test_a_data_set_ends_and_goes_on(long, tmp_path):
    interrupted(lambda: tactus.dataset(long, tmp_path / "set"))
    small = long.with_name("small.ron")
    text = LONG.replace("count: 40", "count: 2").replace("frames: 50", "frames: 2").replace("2.0e-3", "6.0e-3")
    small.write_text(text)
    assert tactus.dataset(small, tmp_path / "small")["computed"] == 2
    assert tactus.DataSet(tmp_path / "small").objects() == ["small"], "a path is as good as a string"


def test_an_exception_of_the_progress_ends_a_run(long):
    class Enough(Exception):
        pass

    told = []
    long.write_text(LONG.replace("2.0e-3", "4.0e-3"))

    def progress(done, of):
        told.append((done, of))
        if done:
            raise Enough

    with pytest.raises(Enough):
        tactus.run(long, frames=1, progress=progress)
    assert told[-1][0] < 40 and {of for _, of in told} == {40}


def test_steps_end_and_a_reset_begins_the_same_episodes(tmp_path):
    def endless():
        while True:
            env.step(env.action_space.sample())

    env = tactus.VectorEnv(HOLD, 64, seed=3, threads=2)
    first, _ = env.reset()
    interrupted(endless, after=2.0)
    try:
        # Reached if the signal came between two steps.
        env.step(np.zeros((64, 1)))
    except ValueError as error:
        assert "steps before its first reset" in str(error)
    again, _ = env.reset(seed=3)
    assert all(np.array_equal(first[name], again[name]) for name in first)


def test_a_reset_ends():
    env = tactus.VectorEnv(HOLD, 2000, seed=3)
    interrupted(env.reset)


def test_what_another_handler_raises_is_raised(long):
    class Enough(Exception):
        pass

    def handler(*_):
        raise Enough

    before = signal.signal(signal.SIGUSR1, handler)
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGUSR1))
    try:
        timer.start()
        with pytest.raises(Enough):
            tactus.run(long)
    finally:
        timer.join()
        signal.signal(signal.SIGUSR1, before)


def test_a_thread_beside_the_main_one_is_ended_too(long):
    raised = []

    def work():
        try:
            tactus.run(long, threads=1)
        except BaseException as error:
            raised.append(type(error))

    beside = threading.Thread(target=work)
    beside.start()
    interrupted(lambda: tactus.run(long, threads=1))
    beside.join(timeout=30)
    assert raised == [KeyboardInterrupt]


def test_tests_in_the_background_of_a_shell_are_interrupted_too():
    """A shell without job control starts background processes with SIGINT ignored."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"{__file__}::test_a_reset_ends"]
    ignored = lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)  # noqa: E731
    done = subprocess.run(command, preexec_fn=ignored, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
