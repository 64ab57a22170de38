"""PPO of Stable-Baselines3: trains on the network, optionally continues on finite elements, evaluates as `ppo.py` does.

    python python/examples/stable_baselines.py scenes/tasks/hold.ron --model universe --out out/sb3/hold
"""

import csv

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnvWrapper, VecMonitor, VecNormalize

import referee
from tactus.stable_baselines import VecEnv

parser = referee.arguments("out/sb3")
parser.add_argument("--tensorboard", help="folder for TensorBoard, which has to be installed then")
args = parser.parse_args()
args.out.mkdir(parents=True, exist_ok=True)
torch.set_num_threads(1)


class LastAction(VecEnvWrapper):
    """Adds the last action, which contains the position of the hand for regrasping, to the observations."""

    def __init__(self, venv):
        own = gym.spaces.Dict({**venv.observation_space.spaces, "last_action": venv.action_space})
        super().__init__(venv, observation_space=own)

    def reset(self):
        self.last = np.zeros((self.num_envs, *self.action_space.shape), np.float32)
        return {**self.venv.reset(), "last_action": self.last}

    def step_async(self, actions):
        self.last = np.clip(actions, -1, 1).astype(np.float32)
        self.venv.step_async(actions)

    def step_wait(self):
        obs, reward, done, infos = self.venv.step_wait()
        for i in done.nonzero()[0]:
            infos[i]["terminal_observation"] = {**infos[i]["terminal_observation"], "last_action": self.last[i]}
        self.last = np.where(done[:, None], np.float32(0), self.last)
        return {**obs, "last_action": self.last}, reward, done, infos


class Margin(VecEnvWrapper):
    """Reduces the reward by 1 for steps that hold the object with a friction margin below `margin`."""

    def __init__(self, venv, margin):
        super().__init__(venv)
        self.margin = margin

    def reset(self):
        return self.venv.reset()

    def step_wait(self):
        obs, reward, done, infos = self.venv.step_wait()
        # At the end of an episode the infos are those of the next one.
        slack = [not end and info["held"] and info["margin"] < self.margin for end, info in zip(done, infos)]
        return obs, reward - np.array(slack, np.float32), done, infos


class Curve(BaseCallback):
    """Saves the policy and the mean return of the last 200 episodes after each rollout."""

    def __init__(self, stage, rows):
        super().__init__()
        self.stage, self.rows = stage, rows

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        returns = [episode["r"] for episode in self.model.ep_info_buffer]
        self.rows.append((self.num_timesteps, self.stage, np.mean(returns) if returns else np.nan))
        print(f"{self.num_timesteps} steps: return {self.rows[-1][2]:.2f}", flush=True)
        self.model.save(args.out / "policy.part")
        self.model.get_vec_normalize_env().save(args.out / "normalize.part")
        # Files are replaced as a whole, so that an interruption leaves those of the previous rollout.
        (args.out / "normalize.part").replace(args.out / "normalize.pkl")
        (args.out / "policy.part").replace(args.out / "policy.zip")
        with open(args.out / "curve.csv", "w", newline="") as file:
            csv.writer(file).writerows([("steps", "on", "return"), *self.rows])


def make(model):
    env = VecEnv(args.scene, args.envs, model=model, threads=args.threads, seed=args.seed)
    # Monitored inside `Margin`, so that curves show the rewards of the task.
    watched = VecMonitor(LastAction(env))
    return VecNormalize(Margin(watched, args.margin) if model else watched, gamma=args.gamma)


env, curve = make(args.model), []
agent = PPO(
    "MultiInputPolicy", env, n_steps=32, batch_size=256, n_epochs=6, learning_rate=lambda left: 1e-3 * left, gamma=args.gamma, ent_coef=1e-3,
    policy_kwargs={"log_std_init": -0.5, "net_arch": [64, 64]}, stats_window_size=200, seed=args.seed, device="cpu",
    tensorboard_log=args.tensorboard,
)  # fmt: skip


def learned(obs, last):
    seen = agent.get_vec_normalize_env().normalize_obs({**obs, "last_action": last})
    return agent.predict(seen, deterministic=True)[0]


def judge(stage, **settings):
    if args.episodes:
        print(f"{stage}, {args.episodes} held-out episodes:")
        path = args.out / f"judged_{stage}.csv"
        referee.judge({"PPO": learned}, args.scene, args.episodes, path, threads=args.threads, **settings)


if args.model:
    agent.learn(args.steps, callback=Curve("network", curve))
    judge("network", model=args.model)
    if args.refine:
        fem = make(None)
        # Observations and rewards keep the normalisation of the training on the network.
        fem.obs_rms, fem.ret_rms = env.obs_rms, env.ret_rms
        agent.set_env(fem)
        agent.learn(args.refine, callback=Curve("fem", curve), reset_num_timesteps=False)
else:
    agent.learn(args.steps, callback=Curve("fem", curve))
judge("fem")

from curves import draw  # noqa: E402

draw([args.out], args.out / "curve.png")
