"""The networks once more, in PyTorch: reads a model's folder and what `tactus eval --dump FILE.npz` wrote, and compares.

usage: torch_check.py MODEL_DIR FILE.npz      needs torch, safetensors, numpy; exits with 1 beyond 1e-5 relative
"""

import sys

import numpy as np
import torch
from safetensors.torch import load_file

w = load_file(f"{sys.argv[1]}/weights.safetensors")
d = {k: torch.from_numpy(v.astype(np.int64) if v.dtype == np.uint32 else v) for k, v in np.load(sys.argv[2]).items()}


torch.sparse.check_sparse_tensor_invariants.enable()


def sparse(name, rows, cols):
    return torch.sparse_coo_tensor(d[f"{name}_at"].T, d[f"{name}_weight"][0], (rows, cols)).to_dense()


def blocks(m, x):
    """m times every block of m.shape[1] rows of x."""
    return (m @ x.reshape(-1, m.shape[1], x.shape[1])).reshape(-1, x.shape[1])


def gated(z):
    return 0.5 * z * (1 + z / torch.sqrt(1 + z * z))


def positive(z):
    return 0.5 * (z + torch.sqrt(z * z + 1))


def layer(x, name):
    return x @ w[f"{name}.weight"] + w[f"{name}.bias"]


def norm(x, name):
    return torch.nn.functional.layer_norm(x, x.shape[-1:], w[f"{name}.gain"][0], w[f"{name}.shift"][0], 1e-5)


def share(x, size):
    x = x.reshape(-1, size, 3)
    s = torch.softmax(x[..., :1], 1)
    return (s * torch.cat([torch.ones_like(s), x[..., 1:]], -1)).reshape(-1, 3)


def balanced(x):
    """Friction takes up what the pads' pressure leaves over of the balance of the object."""
    levels = d["balance_load"].shape[0]
    if not levels:
        return x
    wrench, pull, inverse = (d[f"balance_{k}"].reshape(levels, 6, -1) for k in ("wrench", "pull", "inverse"))
    x = x.reshape(levels, -1, 1)
    left = d["balance_load"][..., None] - wrench @ x
    return (x + pull.transpose(1, 2) @ (inverse @ left)).reshape(-1, 3)


def receive(x, edges, nodes, usual):
    return torch.zeros(nodes, x.shape[1]).index_add_(0, edges[:, 1], x) / usual


def face():
    pads, levels = d["pad"].shape[0], d["pad_load"].shape[0] // d["pad"].shape[0]
    n = d["node"].shape[0] // pads
    edges = torch.cat([d["edges"] + p * n for p in range(pads)])
    mean, near = sparse("mean", pads, pads * n), sparse("near", pads, pads * n)
    other = torch.eye(2).flip(0) if pads == 2 else torch.zeros(1, 1)

    def pools(x, name):
        a, b = mean @ x, near @ x
        parts = zip(("mean", "near", "other_mean", "other_near"), (a, b, other @ a, other @ b))
        return gated(sum(x @ w[f"{name}.{k}"] for k, x in parts) + w[f"{name}.bias"])

    h = layer(d["node"], "start.node") + (d["pad"] @ w["start.pad"]).repeat_interleave(n, 0)
    rounds = sum(k.endswith(".sender") for k in w)
    for r in (f"round{k}" for k in range(rounds)):
        x = norm(h, f"{r}.norm")
        m = layer(d["edge"], f"{r}.edge") + (x @ w[f"{r}.sender"])[edges[:, 0]] + (x @ w[f"{r}.receiver"])[edges[:, 1]]
        m = receive(gated(m), edges, pads * n, 6.0)
        g = pools(x, f"{r}.pool") @ w[f"{r}.global"]
        inner = gated(layer(x, f"{r}.own") + m @ w[f"{r}.messages"] + g.repeat_interleave(n, 0))
        h = h + layer(inner, f"{r}.out")
    h = norm(h, "last.norm")
    g = pools(h, "last.pool")

    at_node, at_pad = d["node_load"], d["pad_load"]
    z = (h @ w["node.latent"] + w["node.bias"]).repeat(levels, 1) + at_node @ w["node.load"]
    z = gated(z + (at_pad @ w["node.pad_load"]).repeat_interleave(n, 0))
    z = z + layer(gated(layer(z, "node.inner")), "node.outer")
    y = gated((g @ w["pad.latent"] + w["pad.bias"]).repeat(levels, 1) + at_pad @ w["pad.load"])
    y = gated(layer(y, "pad.middle"))
    depths = w["stress.weight"].shape[1]
    u = layer(z, "displacement").reshape(-1, 3)
    factor, more = (positive(layer(z, k)).reshape(-1, 1) for k in ("factor", "stress"))
    nodes = d["out_stress"].shape[0] // (levels * pads)
    hang = sparse("interpolate", nodes, n * depths)
    contact = layer(z, "contact") + torch.cat([torch.log(d["carried"][:, :1] + 1e-4), d["carried"][:, 1:]], 1)
    contact = balanced(share(contact, n))
    force = torch.stack([contact[:, 1], contact[:, 2], -contact[:, 0]], 1).reshape(levels * pads, -1)
    force, (u_unit, s_unit) = d["scale"] * force, d["units"][0]
    given = (force @ d["response"] / u_unit).reshape(-1, 3)
    a, b, *shear = (force @ d["stress_response"] / s_unit).reshape(-1, 5).T
    bare = torch.sqrt(3 * (a * a + b * b + a * b + sum(c * c for c in shear)) + 1e-12)[:, None]
    return {
        "displacement": blocks(sparse("interpolate_free", nodes, n * depths), u) + given * blocks(hang, layer(z, "scale").reshape(-1, 3)),
        "stress": bare * blocks(hang, factor) + blocks(hang, more),
        "contact": contact,
        "travel": layer(y, "travel"),
        "motion": layer(y, "motion"),
    }


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
            h = h + mlp("block.node", h, receive(e, mesh, nodes, 1.0), receive(c, touching, nodes, 1.0))
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
    if name in ("travel", "motion"):  # corrections of what mechanics gives, 1 being usual in training: a good grasp needs almost none
        size = size.clamp(min=theirs.numel() ** 0.5)
    error = ((mine - theirs).norm() / size).item()
    print(f"{name}: {error:.1e} relative")
    worst = max(worst, error)
sys.exit(0 if worst < 1e-5 else 1)
