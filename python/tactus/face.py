"""PyTorch implementation of the face network, with the same weights and operations as `src/net/network/face.rs`.

`pad` and `grasp` are the arrays of `src/net/infer/inputs.rs`, those of `grasp` with the grasps as first dimension. `G`
grasps, `L` loads, `P` pads, `n` nodes per face and `N` nodes per pad of their canonical mesh.
"""

from __future__ import annotations

from typing import Mapping

import torch
from torch import Tensor, nn

Arrays = Mapping[str, Tensor]

# Typical number of neighbours of a node, by which sums of messages are divided.
USUAL = 6.0
# Constant added to the force fraction of each node before the logarithm.
LITTLE = 1e-4
# Constant added to the squared stress before the square root.
LEAST = 1e-12


def gated(z: Tensor) -> Tensor:
    return 0.5 * z * (1 + z / torch.sqrt(1 + z * z))


def positive(z: Tensor) -> Tensor:
    return 0.5 * (z + torch.sqrt(z * z + 1))


def hung(channels: Tensor, width: int, pad: Arrays) -> Tensor:
    """Interpolates the depth channels of a face (..., n, depths * width) to all nodes of the pad (..., N, width)."""
    channels = channels.reshape(*channels.shape[:-2], -1, width)
    index, weight = pad["hang"].unbind(1), pad["hang_weight"].unbind(1)
    return torch.stack([w[:, None] * channels[..., i, :] for i, w in zip(index, weight)]).sum(0)


def at_scene(displacement: Tensor, stress: Tensor, force: Tensor, pad: Arrays) -> tuple[Tensor, Tensor, Tensor]:
    """Transfers fields from the canonical nodes of the pads (..., N, 3), (..., N), (..., N, 3) to those of the mesh of the
    scene."""
    if "scene_nodes" not in pad:
        return displacement, stress, force
    index, weight = pad["scene_nodes"].unbind(1), pad["scene_weight"].unbind(1)
    moved = torch.stack([w[:, None] * displacement[..., i, :] for i, w in zip(index, weight)]).sum(0)
    stress = torch.stack([w * stress[..., i] for i, w in zip(index, weight)]).sum(0).clamp(min=0)
    to, source = pad["scene_forces"].unbind(1)
    parts = force[..., source, :] * pad["scene_fraction"][:, None]
    return moved * pad["scene_free"][:, None], stress, torch.zeros_like(moved).index_add(-2, to, parts)


class FaceNetwork(nn.Module):
    """Message passing on the sensing faces, evaluated once per grasp, and a decoder evaluated for each load."""

    def __init__(self, weights: Arrays) -> None:
        super().__init__()
        # PyTorch does not allow dots in parameter names.
        self.weights = nn.ParameterDict({name.replace(".", "_"): weight for name, weight in weights.items()})
        self.rounds = sum(name.endswith(".sender") for name in weights)

    def weight(self, name: str) -> Tensor:
        return self.weights[name.replace(".", "_")]

    def layer(self, x: Tensor, name: str) -> Tensor:
        return x @ self.weight(f"{name}.weight") + self.weight(f"{name}.bias")

    def norm(self, x: Tensor, name: str) -> Tensor:
        gain, shift = self.weight(f"{name}.gain")[0], self.weight(f"{name}.shift")[0]
        return nn.functional.layer_norm(x, x.shape[-1:], gain, shift, 1e-5)

    def pools(self, x: Tensor, pad: Arrays, grasp: Arrays, name: str) -> Tensor:
        """Pools node values (G, P, n, h) to pad values (G, P, h), from means over the own face and that of the other
        pad."""
        mean, near = (pad["mean"][:, None] * x).sum(2), (grasp["near"][..., None] * x).sum(2)
        z = mean @ self.weight(f"{name}.mean") + near @ self.weight(f"{name}.near") + self.weight(f"{name}.bias")
        if x.shape[1] == 2:
            z = z + mean.flip(1) @ self.weight(f"{name}.other_mean") + near.flip(1) @ self.weight(f"{name}.other_near")
        return gated(z)

    def encode(self, pad: Arrays, grasp: Arrays) -> tuple[Tensor, Tensor]:
        """Returns the latent features of nodes (G, P, n, decoder) and pads (G, P, decoder), computed once per grasp."""
        sender, receiver = pad["edges"].unbind(1)
        h = self.layer(grasp["node"], "start.node") + (grasp["pad"] @ self.weight("start.pad"))[:, :, None]
        for r in (f"round{k}" for k in range(self.rounds)):
            x = self.norm(h, f"{r}.norm")
            sent, own = x @ self.weight(f"{r}.sender"), x @ self.weight(f"{r}.receiver")
            message = gated(self.layer(pad["edge"], f"{r}.edge") + sent[:, :, sender] + own[:, :, receiver])
            message = torch.zeros_like(x).index_add(2, receiver, message) / USUAL
            pooled = self.pools(x, pad, grasp, f"{r}.pool") @ self.weight(f"{r}.global")
            inner = self.layer(x, f"{r}.own") + message @ self.weight(f"{r}.messages") + pooled[:, :, None]
            h = h + self.layer(gated(inner), f"{r}.out")
        h = self.norm(h, "last.norm")
        pooled = self.pools(h, pad, grasp, "last.pool")
        node = h @ self.weight("node.latent") + self.weight("node.bias")
        return node, pooled @ self.weight("pad.latent") + self.weight("pad.bias")

    def decode(self, pad: Arrays, grasp: Arrays, code: tuple[Tensor, Tensor]) -> dict[str, Tensor]:
        """Returns the prediction in network units: `displacement` (G, L, P, N, 3), `stress` (G, L, P, N), `contact`
        (G, L, P, n, 3): fraction of the normal force and friction along x and y; `travel` (G, L, P, 1), `motion`
        (G, L, P, 6)."""
        node, whole, at_pad = code[0][:, None], code[1][:, None], grasp["pad_load"]
        z = node + grasp["node_load"] @ self.weight("node.load") + (at_pad @ self.weight("node.pad_load"))[..., None, :]
        z = gated(z)
        z = z + self.layer(gated(self.layer(z, "node.inner")), "node.outer")
        y = gated(whole + at_pad @ self.weight("pad.load"))
        y = gated(self.layer(y, "pad.middle"))
        contact = self.contact(z, grasp)
        given, bare = self.response(contact, pad, grasp)
        # Multiplicative and additive corrections of the linear response.
        scale, beyond = (hung(self.layer(z, name), 3, pad) for name in ("scale", "displacement"))
        factor, more = (hung(positive(self.layer(z, name)), 1, pad).squeeze(-1) for name in ("factor", "stress"))
        return {
            "displacement": given * scale + pad["free"][:, None] * beyond,
            "stress": bare * factor + more,
            "contact": contact,
            "travel": self.layer(y, "travel"),
            "motion": self.layer(y, "motion"),
        }

    def contact(self, z: Tensor, grasp: Arrays) -> Tensor:
        """Returns the contact forces, predicted relative to the projected contact. For a free object, the residual of
        force and moment balance is removed by a correction of friction."""
        share, *along = grasp["carried"].unbind(-1)
        x = self.layer(z, "contact") + torch.stack([torch.log(share + LITTLE), *along], -1)
        s = torch.softmax(x[..., :1], -2)
        x = s * torch.cat([torch.ones_like(s), x[..., 1:]], -1)
        if "wrench" not in grasp:
            return x
        flat = x.flatten(2)[..., None]
        left = grasp["hangs"][..., None] - grasp["wrench"] @ flat
        return (flat + grasp["pull"].transpose(-1, -2) @ (grasp["inverse"] @ left)).reshape(x.shape)

    def response(self, contact: Tensor, pad: Arrays, grasp: Arrays) -> tuple[Tensor, Tensor]:
        """Returns the linear response of the pads in network units: displacement (G, L, P, N, 3) and von Mises stress
        (G, L, P, N)."""
        against, x, y = contact.unbind(-1)
        scale = grasp["pressing_n"] / (pad["young_pa"] * pad["thickness_m"] * grasp["depth_m"])
        force = scale[..., None] * torch.stack([x, y, -against], -1).flatten(3)
        length, stress = pad["units"].unbind()
        given = (force @ pad["response"] / length).unflatten(-1, (-1, 3))
        a, b, c, d, e = (force @ pad["stress_response"] / stress).unflatten(-1, (-1, 5)).unbind(-1)
        return given, torch.sqrt(3 * (a * a + b * b + a * b + c * c + d * d + e * e) + LEAST)

    def forward(self, pad: Arrays, grasp: Arrays) -> tuple[Tensor, Tensor, Tensor]:
        """Returns displacement, m (G, L, P, M, 3), von Mises stress, Pa (G, L, P, M), and contact force, N
        (G, L, P, M, 3), in the pad frames, at the `M` nodes of the mesh of the scene."""
        out = self.decode(pad, grasp, self.encode(pad, grasp))
        depth, (length, stress) = grasp["depth_m"][..., None], pad["units"].unbind()
        against, x, y = out["contact"].unbind(-1)
        force = torch.stack([x, y, -against], -1) * grasp["pressing_n"][..., None, None]
        displacement = out["displacement"] * (length * depth[..., None])
        stress = out["stress"] * (stress * pad["young_pa"] / pad["thickness_m"] * depth)
        return at_scene(displacement, stress, torch.zeros_like(displacement).index_add(3, pad["face"], force), pad)
