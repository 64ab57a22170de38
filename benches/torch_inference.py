"""Times of message passing and of all loads of a grasp in PyTorch (eager) and ONNX Runtime: same weights and graph.

usage: torch_inference.py MODEL_DIR FILE.npz [THREADS...]      FILE.npz is from `tactus eval DATASET --model MODEL_DIR --dump`

Needs torch, safetensors and numpy; onnx, onnxscript and onnxruntime for ONNX Runtime. `TACTUS_MODEL=MODEL_DIR cargo
bench --bench inference` times the engine of tactus; run both alternately on an otherwise idle machine.
"""

import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file

# Loads the file alone, without the compiled part of the package.
spec = spec_from_file_location("face", Path(__file__).parents[1] / "python" / "tactus" / "face.py")
face = module_from_spec(spec)
spec.loader.exec_module(face)
d = {k: torch.from_numpy(v.astype(np.int64) if v.dtype == np.uint32 else v) for k, v in np.load(sys.argv[2]).items()}
network, grasp = face.FaceNetwork(load_file(f"{sys.argv[1]}/weights.safetensors")), {k: v[None] for k, v in d.items()}
threads = [int(t) for t in sys.argv[3:]] or [1, 2]
levels = d["pad_load"].shape[0]


def timed(work, seconds=1.0):
    """Formats wall time and processor time of all threads; the latter is robust on a busy machine."""
    wall, processor, start = [], [], time.perf_counter()
    while len(wall) < 5 or time.perf_counter() - start < seconds:
        clocks = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - clocks[0])
        processor.append(time.process_time() - clocks[1])
    return f"best {1e3 * min(wall):.2f} ms (processor {1e3 * min(processor):.2f} ms), median {1e3 * float(np.median(wall)):.2f} ms"


class Pass(torch.nn.Module):
    """Message passing of a grasp as a module for export to ONNX."""

    def __init__(self):
        super().__init__()
        self.network = network

    def forward(self, node, pad, near):
        return self.network.encode(d, {"node": node, "pad": pad, "near": near})


with torch.inference_mode():
    code = network.encode(d, grasp)
    for name, mine in network.decode(d, grasp, code).items():
        theirs = d[f"out_{name}"]
        size = theirs.norm()
        if name in ("travel", "motion"):  # normalised corrections, as in tests/network/torch_check.py
            size = size.clamp(min=theirs.numel() ** 0.5)
        error = ((mine.reshape(theirs.shape) - theirs).norm() / size).item()
        assert error < 1e-5, f"{name} differs by {error}"
    for t in threads:
        torch.set_num_threads(t)
        m = torch.randn(1536, 384), torch.randn(384, 384)
        print(f"torch {torch.__version__}, {t} threads, sgemm: {timed(lambda: m[0] @ m[1], 0.5)}")
        print(f"torch {torch.__version__}, {t} threads, pass: {timed(lambda: network.encode(d, grasp))}")
        print(f"torch {torch.__version__}, {t} threads, {levels} loads: {timed(lambda: network.decode(d, grasp, code))}")

try:
    import onnxruntime
except ImportError:
    sys.exit("no onnxruntime: not compared")
names = ["node", "pad", "near"]
program = torch.onnx.export(Pass(), tuple(grasp[k] for k in names), input_names=names, dynamo=True, verbose=False)
feed = {k: grasp[k].numpy() for k in names}
for t in threads:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = t
    session = onnxruntime.InferenceSession(program.model_proto.SerializeToString(), options, providers=["CPUExecutionProvider"])
    error = np.abs(session.run(None, feed)[0] - code[0].numpy()).max() / np.abs(code[0].numpy()).max()
    assert error < 1e-4, f"onnxruntime differs by {error}"
    print(f"onnxruntime {onnxruntime.__version__}, {t} threads, pass: {timed(lambda: session.run(None, feed))}")
