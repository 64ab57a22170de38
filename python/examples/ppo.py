"""PPO (Schulman et al. 2017), after CleanRL: trains on the network, optionally continues on finite elements, and
evaluates on held-out seeds, compared with constant forces and a random policy (`referee.py`).

    python python/examples/ppo.py scenes/tasks/hold.ron --model universe --out out/ppo/hold
"""

import csv
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn

import referee
import tactus

parser = referee.arguments("out/ppo")
parser.add_argument("--start", type=Path, help="policy.pt of an earlier run to resume")
parser.add_argument("--horizon", type=int, default=32)
parser.add_argument("--epochs", type=int, default=6)
parser.add_argument("--minibatches", type=int, default=8)
parser.add_argument("--rate", type=float, default=1e-3)
parser.add_argument("--refine-rate", type=float, default=5e-4)
parser.add_argument("--lam", type=float, default=0.95)
parser.add_argument("--clip", type=float, default=0.2)
parser.add_argument("--entropy", type=float, default=1e-3)
args = parser.parse_args()
args.out.mkdir(parents=True, exist_ok=True)
torch.manual_seed(args.seed)
torch.set_num_threads(1)


class Scaler:
    """Normalisation by running mean and standard deviation (Welford 1962)."""

    def __init__(self, size):
        self.mean, self.square, self.count = np.zeros(size), np.ones(size), 1e-4

    def update(self, x):
        n, mean, var = len(x), x.mean(0), x.var(0)
        delta, whole = mean - self.mean, self.count + n
        self.square = (self.square * self.count + var * n + delta**2 * self.count * n / whole) / whole
        self.mean, self.count = self.mean + delta * n / whole, whole

    def __call__(self, x):
        return torch.as_tensor(np.clip((x - self.mean) / np.sqrt(self.square + 1e-10), -10, 10), dtype=torch.float32)


def flat(obs, last):
    """Concatenates observations and last action, which contains the position of the hand for regrasping."""
    return np.concatenate([*(a.reshape(len(a), -1) for a in obs.values()), last], axis=1).astype(np.float64)


def make(model):
    return tactus.VectorEnv(args.scene, args.envs, threads=args.threads, model=model, seed=args.seed)


env = make(args.model)
acts = env.single_action_space.shape[0]
size = sum(int(np.prod(space.shape)) for space in env.single_observation_space.values()) + acts


def net(out, gain):
    layers = [nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, out)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


actor, critic, spread = net(acts, 0.01), net(1, 1.0), nn.Parameter(torch.full((acts,), -0.5))
parameters = [*actor.parameters(), *critic.parameters(), spread]
adam = torch.optim.Adam(parameters, eps=1e-5)
# Rewards are divided by the standard deviation of their discounted sums, so that one learning rate suits all tasks.
scale, pay = Scaler(size), Scaler(1)


# (steps, stage of training, mean return of the last 200 episodes)
curve = []
if args.start:
    kept = torch.load(args.start, weights_only=False)
    actor.load_state_dict(kept["actor"])
    critic.load_state_dict(kept["critic"])
    spread.data, scale, pay, curve = (kept[key] for key in ("spread", "scale", "pay", "curve"))


def keep():
    """Writes policy and curve, so that an interrupted training can be resumed."""
    kept = {"actor": actor.state_dict(), "critic": critic.state_dict(), "spread": spread.data}
    kept |= {"scale": scale, "pay": pay, "curve": curve}
    torch.save(kept, args.out / "policy.part")
    (args.out / "policy.part").replace(args.out / "policy.pt")
    with open(args.out / "curve.csv", "w", newline="") as file:
        csv.writer(file).writerows([("steps", "on", "return"), *curve])


def policy(x):
    return torch.distributions.Normal(actor(x), spread.exp())


def learned(obs, last):
    with torch.no_grad():
        return actor(scale(flat(obs, last))).numpy()


def train(env, stage, steps, rate, margin=0.0):
    """Trains in `env` for `steps` steps and extends `curve`; a step with a friction margin below `margin` costs 1."""
    begin, before = time.perf_counter(), curve[-1][0] if curve else 0
    last = np.zeros((args.envs, acts), np.float32)
    seen = flat(env.reset(seed=args.seed)[0], last)
    returns, running, discounted = [], np.zeros(args.envs), np.zeros(args.envs)
    fresh = np.zeros(args.envs, bool)
    updates = steps // (args.envs * args.horizon)
    for update in range(updates):
        adam.param_groups[0]["lr"] = rate * (1 - update / updates)
        buffer = {key: [] for key in ("x", "a", "logp", "v", "r", "done", "use")}
        for _ in range(args.horizon):
            scale.update(seen)
            x = scale(seen)
            with torch.no_grad():
                chosen = policy(x)
                a = chosen.sample()
                logp, v = chosen.log_prob(a).sum(1), critic(x)[:, 0]
            obs, reward, terminated, truncated, infos = env.step(a.numpy())
            done = terminated | truncated
            running = running + reward
            reward = reward - (infos["held"] & (infos["margin"] < margin))
            discounted = args.gamma * discounted + reward
            pay.update(discounted[:, None])
            returns += running[done].tolist()
            running[done] = discounted[done] = 0
            # The step after the end of an episode resets and ignores its action; it is excluded from learning.
            reward = (reward / pay.square[0] ** 0.5).astype(np.float32)
            for key, value in zip(buffer, (x, a, logp, v, reward, done, ~fresh)):
                buffer[key].append(torch.as_tensor(value))
            last = np.where(fresh[:, None], 0, a.numpy().clip(-1, 1))
            seen, fresh = flat(obs, last), done
        with torch.no_grad():
            after = critic(scale(seen))[:, 0]
        gain, advantage = torch.zeros(args.envs), []
        for t in reversed(range(args.horizon)):
            goes_on = 1.0 - buffer["done"][t].float()
            delta = buffer["r"][t] + args.gamma * after * goes_on - buffer["v"][t]
            gain = delta + args.gamma * args.lam * goes_on * gain
            advantage.append(gain)
            after = buffer["v"][t]
        learn({key: torch.cat(value) for key, value in buffer.items()}, torch.cat(advantage[::-1]))
        done_steps = before + (update + 1) * args.envs * args.horizon
        curve.append((done_steps, stage, np.mean(returns[-200:]) if returns else np.nan))
        if update % 10 == 9 or update == updates - 1:
            print(f"{done_steps} steps, {time.perf_counter() - begin:.0f} s: return {curve[-1][2]:.2f}", flush=True)
            keep()


def learn(flatten, adv):
    """Updates policy and critic with a batch of steps."""
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


def judge(stage, **settings):
    if args.episodes:
        print(f"{stage}, {args.episodes} held-out episodes:")
        referee.judge({"PPO": learned}, args.scene, args.episodes, args.out / f"judged_{stage}.csv", threads=args.threads, **settings)


if args.model:
    train(env, "network", args.steps, args.rate, args.margin)
    judge("network", model=args.model)
    if args.refine:
        train(make(None), "fem", args.refine, args.refine_rate)
else:
    train(env, "fem", args.steps, args.rate)
keep()
judge("fem")

from curves import draw  # noqa: E402

draw([args.out], args.out / "curve.png")
