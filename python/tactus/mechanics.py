"""Mechanics of tactus as PyTorch functions, with first derivatives for autograd and `torch.func`."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from torch.autograd import Function
from torch.autograd.forward_ad import unpack_dual

from . import _tactus

# Number of differentiable parameters of a grasp: log force (1), friction (1), position (3) and rotation (3).
CHANGES = 8


class Look:
    """Evaluation of the network inputs of grasps.

    changes: indices (below `CHANGES`) of the parameters for which derivatives are computed.
    names: names of the arrays.
    grasp: indices (G) of the grasps that succeeded.
    failed: failure reasons of the others, by index.
    """

    def __init__(self, seen: _tactus.FaceInputs, changes: list[int]) -> None:
        self.seen, self.changes = seen, changes
        self.names: list[str] = []
        self.grasp: list[int] = []
        self.failed: dict[int, str] = {}

    def at(self, poses: Tensor, force: Tensor, friction: Tensor) -> list[tuple[str, Tensor, Tensor]]:
        """Returns names, arrays (G, ...) and their derivatives (G, changes, ...) for the grasps at `poses` (G, 7) under
        `force` (G, F) with `friction` (G), all float64 on the CPU. Raises ValueError if no grasp succeeds."""
        arrays = Looked.apply(poses, force, friction, self)
        half = len(self.names)
        return list(zip(self.names, arrays[:half], arrays[half:]))


class Looked(Function):
    """Arrays of a `Look`, then their derivatives; constants for autograd."""

    # The signature of PyTorch does not fix the arguments.
    @staticmethod
    def forward(poses: Tensor, force: Tensor, friction: Tensor, look: Look) -> tuple[Tensor, ...]:
        at, under, rubbing = (value.detach().contiguous().numpy() for value in (poses, force, friction))
        values, slopes, look.grasp, look.failed = look.seen.grasps(at, under, rubbing, look.changes)
        if not look.grasp:
            raise ValueError(f"no grasp has a prediction: {look.failed}")
        look.names = list(values)
        return tuple(torch.from_numpy(array) for array in (*values.values(), *(slopes[name] for name in values)))

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: tuple[Tensor, ...]) -> None:
        ctx.mark_non_differentiable(*output)
        ctx.arrays = len(output)

    @staticmethod
    def jvp(ctx: Any, *tangents: Tensor | None) -> tuple[None, ...]:
        return (None,) * ctx.arrays

    @staticmethod
    def vmap(
        info: Any, in_dims: tuple[Any, ...], poses: Tensor, force: Tensor, friction: Tensor, look: Look
    ) -> tuple[tuple[Tensor, ...], tuple[int, ...]]:
        """Evaluates the grasps of all examples in one batch."""
        n, given = info.batch_size, (poses, force, friction)
        rows = [x.expand(n, *x.shape) if dim is None else x.movedim(dim, 0) for x, dim in zip(given, in_dims)]
        # Under vmap it is unknown which parameters are differentiated.
        look.changes = list(range(CHANGES))
        arrays = Looked.apply(*(x.flatten(0, 1) for x in rows), look)
        if look.failed:
            raise ValueError(f"torch.func.vmap needs a prediction for every grasp; failed grasps by number: {look.failed}")
        look.grasp = look.grasp[: len(look.grasp) // n]
        return tuple(array.unflatten(0, (n, -1)) for array in arrays), (0,) * len(arrays)


class Once(Function):
    """Identity that can be differentiated once; raises RuntimeError for second derivatives."""

    generate_vmap_rule = True

    @staticmethod
    def forward(x: Tensor) -> Tensor:
        return x.clone()

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Tensor], output: Tensor) -> None:
        ctx.save_for_backward(*inputs)
        ctx.save_for_forward(*inputs)

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> Tensor:
        return Beside.apply(gradient, NoFurther.apply(*ctx.saved_tensors))

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor) -> Tensor:
        return Beside.apply(tangent, NoFurther.apply(*ctx.saved_tensors))


class Beside(Function):
    """Returns the first of two tensors, but also depends on the second with zero derivative."""

    generate_vmap_rule = True

    @staticmethod
    def forward(x: Tensor, beside: Tensor) -> Tensor:
        return x.clone()

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Tensor, Tensor], output: Tensor) -> None:
        pass

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, Tensor]:
        return gradient, torch.zeros_like(gradient)

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor, beside: Tensor | None) -> Tensor:
        return tangent.clone()


class NoFurther(Function):
    """Identity without derivatives; raises RuntimeError if it is differentiated."""

    generate_vmap_rule = True

    @staticmethod
    def forward(x: Tensor) -> Tensor:
        return x.clone()

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Tensor], output: Tensor) -> None:
        pass

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> Tensor:
        raise RuntimeError(SECOND)

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor) -> Tensor:
        raise RuntimeError(SECOND)


SECOND = (
    "there are no second derivatives with respect to poses, force and friction: Tactus computes first derivatives of its mechanics by central"
    " differences; "
    "take differences of the gradient, or differentiate with respect to the weights only: torch.autograd.grad(loss, network.parameters())"
)


def differentiated(value: Tensor) -> bool:
    """Returns True if `value` is differentiated in reverse or forward mode."""
    return (value.requires_grad and torch.is_grad_enabled()) or unpack_dual(value).tangent is not None


def changed(poses: Tensor, force: Tensor, friction: Tensor) -> Tensor:
    """Returns increments of the grasp parameters (G, F, CHANGES), with value zero but with first derivatives: of the
    logarithm of each force, of friction, and of position and rotation vector of the hand in the object frame."""
    position, rotation = poses[:, :3], poses[:, 3:] / poses[:, 3:].norm(dim=1, keepdim=True)
    (w, v), (w0, v0) = ((q[:, :1], q[:, 1:]) for q in (rotation, rotation.detach()))
    turn = 2 * (w0 * v - w * v0 - torch.linalg.cross(v, v0))
    grasp = torch.cat([friction[:, None], position, turn], 1)[:, None].expand(-1, force.shape[1], -1)
    all_ = torch.cat([torch.log(force)[..., None], grasp], 2)
    return Once.apply(all_ - all_.detach())
