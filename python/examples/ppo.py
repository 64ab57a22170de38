"""PPO (Schulman et al. 2017) in one file, after CleanRL: learns a task on the network, is judged on seeds it never saw and
by the finite elements.

    python examples/ppo.py ../scenes/tasks/hold.ron --model out/tasks_model --steps 200000 --curve ppo.png
"""

import argparse
import time

import numpy as np
import torch
from torch import nn

import tactus

parser = argparse.ArgumentParser()
parser.add_argument("scene")
parser.add_argument("--model", help="folder of a trained network; without it the scene's backend")
parser.add_argument("--envs", type=int, default=64)
parser.add_argument("--steps", type=int, default=200_000)
parser.add_argument("--horizon", type=int, default=32)
parser.add_argument("--epochs", type=int, default=6)
parser.add_argument("--minibatches", type=int, default=8)
parser.add_argument("--rate", type=float, default=1e-3)
parser.add_argument("--gamma", type=float, default=0.97)
parser.add_argument("--lam", type=float, default=0.95)
parser.add_argument("--clip", type=float, default=0.2)
parser.add_argument("--entropy", type=float, default=1e-3)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--episodes", type=int, default=128, help="judged on the network")
parser.add_argument("--referee", type=int, default=32, help="judged by finite elements; 0 is none")
parser.add_argument("--threads", type=int)
parser.add_argument("--curve", default="ppo.png")
args = parser.parse_args()
torch.manual_seed(args.seed)
torch.set_num_threads(1)

# Kept apart from the seeds of training.
HELD_OUT = 1_000_003


class Scaler:
    """Running mean and deviation of the observations (Welford 1962)."""

    def __init__(self, size):
        self.mean, self.square, self.count = np.zeros(size), np.ones(size), 1e-4

    def update(self, x):
        n, mean, var = len(x), x.mean(0), x.var(0)
        delta, whole = mean - self.mean, self.count + n
        self.square = (self.square * self.count + var * n + delta**2 * self.count * n / whole) / whole
        self.mean, self.count = self.mean + delta * n / whole, whole

    def __call__(self, x):
        return torch.as_tensor(np.clip((x - self.mean) / np.sqrt(self.square + 1e-10), -10, 10), dtype=torch.float32)


def flat(obs):
    return np.concatenate([a.reshape(len(a), -1) for a in obs.values()], axis=1).astype(np.float64)


def make(envs, **settings):
    return tactus.VectorEnv(args.scene, envs, threads=args.threads, **settings)


env = make(args.envs, model=args.model, seed=args.seed)
obs = flat(env.reset(seed=args.seed)[0])
size, acts = obs.shape[1], env.single_action_space.shape[0]


def net(out, gain):
    layers = [nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, out)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


actor, critic, spread = net(acts, 0.01), net(1, 1.0), nn.Parameter(torch.full((acts,), -0.5))
parameters = [*actor.parameters(), *critic.parameters(), spread]
adam = torch.optim.Adam(parameters, lr=args.rate, eps=1e-5)
scale = Scaler(size)


def policy(x):
    return torch.distributions.Normal(actor(x), spread.exp())


def judge(act, episodes, **settings):
    """Mean return of whole first episodes of `episodes` environments, and how many were lost."""
    env = make(episodes, **settings)
    x, total = flat(env.reset(seed=HELD_OUT)[0]), np.zeros(episodes)
    alive, lost = np.ones(episodes, bool), 0
    while alive.any():
        obs, reward, terminated, truncated, _ = env.step(act(x))
        total += np.where(alive, reward, 0)
        lost += int((alive & terminated).sum())
        alive &= ~(terminated | truncated)
        x = flat(obs)
    return total.mean(), lost / episodes


def learned(x):
    with torch.no_grad():
        return actor(scale(x)).numpy()


rng = np.random.default_rng(0)
curve, begin = [], time.perf_counter()
returns, running = [], np.zeros(args.envs)
fresh = np.zeros(args.envs, bool)
updates = args.steps // (args.envs * args.horizon)
stepping = 0.0
for update in range(updates):
    adam.param_groups[0]["lr"] = args.rate * (1 - update / updates)
    buffer = {key: [] for key in ("x", "a", "logp", "v", "r", "done", "use")}
    for _ in range(args.horizon):
        scale.update(obs)
        x = scale(obs)
        with torch.no_grad():
            chosen = policy(x)
            a = chosen.sample()
            logp, v = chosen.log_prob(a).sum(1), critic(x)[:, 0]
        clock = time.perf_counter()
        seen, reward, terminated, truncated, _ = env.step(a.numpy())
        stepping += time.perf_counter() - clock
        done = terminated | truncated
        running += reward
        returns += running[done].tolist()
        running[done] = 0
        # The step after an end starts the next episode and takes no action: it is not learnt from.
        for key, value in zip(buffer, (x, a, logp, v, reward, done, ~fresh)):
            buffer[key].append(torch.as_tensor(value))
        obs, fresh = flat(seen), done
    with torch.no_grad():
        after = critic(scale(obs))[:, 0]
    gain, advantage = torch.zeros(args.envs), []
    for t in reversed(range(args.horizon)):
        goes_on = 1.0 - buffer["done"][t].float()
        delta = buffer["r"][t] + args.gamma * after * goes_on - buffer["v"][t]
        gain = delta + args.gamma * args.lam * goes_on * gain
        advantage.append(gain)
        after = buffer["v"][t]
    flatten = {key: torch.cat(value) for key, value in buffer.items()}
    adv = torch.cat(advantage[::-1])
    target = adv + flatten["v"]
    use = flatten["use"].nonzero()[:, 0]
    for _ in range(args.epochs):
        for part in use[torch.randperm(len(use))].chunk(args.minibatches):
            x, a = flatten["x"][part], flatten["a"][part]
            now, own = policy(x), adv[part]
            own = (own - own.mean()) / (own.std() + 1e-8)
            ratio = (now.log_prob(a).sum(1) - flatten["logp"][part]).exp()
            surrogate = torch.min(ratio * own, ratio.clamp(1 - args.clip, 1 + args.clip) * own).mean()
            miss = ((critic(x)[:, 0] - target[part]) ** 2).mean()
            loss = 0.5 * miss - surrogate - args.entropy * now.entropy().sum(1).mean()
            adam.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(parameters, 0.5)
            adam.step()
    done_steps = (update + 1) * args.envs * args.horizon
    curve.append((done_steps, np.mean(returns[-200:]) if returns else np.nan))
    if update % 10 == 9 or update == updates - 1:
        print(f"{done_steps} steps, {time.perf_counter() - begin:.0f} s: return {curve[-1][1]:.2f}", flush=True)
wall = time.perf_counter() - begin
print(f"trained in {wall:.0f} s, of which {stepping:.0f} s in the environments")

uniform = lambda x: rng.uniform(-1, 1, (len(x), acts)).astype(np.float32)  # noqa: E731
rows = [("random", uniform), ("learned", learned)]
rows += [(f"always {a:+.1f}", lambda x, a=a: np.full((len(x), acts), a, np.float32)) for a in (-1.0, -0.5, 0.0, 0.5, 1.0)]
print(f"held-out seeds, {args.episodes} episodes:")
results = {name: judge(act, args.episodes, model=args.model) for name, act in rows}
for name, (value, lost) in results.items():
    print(f"  {name:12} return {value:7.2f}, objects lost {lost:.0%}")
if args.referee:
    print(f"finite elements, {args.referee} episodes:")
    for name, act in rows[:2]:
        value, lost = judge(act, args.referee)
        print(f"  {name:12} return {value:7.2f}, objects lost {lost:.0%}", flush=True)

import matplotlib  # noqa: E402

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

figure, axes = plt.subplots(figsize=(5, 3.2))
axes.plot(*zip(*((n / 1000, value) for n, value in curve)), label="PPO, last 200 episodes")
axes.axhline(results["random"][0], color="grey", ls="--", label="random policy")
axes.set(xlabel="environment steps, thousands", ylabel="return")
axes.legend()
figure.tight_layout()
figure.savefig(args.curve, dpi=120)
