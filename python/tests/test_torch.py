"""The network in PyTorch and in ONNX Runtime against the Rust engine."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import tactus

torch = pytest.importorskip("torch", reason="PyTorch is not installed")
pytest.importorskip("safetensors", reason="safetensors is not installed")

import tactus.torch  # noqa: E402

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenes"
FIELDS = tactus.torch.Answer._fields[:3]
# Thickness of a pad and distance of its farthest node from the origin of the hand, m: scales of position and rotation.
THICKNESS, FARTHEST = 4e-3, 0.107


CUDA = pytest.param("cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="PyTorch has no CUDA here"))


@pytest.fixture(scope="module", params=["cpu", CUDA])
def network(request):
    return tactus.torch.Network.load("universe").to(request.param)


def worst(mine, theirs):
    """Returns the largest error of a grasp relative to the norm of its field."""
    mine, theirs = (np.asarray(torch.as_tensor(x).cpu(), dtype=np.float64).reshape(len(x), -1) for x in (mine, theirs))
    return (np.linalg.norm(mine - theirs, axis=1) / np.linalg.norm(theirs, axis=1)).max()


@pytest.mark.parametrize("name", tactus.load(SCENES / "paper.ron").objects)
def test_fields_of_fifty_grasps_are_those_of_the_engine_within_1e_4(network, name):
    on = network.on(SCENES / "paper.ron", object=name, frames=3)
    poses = on.seen.usual()["poses"][:5]
    many = tactus.predict(SCENES / "paper.ron", object=name, poses=poses, frames=3)
    answer = on(poses)
    assert answer.grasp == many.grasp.tolist() and list(answer.failed) == list(many.failed)
    for field, mine in zip(FIELDS, answer):
        assert mine.dtype == torch.float32 and worst(mine, getattr(many, field)) < 1e-4, field


def turned(pose, by):
    """Returns a pose (7) rotated by the small rotation vector `by` about axes of the object frame, to first order."""
    (w, v), half = (pose[3:4], pose[4:]), 0.5 * by
    turn = torch.cat([w - (half * v).sum(), v + half * w + torch.linalg.cross(half, v)])
    return torch.cat([pose[:3], turn])


def scene(path, force, friction):
    path.write_text(
        "(object: (shape: Ellipsoid(radii: (0.035, 0.025, 0.02))), gripper: (pads: GelSightMini(spacing: 2.9e-3),"
        f" friction: {friction:.15f}), loading: Squeeze(force: {force:.15f}, frames: 1))"
    )
    return path


def drawn(seed):
    """Draws force, friction, and a perturbed pose around that with the object's centre 0.1 m in front of the hand."""
    draw = np.random.default_rng(seed)
    turn = np.array([1.0, *draw.normal(0, 0.1, 3)])
    turn /= np.linalg.norm(turn)
    w, v, reach = turn[0], turn[1:], np.array([0, 0, 0.1])
    middle = reach + 2 * np.cross(v, np.cross(v, reach) + w * reach)
    pose = torch.from_numpy(np.concatenate([draw.normal(0, 2e-3, 3) - middle, turn]))
    return draw.uniform(8, 14), draw.uniform(0.5, 1.0), pose


def moved(pose, by):
    """Returns the pose after a translation and a rotation (6)."""
    return turned(torch.cat([pose[:3] + by[:3], pose[3:]]), by[3:])


def jacobian(on, force, friction, pose, scales):
    """Returns derivatives of each field (8, numbers) by force, friction, position and rotation over their scales."""
    x = torch.zeros(8, dtype=torch.float64, requires_grad=True)
    by = x * torch.from_numpy(scales)
    answer = on(moved(pose, by[2:])[None], (force + by[0])[None], friction + by[1])
    fields = []
    for field in answer[:3]:
        # Forward-mode derivatives by two backward passes.
        ones = torch.zeros_like(field, requires_grad=True)
        (back,) = torch.autograd.grad(field, x, ones, create_graph=True)
        forth = [torch.autograd.grad(value, ones, retain_graph=True)[0].flatten() for value in back]
        fields.append(torch.stack(forth).cpu().numpy())
    return fields


def differences(path, force, friction, pose, scales, step):
    """Returns central differences of the engine's fields (8, numbers) with the same scales, and the fields."""

    def predicted(force, friction, poses):
        many = tactus.predict(scene(path, force, friction), poses=np.stack(poses))
        assert many.failed == {}
        return [getattr(many, field).astype(np.float64).reshape(len(poses), -1) for field in FIELDS]

    steps = np.diag(scales * step)
    hands = [moved(pose, torch.from_numpy(side * row[2:])) for row in steps[2:] for side in (-1, 1)]
    parts = [predicted(force + side * steps[0, 0], friction, [pose]) for side in (-1, 1)]
    parts += [predicted(force, friction + side * steps[1, 1], [pose]) for side in (-1, 1)]
    parts += [predicted(force, friction, hands)]
    fields = [np.concatenate(field) for field in zip(*parts)]
    return [(field[1::2] - field[::2]) / (2 * step) for field in fields], fields


def test_derivatives_are_those_of_the_engine_within_1e_3(network, tmp_path):
    """Compares derivatives with central differences of `tactus.predict` at three steps. Errors are relative to the
    derivative, or to the field if that is larger: predictions are float32, so that small derivatives are lost in
    rounding. Predictions are piecewise smooth: where the slopes of the three steps differ by more than rounding, there
    is a kink or a jump and no derivative. Most directions are smooth."""
    steps = (2e-4, 3.5e-4, 5e-4)
    straight = np.zeros(8, dtype=int)
    seeds = (0, 4, 5)
    for seed in seeds:
        force, friction, pose = drawn(seed)
        scales = np.array([force, friction, *[THICKNESS] * 3, *[THICKNESS / FARTHEST] * 3])
        mine = jacobian(network.double().on(scene(tmp_path / "s.ron", force, friction)), force, friction, pose, scales)
        network.float()
        several = [differences(tmp_path / "s.ron", force, friction, pose, scales, step) for step in steps]
        smooth = np.ones(8, dtype=bool)
        errors = []
        for k, ours in enumerate(mine):
            slopes = np.stack([slopes[k] for slopes, _ in several])
            line = np.average(slopes, axis=0, weights=np.square(steps))
            size = np.maximum(np.linalg.norm(line, axis=1), np.linalg.norm(several[0][1][k][0]))
            smooth &= (np.linalg.norm(slopes - line, axis=2) < 1.3e-3 * size).all(0)
            errors.append(np.linalg.norm(ours - line, axis=1) / size)
        straight += smooth
        assert (np.array(errors)[:, smooth] < 1e-3).all(), f"seed {seed}: {np.array(errors)}, smooth {smooth}"
    assert straight.sum() > 0.5 * 8 * len(seeds) and (straight > 0).all(), straight


def test_each_load_answers_to_its_own_force_and_each_grasp_to_its_own_friction(network):
    on = network.on(SCENES / "lemon.ron")
    poses = on.seen.usual()["poses"]
    force = torch.tensor([[4.0, 8.0], [5.0, 10.0]], requires_grad=True)
    friction = torch.tensor([0.6, 0.9], requires_grad=True)
    answer = on(poses, force, friction)
    by_force, by_friction = torch.autograd.grad(answer.displacement_m[0, 1].square().sum(), (force, friction))
    assert (by_force != 0).tolist() == [[False, True], [False, False]]
    assert (by_friction != 0).tolist() == [True, False]
    alone = on(poses[1:], [5.0, 10.0], 0.9)
    assert torch.allclose(alone.contact_force_n[0], answer.contact_force_n[1], rtol=1e-4, atol=1e-6)
    pressed = answer.contact_force_n.sum(3)[..., 2].abs()
    assert torch.allclose(pressed, (force[..., None] / 2).to(pressed), rtol=1e-4)


def test_a_quaternion_may_have_any_length(network):
    on = network.on(SCENES / "lemon.ron", frames=1)
    pose = torch.tensor([[0, 0, -0.1, 2.0, 0.1, 0, 0.2]], dtype=torch.float64, requires_grad=True)
    loss = on(pose).displacement_m.square().sum()
    (by_pose,) = torch.autograd.grad(loss, pose)
    along = (by_pose[0, 3:] * pose[0, 3:]).sum().abs()
    assert along < 1e-6 * by_pose[0, 3:].norm() * pose[0, 3:].norm(), "its length changes nothing"


@pytest.fixture(scope="module")
def lemon(tmp_path_factory):
    """Returns a network in float64 for a lemon between coarse pads, under two loads."""
    path = tmp_path_factory.mktemp("lemon") / "lemon.ron"
    path.write_text(
        "(object: (shape: Lemon(length: 0.06, diameter: 0.044)), gripper: (pads: GelSightMini(spacing: 2.9e-3)),"
        " loading: Squeeze(force: 10, frames: 2))"
    )
    return tactus.torch.Network.load("universe").double().on(path)


POSES = torch.tensor([[0, 0, -0.1, 1, 0, 0, 0], [5e-4, 3e-4, -0.1, 1, 0, 0, 0]], dtype=torch.float64)
FORCE = torch.tensor([4.0, 7.0], dtype=torch.float64)


def test_second_derivatives_by_a_grasp_are_refused_and_those_by_the_weights_are_right(lemon):
    force = FORCE.clone().requires_grad_()
    loss = lambda: lemon(POSES[:1], force).contact_force_n[..., 2].square().sum()  # noqa: E731
    (slope,) = torch.autograd.grad(loss(), force, create_graph=True)
    with pytest.raises(RuntimeError, match="no second derivatives with respect to poses, force and friction"):
        torch.autograd.grad(slope.sum(), force)
    with pytest.raises(RuntimeError, match="no second derivatives"):
        torch.autograd.functional.hessian(lambda f: lemon(POSES[:1], f).contact_force_n.square().sum(), FORCE)
    for transform in (torch.func.hessian, lambda f: torch.func.jacfwd(torch.func.jacfwd(f)), lambda f: torch.func.grad(torch.func.grad(f))):
        with pytest.raises(RuntimeError, match="no second derivatives"):
            transform(lambda f: lemon(POSES[:1], FORCE * f).contact_force_n.square().sum())(torch.tensor(1.0).double())
    # Derivatives by the weights do not involve the mechanics: they agree with a central difference of the slope to
    # 1e-6.
    weight = lemon.network.weight("node.bias").requires_grad_()
    try:
        (slope,) = torch.autograd.grad(loss(), force, create_graph=True)
        (by_weight,) = torch.autograd.grad(slope.sum(), weight)
        along = torch.randn(weight.shape, dtype=weight.dtype, generator=torch.Generator().manual_seed(0))
        beside = []
        for step in (-1e-4, 1e-4):
            with torch.no_grad():
                weight += step * along
            beside.append(torch.autograd.grad(loss(), force)[0].sum())
            with torch.no_grad():
                weight -= step * along
        by_difference = (beside[1] - beside[0]) / 2e-4
        assert abs((by_weight * along).sum() / by_difference - 1) < 1e-6, "of the derivative"
    finally:
        weight.requires_grad_(False)


def test_torch_func_gives_what_autograd_gives(lemon):
    answers = lemon(POSES, FORCE)
    mapped = torch.func.vmap(lambda pose: lemon(pose[None], FORCE).displacement_m[0])(POSES)
    assert torch.allclose(mapped, answers.displacement_m, rtol=1e-12, atol=0)
    far = torch.cat([POSES[:1], POSES[:1] + torch.tensor([0, 0, 10.0, 0, 0, 0, 0])])
    with pytest.raises(ValueError, match="vmap needs a prediction for every grasp"):
        torch.func.vmap(lambda pose: lemon(pose[None], FORCE).displacement_m)(far)

    def shear(force):
        return lemon(POSES[:1], force).contact_force_n[0, :, :, :, :2].square().sum((1, 2, 3))

    rows = torch.autograd.functional.jacobian(shear, FORCE)
    assert (rows.diagonal() != 0).all()
    for transform in (torch.func.jacrev, torch.func.jacfwd):
        assert torch.allclose(transform(shear)(FORCE), rows, rtol=1e-9, atol=1e-15), transform

    def travelled(pose):
        return lemon(pose[None], FORCE[:1]).displacement_m.square().sum()

    each = torch.func.vmap(torch.func.grad(travelled))(POSES)
    inner = torch.func.grad(lambda poses: torch.func.vmap(travelled)(poses).sum())(POSES)
    alone = [torch.autograd.grad(travelled(pose), pose)[0] for pose in POSES.clone().requires_grad_().unbind()]
    assert torch.allclose(each, torch.stack(alone), rtol=1e-9) and torch.allclose(inner, each, rtol=1e-9)
    with torch.autograd.forward_ad.dual_level():
        dual = torch.autograd.forward_ad.make_dual(FORCE, torch.ones_like(FORCE))
        tangent = torch.autograd.forward_ad.unpack_dual(shear(dual)).tangent
    assert torch.allclose(tangent, rows.sum(1), rtol=1e-9), "forward mode, too"
    fresh = copy.deepcopy(lemon)
    fresh.network.float()
    torch.func.jacrev(lambda force: fresh(POSES[:1], force).displacement_m.sum())(FORCE)
    assert torch.allclose(pickle.loads(pickle.dumps(fresh))(POSES, FORCE).displacement_m.double(), answers.displacement_m, rtol=1e-3, atol=1e-9), (
        "nothing of a call is left behind"
    )


def test_it_is_copied_and_pickled_with_its_weights(lemon, tmp_path, monkeypatch):
    with torch.no_grad():
        other = copy.deepcopy(lemon)
        other.network.weight("node.bias").add_(0.1)
    monkeypatch.chdir(tmp_path)
    for on in (lemon, other):
        again = pickle.loads(pickle.dumps(on))
        assert torch.equal(again(POSES, FORCE).displacement_m, on(POSES, FORCE).displacement_m)
    assert not torch.equal(other(POSES, FORCE).displacement_m, lemon(POSES, FORCE).displacement_m)


def test_a_folder_is_loaded_as_the_name_is(network):
    folder = tactus.torch.Network.load(ROOT / "models" / "universe")
    for (name, mine), (_, other) in zip(folder.named_parameters(), network.named_parameters()):
        assert torch.equal(mine.cpu(), other.cpu()), name
    with pytest.raises(FileNotFoundError, match="a model is created by"):
        tactus.torch.Network.load("nowhere")


def test_what_cannot_be_answered_says_why(network):
    on = network.on(SCENES / "lemon.ron", frames=1)
    here, far = [0, 0, -0.1, 1, 0, 0, 0], [0, 0, 10, 1, 0, 0, 0]
    answer = on([far, here])
    assert answer.grasp == [1] and list(answer.failed) == [0]
    for wrong, why in (
        ({"poses": [far]}, "no grasp has an answer"),
        ({"poses": [[0, 0, 0]]}, "7 finite numbers"),
        ({"poses": [here], "force": [-1.0]}, "a force of -1 N"),
        ({"poses": [here], "friction": 3.0}, "friction is 3, the training range is"),
        ({"poses": [here], "friction": [0.8] * 3}, "friction: for 3 grasps"),
    ):
        with pytest.raises(ValueError, match=why):
            on(**wrong)


def test_onnx_runtime_gives_the_same_fields_within_1e_4(network, tmp_path):
    for package in ("onnx", "onnxscript", "onnxruntime"):
        pytest.importorskip(package, reason=f"{package} is not installed")
    import onnxruntime

    on = network.on(SCENES / "lemon.ron", frames=3)
    names = on.export(tmp_path / "universe.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "universe.onnx", providers=["CPUExecutionProvider"])
    # Other numbers of grasps and loads than those of the export.
    poses = on.seen.usual()["poses"][[0, 1, 1]]
    for force in ([6.0], [3.0, 6.0, 9.0, 12.0, 15.0]):
        seen, *_ = on.inputs(poses, force)
        out = session.run(list(FIELDS), {name: seen[name].cpu().numpy() for name in names})
        for field, mine, theirs in zip(FIELDS, out, on(poses, force)):
            assert mine.shape == theirs.shape and worst(mine, theirs) < 1e-4, field
    many = tactus.predict(SCENES / "lemon.ron", frames=3)
    seen, *_ = on.inputs()
    for field, mine in zip(FIELDS, session.run(list(FIELDS), {name: seen[name].cpu().numpy() for name in names})):
        assert worst(mine, getattr(many, field)) < 1e-4, field
