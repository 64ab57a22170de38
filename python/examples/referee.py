"""Evaluation of policies: complete episodes on held-out seeds, compared with constant forces and a random policy.

A policy is a function of the observations (a dictionary of arrays) and its last actions (N, size); it returns actions
(N, size).
"""

import argparse
import csv
import re
from pathlib import Path

import numpy as np

import tactus

# First seed of the evaluation, distinct from the seeds of training.
HELD_OUT = 1_000_003
# Constant forces as fractions of the task's range.
FORCES = np.linspace(0, 1, 9)


def arguments(out):
    """Returns a parser with the arguments common to all learners; `out` is the default folder of curves and results."""
    parser = argparse.ArgumentParser(formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--model", help="folder of a trained network; without it the scene's backend")
    parser.add_argument("--envs", type=int, default=64)
    parser.add_argument("--steps", type=int, default=200_000, help="on the network")
    # The network predicts less accurately than finite elements whether an object is held.
    parser.add_argument("--margin", type=float, default=0.0, help="of friction that must remain after steps on the network; a smaller one costs 1")
    # Use 0 where every step is a new grasp: its reward is then the complete return.
    parser.add_argument("--gamma", type=float, default=0.97)
    parser.add_argument("--refine", type=int, default=0, help="steps after them on finite elements")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=64, help="judged on held-out seeds; 0 is none")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--out", type=Path, default=Path(out), help="folder for curves and results")
    return parser


def steady(scene, part, size):
    """Returns a policy of constant force, at `part` (0 to 1) of the task's range, and this force, N. If actions are
    rates, the policy approaches it at the largest rate.
    """
    text = tactus.load(scene).ron(tactus.load(scene).objects[0])
    least, most = map(float, re.search(r"task: \(.*?\bforce: \(([^,]+), ([^)]+)\)", text, re.S).groups())
    rate = re.search(r"control: Rate\(([^)]+)\)", text)

    def act(obs, last):
        actions = np.zeros((len(last), size), np.float32)
        actions[:, 0] = 2 * part - 1
        if rate:
            actions[:, 0] = np.clip((least + part * (most - least) - obs["force"][:, 0]) / float(rate[1]), -1, 1)
        return actions

    return act, least + part * (most - least)


def play(act, scene, episodes, seed=HELD_OUT, **settings):
    """Plays one episode in each of `episodes` environments; gives returns and whether objects were lost at the end."""
    env = tactus.VectorEnv(scene, episodes, **settings)
    obs, _ = env.reset(seed=seed)
    last = np.zeros(env.action_space.shape, np.float32)
    total, lost, runs = np.zeros(episodes), np.zeros(episodes, bool), np.ones(episodes, bool)
    # Environments whose episode has ended squeeze hard: each loss of the object would cost a new grasp.
    hard = np.eye(1, last.shape[1], dtype=np.float32)
    while runs.any():
        last = np.where(runs[:, None], np.clip(act(obs, last), -1, 1), hard)
        obs, reward, terminated, truncated, infos = env.step(last)
        total += np.where(runs, reward, 0)
        lost = np.where(runs, ~infos["held"], lost)
        runs &= ~(terminated | truncated)
    return total, lost


def judge(policies, scene, episodes, path=None, **settings):
    """Prints, for policies by name, the mean return with its standard error, the fraction of objects lost, and the
    paired difference to the best constant force; writes all but the differences to a CSV file. The best constant force
    is that of nine in the same episodes.
    """
    size = tactus.VectorEnv(scene, 1, objects=tactus.load(scene).objects[:1], **settings).single_action_space.shape[0]
    rng = np.random.default_rng(0)
    learned = list(policies)
    policies = policies | {"random": lambda obs, last: rng.uniform(-1, 1, last.shape).astype(np.float32)}
    constant = {f"always {force:.1f} N": act for act, force in (steady(scene, part, size) for part in FORCES)}
    totals, rows = {}, []
    for name, act in (policies | constant).items():
        totals[name], lost = play(act, scene, episodes, **settings)
        rows.append((name, totals[name].mean(), error(totals[name]), lost.mean()))
        print("  {:14} return {:7.2f} +- {:.2f}, objects lost {:4.0%}".format(*rows[-1]), flush=True)
    best = max(constant, key=lambda name: totals[name].mean())
    for name in learned:
        gain = totals[name] - totals[best]
        print(f"  {name} - {best}: {gain.mean():.2f} +- {error(gain):.2f}", flush=True)
    if path is not None:
        with open(path, "w", newline="") as file:
            csv.writer(file).writerows([("policy", "return", "standard_error", "lost"), *rows])


def error(values):
    """Returns the standard error of the mean."""
    return np.std(values, ddof=1) / len(values) ** 0.5
