"""PyTorch implementation of the networks: compares a model with the output of `tactus eval --dump FILE.npz`.

The face network is that of `python/tactus/face.py`; the paper's network is implemented here, for this check only.

usage: torch_check.py MODEL_DIR FILE.npz      needs torch, safetensors, numpy; exits with 1 beyond 1e-5 relative
"""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file

w = load_file(f"{sys.argv[1]}/weights.safetensors")
d = {k: torch.from_numpy(v.astype(np.int64) if v.dtype == np.uint32 else v) for k, v in np.load(sys.argv[2]).items()}


torch.sparse.check_sparse_tensor_invariants.enable()


def face():
    # Loads the file alone, without the compiled part of the package.
    spec = spec_from_file_location("face", Path(__file__).parents[2] / "python" / "tactus" / "face.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    network, grasp = module.FaceNetwork(w), {k: v[None] for k, v in d.items()}
    with torch.no_grad():
        out = network.decode(d, grasp, network.encode(d, grasp))
    return {k: v.reshape(-1, d[f"out_{k}"].shape[1]) for k, v in out.items()}


def sparse(name, rows, cols):
    return torch.sparse_coo_tensor(d[f"{name}_at"].T, d[f"{name}_weight"][0], (rows, cols)).to_dense()


def layer(x, name):
    return x @ w[f"{name}.weight"] + w[f"{name}.bias"]


def norm(x, name):
    return torch.nn.functional.layer_norm(x, x.shape[-1:], w[f"{name}.gain"][0], w[f"{name}.shift"][0], 1e-5)


def share(x, size):
    x = x.reshape(-1, size, 3)
    s = torch.softmax(x[..., :1], 1)
    return (s * torch.cat([torch.ones_like(s), x[..., 1:]], -1)).reshape(-1, 3)


def receive(x, edges, nodes):
    return torch.zeros(nodes, x.shape[1]).index_add_(0, edges[:, 1], x)


def paper():
    pads, size = d["near_at"][:, 0].max().item() + 1, d["near_at"][:, 1].max().item() + 1
    mesh, touching = d["mesh"], d["contact"]
    nodes, n, faces = d["node"].shape[0], d["pads_at"].shape[0], d["face_at"].shape[0]

    def mlp(name, *xs):
        x = sum(x @ w[f"{name}.input{k}"] for k, x in enumerate(xs)) + w[f"{name}.bias"]
        x = layer(torch.relu(layer(torch.relu(x), f"{name}.hidden")), f"{name}.out")
        return norm(x, name)

    out = []
    for force_edges in d["contact_edge"].reshape(-1, touching.shape[0], d["contact_edge"].shape[1]):
        h, e, c = mlp("encode.node", d["node"]), mlp("encode.mesh", d["mesh_edge"]), mlp("encode.contact", force_edges)
        for _ in range(int(d["rounds"])):
            e = e + mlp("block.mesh", e, h[mesh[:, 0]], h[mesh[:, 1]])
            c = c + mlp("block.contact", c, h[touching[:, 0]], h[touching[:, 1]])
            h = h + mlp("block.node", h, receive(e, mesh, nodes), receive(c, touching, nodes))
        z = mlp("decode", h)
        on_face = sparse("face", faces, nodes) @ z
        pooled = mlp("pooled", sparse("near", pads, size) @ on_face)
        out.append({
            "displacement": (sparse("turned", 3 * n, 3 * nodes) @ layer(z, "displacement").reshape(-1, 1)).reshape(-1, 3),
            "stress": torch.relu(sparse("pads", n, nodes) @ layer(z, "stress")),
            "contact": share(layer(on_face, "contact"), faces // pads),
            "travel": layer(pooled, "travel"),
            "motion": layer(pooled, "motion"),
        })
    return {k: torch.cat([o[k] for o in out]) for k in out[0]}


worst = 0.0
for name, mine in (face if "edge" in d else paper)().items():
    theirs = d[f"out_{name}"]
    size = theirs.norm()
    if name in ("travel", "motion"):  # corrections to the mechanics, about 1 in training but nearly 0 for some grasps
        size = size.clamp(min=theirs.numel() ** 0.5)
    error = ((mine - theirs).norm() / size).item()
    print(f"{name}: {error:.1e} relative")
    worst = max(worst, error)
sys.exit(0 if worst < 1e-5 else 1)
