"""Network in PyTorch: the predictions of `tactus.predict` with derivatives, on any device, and export to ONNX.

Tactus computes the mechanical inputs of the network (first contact, equilibrium on linear pads) and differentiates them
by central differences; the network itself and its derivatives are computed by PyTorch. There are thus first derivatives
with respect to poses, force and friction; second derivatives raise RuntimeError.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

try:
    import safetensors.torch
    import torch
except ImportError as missing:
    raise ImportError('tactus.torch needs PyTorch and safetensors: pip install "./python[torch]"') from missing
from torch import Tensor, nn

from . import _tactus
from .face import FaceNetwork
from .mechanics import Look, changed, differentiated
from .models import lasting

# Inputs of a grasp that do not depend on the load.
LOADLESS = ("node", "pad", "near")


class Answer(NamedTuple):
    """Predictions for the `G` successful grasps, in the pad frames: `F` loads, `P` pads, `n` nodes."""

    displacement_m: Tensor
    """(G, F, P, n, 3)"""
    von_mises_pa: Tensor
    """(G, F, P, n)"""
    contact_force_n: Tensor
    """(G, F, P, n, 3)"""
    grasp: list[int]
    """Numbers of the grasps (G)."""
    failed: dict[int, str]
    """Reasons of the grasps without an answer, by number."""


class Network(FaceNetwork):
    """Trained network. Its weights do not require gradients unless `requires_grad_()` is called."""

    def __init__(self, model: str | os.PathLike[str]) -> None:
        self.model = os.fspath(model)
        super().__init__(safetensors.torch.load(_tactus.face_weights(self.model)))
        self.requires_grad_(False)

    @classmethod
    def load(cls, model: str | os.PathLike[str] = "universe") -> Network:
        """Loads the network in the folder `model`, or the included one of this name."""
        return cls(model)

    def on(
        self,
        scene: str | os.PathLike[str],
        object: str | None = None,
        frames: int | None = None,
        extrapolate: bool = False,
        threads: int | None = None,
    ) -> SceneNetwork:
        """Returns the network for the object and the pads of a scene, for repeated use; arguments as of
        `tactus.predict`."""
        return SceneNetwork(self, scene, object, frames, extrapolate, threads)

    def answer(
        self,
        scene: str | os.PathLike[str],
        poses: Any = None,
        force: Any = None,
        friction: Any = None,
        **settings: Any,
    ) -> Answer:
        """Predicts the grasps of a scene once: :meth:`on` with these `settings`, then :meth:`SceneNetwork.forward`."""
        return self.on(scene, **settings)(poses, force, friction)


class SceneNetwork(nn.Module):
    """Network for the object and the pads of a scene. Copies and pickles store its weights and the path of the scene,
    which is read again."""

    def __init__(
        self,
        network: Network,
        scene: str | os.PathLike[str],
        object: str | None = None,
        frames: int | None = None,
        extrapolate: bool = False,
        threads: int | None = None,
    ) -> None:
        super().__init__()
        self.network = network
        rest = frames, extrapolate, threads or os.cpu_count() or 1
        self.seen = _tactus.FaceInputs(os.fspath(scene), object, network.model, *rest)
        # A copy may be created in another working directory.
        self.made = os.path.abspath(scene), object, lasting(network.model), *rest
        self.of_pad = nn.Module()
        for name, array in self.seen.pad().items():
            self.of_pad.register_buffer(name, torch.from_numpy(array))
        self.of_pad.to(network.weight("node.bias"))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "seen"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self.seen = _tactus.FaceInputs(*self.made)

    def forward(self, poses: Any = None, force: Any = None, friction: Any = None) -> Answer:
        """Predicts grasps at `poses` (G, 7), px py pz qw qx qy qz of the hand in the object frame, under `force` (F) or
        (G, F), N, sum over the fingers, with `friction`, a number or (G); None uses the values of the scene. The result
        is differentiable with respect to tensors that require gradients: each load to its own force, poses to all seven
        numbers. Raises ValueError if no grasp succeeds, or if a grasp fails under `torch.func.vmap`."""
        grasp, *which = self.inputs(poses, force, friction)
        return Answer(*self.network(self.pad(), grasp), *which)

    def pad(self) -> dict[str, Tensor]:
        """Returns the pad inputs of the network, on the device and in the precision of its weights."""
        own = self.network.weight("node.bias")
        # Not cached, because tensors created under `torch.func` are valid in one call only.
        moved = lambda array: array.to(own) if array.is_floating_point() else array.to(own.device)  # noqa: E731
        return {name: moved(array) for name, array in self.of_pad.named_buffers()}

    def inputs(
        self, poses: Any = None, force: Any = None, friction: Any = None
    ) -> tuple[dict[str, Tensor], list[int], dict[int, str]]:
        """Returns the grasp inputs of the network, as listed in `src/net/infer/inputs.rs`, and `grasp` and `failed` of
        :class:`Answer`."""
        usual = self.seen.usual()
        given = [usual[name] if value is None else value for name, value in zip(usual, (poses, force, friction))]
        # On the CPU, because some devices have no float64.
        poses, force, friction = (torch.as_tensor(value).cpu().double() for value in given)
        poses = poses.reshape(-1, poses.shape[-1])
        force, friction = force.reshape(1, -1) if force.dim() < 2 else force, friction.reshape(-1)
        for name, value in (("force", force), ("friction", friction)):
            if len(value) not in (1, len(poses)):
                raise ValueError(f"{name}: for {len(value)} grasps, and there are {len(poses)} poses; give one, or as many")
        force, friction = force.expand(len(poses), -1), friction.expand(len(poses))
        needed = (force, friction, *[poses] * 6)
        look = Look(self.seen, [k for k, value in enumerate(needed) if differentiated(value)])
        arrays = look.at(poses, force, friction)
        along = changed(poses[look.grasp], force[look.grasp], friction[look.grasp])[..., look.changes]
        return {name: self.moved(name, value, slope, along) for name, value, slope in arrays}, look.grasp, look.failed

    def moved(self, name: str, value: Tensor, slope: Tensor, along: Tensor) -> Tensor:
        """Returns an input as a linear function of the parameter increments `along` (G, F, changes)."""
        x, slope, along = (array.to(self.network.weight("node.bias")) for array in (value, slope, along))
        if not along.shape[-1]:
            return x
        if name in LOADLESS:
            return x + torch.einsum("gc...,gc->g...", slope, along[:, 0])
        return x + torch.einsum("gcf...,gfc->gf...", slope, along)

    def export(self, file: str | os.PathLike[str]) -> list[str]:
        """Exports the network for these pads to ONNX, for any number of grasps and loads. Returns the ordered names of
        its inputs, those of :meth:`inputs`. Its outputs are `displacement_m`, `von_mises_pa` and `contact_force_n`.
        Needs onnxscript."""
        with torch.no_grad():
            grasp, *_ = self.inputs()
        self.of_pad.to(self.network.weight("node.bias"))
        # The exporter would treat an axis of length one as constant.
        grasp = {k: v[:1].repeat(2, *[1] * (v.dim() - 1)) for k, v in grasp.items()}
        grasp = {k: v if k in LOADLESS else v[:, :1].repeat(1, 2, *[1] * (v.dim() - 2)) for k, v in grasp.items()}
        axes = dict(enumerate(map(torch.export.Dim, ("grasps", "loads"))))
        # The return type of PyTorch also covers the older exporter.
        program: Any = torch.onnx.export(
            OnPads(self, list(grasp)).eval(),
            tuple(grasp.values()),
            input_names=list(grasp),
            output_names=list(Answer._fields[:3]),
            dynamic_shapes=(tuple({0: axes[0]} if name in LOADLESS else axes for name in grasp),),
            dynamo=True,
            verbose=False,
        )
        program.save(os.fspath(file))
        return list(grasp)


class OnPads(nn.Module):
    """Network for given pads with positional arrays as inputs, for ONNX."""

    def __init__(self, on: SceneNetwork, names: list[str]) -> None:
        super().__init__()
        self.on, self.names = on, names

    def forward(self, *arrays: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        return self.on.network(dict(self.on.of_pad.named_buffers()), dict(zip(self.names, arrays)))
