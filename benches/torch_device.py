"""Batched prediction by PyTorch on a device, compared with the engine on all cores: times by stage, grasps per second,
and the largest difference of the predictions.

usage: torch_device.py SCENE [DEVICE] [GRASPS] [LOADS]      e.g. torch_device.py scenes/lemon.ron cuda 2048 12

Needs the Python package of tactus, torch and safetensors. The scene's poses are repeated, which does not affect times.
"""

import sys
import time

import numpy as np
import torch

import tactus
import tactus.torch

BATCH = 128

scene, device, grasps, loads = (*sys.argv[1:], *("scenes/lemon.ron", "cuda", "2048", "12")[len(sys.argv) - 1 :])
grasps, loads = int(grasps), int(loads)
on = tactus.torch.Network.load("universe").to(device).on(scene, frames=loads)
poses = np.resize(on.seen.usual()["poses"], (grasps, 7))


def now():
    if torch.device(device).type == "cuda":
        torch.cuda.synchronize()
    return time.perf_counter()


with torch.inference_mode():
    on(poses[:BATCH])  # Warm-up: allocates memory and loads kernels.
    seen, answered, worst = 0.0, 0.0, 0.0
    for part in np.split(poses, range(BATCH, grasps, BATCH)):
        start = now()
        inputs, *_ = on.inputs(part)
        middle = now()
        answer = on.network(on.pad(), inputs)
        seen, answered = seen + middle - start, answered + now() - middle
start = time.perf_counter()
many = tactus.predict(scene, poses=poses, frames=loads)
engine = time.perf_counter() - start
for mine, field in zip(answer, tactus.torch.Answer._fields):
    mine, theirs = mine.cpu().double().numpy().reshape(len(mine), -1), getattr(many, field)[-len(mine) :].reshape(len(mine), -1)
    worst = max(worst, (np.linalg.norm(mine - theirs, axis=1) / np.linalg.norm(theirs, axis=1)).max())
name = torch.cuda.get_device_name() if torch.device(device).type == "cuda" else device
print(f"{grasps} grasps of {loads} loads, PyTorch {torch.__version__} on {name}: mechanics {seen:.2f} s, network {answered:.3f} s,", end=" ")
print(f"{grasps / (seen + answered):.0f} grasps a second, {grasps / answered:.0f} by the network alone")
print(f"engine on {torch.get_num_threads()} threads: {engine:.2f} s, {grasps / engine:.0f} grasps a second; largest difference {worst:.1e}")
