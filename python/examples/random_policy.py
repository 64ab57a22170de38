"""Environment steps per second with a random policy.

    python examples/random_policy.py ../scenes/tasks/hold.ron --model universe --envs 64 --seconds 10
"""

import argparse
import resource
import time

import tactus

parser = argparse.ArgumentParser()
parser.add_argument("scene")
parser.add_argument("--model", help="folder of a trained network; without it the scene's backend")
parser.add_argument("--envs", type=int, default=64)
parser.add_argument("--threads", type=int)
parser.add_argument("--seconds", type=float, default=10.0)
parser.add_argument("--copy", action="store_true", help="fresh arrays every step instead of two alternating sets")
args = parser.parse_args()

env = tactus.VectorEnv(args.scene, args.envs, model=args.model, threads=args.threads, copy=args.copy)
env.action_space.seed(0)
begin = time.perf_counter()
env.reset(seed=0)
print(f"{args.envs} resets in {time.perf_counter() - begin:.2f} s")
steps, ended, faults, reward = 0, 0, 0, 0.0
begin = time.perf_counter()
while time.perf_counter() - begin < args.seconds:
    _, pay, terminated, truncated, infos = env.step(env.action_space.sample())
    steps += args.envs
    ended += int((terminated | truncated).sum())
    faults += int(infos["_fault"].sum())
    reward += float(pay.sum())
wall = time.perf_counter() - begin
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(f"{steps / wall:.0f} environment steps/s, resets included ({ended} episodes, {faults} faults, {wall:.1f} s)")
print(f"mean reward {reward / steps:.3f}; peak memory {memory:.0f} MiB with {args.envs} environments")
