"""The same weights and graph in PyTorch (eager) and ONNX Runtime: what a pass and all loads of a grasp cost there.

usage: torch_inference.py MODEL_DIR FILE.npz [THREADS...]      FILE.npz is from `tactus eval DATASET --model MODEL_DIR --dump`

Needs torch, safetensors, numpy; onnx and onnxruntime where they are compared. `TACTUS_MODEL=MODEL_DIR cargo bench --bench
inference` times our side; run both in turns on a quiet machine.
"""

import io
import sys
import time

import numpy as np
import torch
from safetensors.torch import load_file

w = load_file(f"{sys.argv[1]}/weights.safetensors")
d = {k: torch.from_numpy(v.astype(np.int64) if v.dtype == np.uint32 else v) for k, v in np.load(sys.argv[2]).items()}
threads = [int(t) for t in sys.argv[3:]] or [1, 2]
pads, levels = d["pad"].shape[0], d["pad_load"].shape[0] // d["pad"].shape[0]
n = d["node"].shape[0] // pads
edges = torch.cat([d["edges"] + p * n for p in range(pads)])
nodes = d["out_stress"].shape[0] // (levels * pads)
depths = w["stress.weight"].shape[1]
balances = d["balance_load"].shape[0]
wrench, pull, inverse = (d[f"balance_{k}"].reshape(levels, 6, -1) for k in ("wrench", "pull", "inverse")) if balances else [None] * 3
pull = pull.transpose(1, 2).contiguous() if balances else None


def sparse(name, rows, cols):
    return torch.sparse_coo_tensor(d[f"{name}_at"].T, d[f"{name}_weight"][0], (rows, cols))


def gated(z):
    return 0.5 * z * (1 + z / torch.sqrt(1 + z * z))


def positive(z):
    return 0.5 * (z + torch.sqrt(z * z + 1))


class Pass(torch.nn.Module):
    """Message passing, once per grasp."""

    def __init__(self):
        super().__init__()
        self.mean, self.near = sparse("mean", pads, pads * n).to_dense(), sparse("near", pads, pads * n).to_dense()
        self.rounds = sum(k.endswith(".sender") for k in w)

    def pools(self, x, name):
        a, b = self.mean @ x, self.near @ x
        all_ = torch.cat([a, b, a.flip(0), b.flip(0)], 1)
        stacked = torch.cat([w[f"{name}.{k}"] for k in ("mean", "near", "other_mean", "other_near")])
        return gated(all_ @ stacked + w[f"{name}.bias"])

    def norm(self, x, name):
        return torch.nn.functional.layer_norm(x, x.shape[-1:], w[f"{name}.gain"][0], w[f"{name}.shift"][0], 1e-5)

    def forward(self, node, edge, pad):
        send, receive = edges[:, 0], edges[:, 1]
        h = node @ w["start.node.weight"] + w["start.node.bias"]
        h = h + (pad @ w["start.pad"]).repeat_interleave(n, 0)
        for r in (f"round{k}" for k in range(self.rounds)):
            x = self.norm(h, f"{r}.norm")
            m = edge @ w[f"{r}.edge.weight"] + w[f"{r}.edge.bias"]
            m = gated(m + (x @ w[f"{r}.sender"])[send] + (x @ w[f"{r}.receiver"])[receive])
            if torch.onnx.is_in_onnx_export():  # which knows no index_add
                m = torch.zeros_like(x).scatter_add(0, receive[:, None].expand_as(m), m) / 6.0
            else:
                m = torch.zeros_like(x).index_add(0, receive, m) / 6.0
            g = self.pools(x, f"{r}.pool") @ w[f"{r}.global"]
            inner = x @ w[f"{r}.own.weight"] + w[f"{r}.own.bias"] + m @ w[f"{r}.messages"]
            h = h + gated(inner + g.repeat_interleave(n, 0)) @ w[f"{r}.out.weight"] + w[f"{r}.out.bias"]
        h = self.norm(h, "last.norm")
        g = self.pools(h, "last.pool")
        return h @ w["node.latent"] + w["node.bias"], g @ w["pad.latent"] + w["pad.bias"]


class Loads(torch.nn.Module):
    """The decoder at all loads."""

    def __init__(self):
        super().__init__()
        self.hang = sparse("interpolate", nodes, n * depths).to_sparse_csr()
        self.free = sparse("interpolate_free", nodes, n * depths).to_sparse_csr()

    def spread(self, m, x):
        """m times every block of rows of x."""
        cols = x.shape[1]
        wide = x.reshape(levels * pads, n * depths, cols).permute(1, 0, 2).reshape(n * depths, -1)
        return (m @ wide).reshape(nodes, levels * pads, cols).permute(1, 0, 2).reshape(-1, cols)

    def forward(self, node, pad, at_node, at_pad):
        layer = lambda x, name: x @ w[f"{name}.weight"] + w[f"{name}.bias"]
        z = node.repeat(levels, 1) + at_node @ w["node.load"]
        z = gated(z + (at_pad @ w["node.pad_load"]).repeat_interleave(n, 0))
        y = gated(pad.repeat(levels, 1) + at_pad @ w["pad.load"])
        y = gated(layer(y, "pad.middle"))
        contact = layer(z, "contact") + torch.cat([torch.log(d["carried"][:, :1] + 1e-4), d["carried"][:, 1:]], 1)
        contact = contact.reshape(-1, n, 3)
        share = torch.softmax(contact[..., :1], 1)
        contact = (share * torch.cat([torch.ones_like(share), contact[..., 1:]], -1)).reshape(-1, 3)
        if balances:
            contact = contact.reshape(levels, -1, 1)
            contact = contact + pull @ (inverse @ (d["balance_load"][..., None] - wrench @ contact))
            contact = contact.reshape(-1, 3)
        force = torch.stack([contact[:, 1], contact[:, 2], -contact[:, 0]], 1).reshape(levels * pads, -1)
        force, (u_unit, s_unit) = d["scale"] * force, d["units"][0]
        given = (force @ d["response"] / u_unit).reshape(-1, 3)
        a, b, *shear = (force @ d["stress_response"] / s_unit).reshape(-1, 5).T
        bare = torch.sqrt(3 * (a * a + b * b + a * b + sum(c * c for c in shear)) + 1e-12)[:, None]
        u = self.spread(self.free, layer(z, "displacement").reshape(-1, 3))
        u = u + given * self.spread(self.hang, layer(z, "scale").reshape(-1, 3))
        factor, more = (self.spread(self.hang, positive(layer(z, k)).reshape(-1, 1)) for k in ("factor", "stress"))
        return u, bare * factor + more, contact, layer(y, "travel"), layer(y, "motion")


def timed(work, seconds=1.0):
    """Wall time, and processor time of all threads: the fair one on a busy machine."""
    wall, processor, start = [], [], time.perf_counter()
    while len(wall) < 5 or time.perf_counter() - start < seconds:
        clocks = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - clocks[0])
        processor.append(time.process_time() - clocks[1])
    return f"best {1e3 * min(wall):.2f} ms (processor {1e3 * min(processor):.2f} ms), median {1e3 * float(np.median(wall)):.2f} ms"


with torch.inference_mode():
    one, all_ = Pass(), Loads()
    inputs = d["node"], d["edge"].repeat(pads, 1) if d["edge"].shape[0] * pads == edges.shape[0] else d["edge"], d["pad"]
    code = one(*inputs)
    out = all_(*code, d["node_load"], d["pad_load"])
    for mine, name in zip(out, ("displacement", "stress", "contact", "travel", "motion")):
        theirs = d[f"out_{name}"]
        size = theirs.norm()
        if name in ("travel", "motion"):  # as in tests/network/torch_check.py: corrections, in units of what is usual
            size = size.clamp(min=theirs.numel() ** 0.5)
        error = ((mine - theirs).norm() / size).item()
        assert error < 1e-5, f"{name} differs by {error}"
    for t in threads:
        torch.set_num_threads(t)
        m = torch.randn(1536, 384), torch.randn(384, 384)
        print(f"torch {torch.__version__}, {t} threads, sgemm: {timed(lambda: m[0] @ m[1], 0.5)}")
        print(f"torch {torch.__version__}, {t} threads, pass: {timed(lambda: one(*inputs))}")
        print(f"torch {torch.__version__}, {t} threads, {levels} loads: {timed(lambda: all_(*code, d['node_load'], d['pad_load']))}")

try:
    import onnxruntime
except ImportError:
    sys.exit("no onnxruntime: not compared")
file = io.BytesIO()
torch.onnx.export(one, inputs, file, input_names=list("abc"), dynamo=False, opset_version=18)
feed = {k: v.numpy() for k, v in zip("abc", inputs)}
for t in threads:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = t
    session = onnxruntime.InferenceSession(file.getvalue(), options, providers=["CPUExecutionProvider"])
    error = np.abs(session.run(None, feed)[0] - code[0].numpy()).max() / np.abs(code[0].numpy()).max()
    assert error < 1e-4, f"onnxruntime differs by {error}"
    print(f"onnxruntime {onnxruntime.__version__}, {t} threads, pass: {timed(lambda: session.run(None, feed))}")
