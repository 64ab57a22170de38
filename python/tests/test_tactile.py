"""Tactile sensor outputs against independent evaluations: recorded 10-node tetrahedra, nodal forces, and a sphere."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

TACTUS = Path(__file__).parents[2] / "target" / "release" / "tactus"
ROWS, COLS, RADIUS = 31, 24, 0.02
GRID = f"(rows: {ROWS}, cols: {COLS})"
SCENE = f"""(
    object: (shape: Sphere(radius: {RADIUS})),
    gripper: (pads: GelSightMini(shape: SHAPE, spacing: 5e-3)),
    loading: Squeeze(force: 6.0, frames: 2, push: (force: (0, 1, 0), frames: 1)),
    record: (vtu: false, pictures: false,
        tactile: [HeightMap{GRID}, DepthMap{GRID}, Pressure{GRID}, Shear{GRID}, CenterOfPressure, Markers(pixel: 1e-4)]),
)"""


@pytest.fixture(scope="module", params=["Flat", "Domed"])
def arrays(request, tmp_path_factory):
    if not TACTUS.exists():
        pytest.skip("target/release/tactus is not built")
    folder = tmp_path_factory.mktemp("tactile")
    (folder / "scene.ron").write_text(SCENE.replace("SHAPE", request.param))
    subprocess.run([TACTUS, "run", folder / "scene.ron", "-o", folder / "run"], check=True, capture_output=True)
    with np.load(folder / "run/grasp_000/arrays.npz") as grasp, np.load(folder / "run/meshes.npz") as meshes:
        return {**grasp, **meshes}


def rotations(arrays):
    """Returns the rotations from each pad to the hand: (pads, 3, 3)."""
    w, x, y, z = arrays["pad_pose"][:, 3:].T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def in_pad(arrays, name):
    """Returns a recorded nodal vector in pad axes: (frames, pads, nodes, 3)."""
    pads = len(arrays["pad_pose"])
    values = arrays[name].reshape(len(arrays[name]), pads, -1, 3)
    return np.einsum("pji,fpnj->fpni", rotations(arrays), values)


def faces(arrays):
    """Returns the six nodes of each element face that is part of the sensing face."""
    sensing = set(arrays["pad/sensing"].ravel().tolist())
    found = []
    for tet in arrays["pad/tets"]:
        middle = {frozenset(pair): 4 + k for k, pair in enumerate([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])}
        for a, b, c in [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]:
            six = tet[[a, b, c, middle[frozenset((a, b))], middle[frozenset((b, c))], middle[frozenset((c, a))]]]
            if sensing.issuperset(six.tolist()):
                found.append(six)
    return np.array(found)


def shape(u, v):
    """Returns the shape functions of the 6-node triangle and their derivatives along u and v."""
    w = 1 - u - v
    values = [w * (2 * w - 1), u * (2 * u - 1), v * (2 * v - 1), 4 * w * u, 4 * u * v, 4 * v * w]
    along = [
        [1 - 4 * w, 4 * u - 1, 0 * u, 4 * (w - u), 4 * v, -4 * v],
        [1 - 4 * w, 0 * u, 4 * v - 1, -4 * u, 4 * u, 4 * (w - v)],
    ]
    return np.array(values), np.array(along)


def at(x, points):
    """Locates each point (n, 2) on faces with nodes `x` (faces, 6, 3): returns the index of the face and (u, v)."""
    face, place = np.full(len(points), -1), np.zeros((len(points), 2))
    for k, nodes in enumerate(x):
        uv = np.full((len(points), 2), 1 / 3)
        with np.errstate(all="ignore"):
            for _ in range(30):
                values, along = shape(*uv.T)
                off = points - values.T @ nodes[:, :2]
                jacobian = np.einsum("kin,id->ndk", along, nodes[:, :2])
                determinant = np.linalg.det(jacobian)
                inverse = np.array([[jacobian[:, 1, 1], -jacobian[:, 0, 1]], [-jacobian[:, 1, 0], jacobian[:, 0, 0]]])
                step = np.einsum("ijn,nj->ni", inverse / determinant, off)
                uv = np.clip(uv + step, -1, 2)
        values, _ = shape(*uv.T)
        near = np.linalg.norm(points - values.T @ nodes[:, :2], axis=1) < 1e-9
        inside = near & (uv.min(1) > -1e-7) & (uv.sum(1) < 1 + 1e-7) & (face < 0)
        face[inside], place[inside] = k, uv[inside]
    return face, place


def middles(arrays, rows, cols):
    rest = arrays["pad/rest_m"][np.unique(arrays["pad/sensing"]), :2]
    low, size = rest.min(0), np.ptp(rest, axis=0)
    x, y = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(cols) + 0.5) / cols, indexing="ij")
    return low + size * np.stack([x.ravel(), y.ravel()], 1), size


def test_the_height_map_is_that_of_the_nodes(arrays):
    six, (points, _) = faces(arrays), middles(arrays, ROWS, COLS)
    moved = arrays["pad/rest_m"] + in_pad(arrays, "displacement_m")
    compared = 0
    for frame, pad in np.ndindex(moved.shape[:2]):
        x = moved[frame, pad][six]
        face, place = at(x, points)
        height = np.einsum("in,ni->n", shape(*place.T)[0], x[face, :, 2])
        seen = arrays["height_map_m"][frame, pad].ravel()
        compared += (face >= 0).sum()
        assert np.abs(height - seen)[face >= 0].max() < 1e-8
    # A strip at the rim moves out of the grid or into it.
    assert compared > 0.95 * seen.size * moved.shape[0] * moved.shape[1]


def test_markers_are_points_of_the_elements(arrays):
    six, rest = faces(arrays), arrays["pad/rest_m"]
    markers = arrays["markers"]
    points, _ = middles(arrays, *markers.shape[2:4])
    face, place = at(rest[six], points)
    assert (face >= 0).all()
    weights = shape(*place.T)[0]
    displacement = in_pad(arrays, "displacement_m")
    for frame, pad in np.ndindex(displacement.shape[:2]):
        seen = markers[frame, pad].reshape(-1, 8)
        moved = np.einsum("in,nid->nd", weights, displacement[frame, pad][six][face])
        printed = np.einsum("in,nid->nd", weights, rest[six][face])
        assert np.abs(moved - seen[:, 3:6]).max() < 1e-8
        assert np.abs(printed + moved - seen[:, :3]).max() < 1e-8
        assert np.abs((printed + moved)[:, :2] / 1e-4 - seen[:, 6:]).max() < 1e-4


def test_traction_integrates_to_the_forces_of_the_nodes(arrays):
    _, size = middles(arrays, ROWS, COLS)
    area = size.prod() / (ROWS * COLS)
    force = in_pad(arrays, "contact_force_n").sum(2)
    wrench = np.einsum("pji,fpj->fpi", rotations(arrays), arrays["wrench"][..., :3])
    shear, pressure = arrays["shear_pa"].sum((2, 3)) * area, arrays["pressure_pa"].sum((2, 3)) * area
    for whole in (force, wrench):
        assert np.abs(np.concatenate([shear, -pressure[..., None]], 2) - whole).max() < 1e-5 * np.abs(whole).max()


def test_the_centre_of_pressure_is_that_of_the_nodes(arrays):
    pressing = np.maximum(-in_pad(arrays, "contact_force_n")[..., 2], 0)
    moved = arrays["pad/rest_m"] + in_pad(arrays, "displacement_m")
    center = (pressing[..., None] * moved).sum(2) / pressing.sum(2)[..., None]
    assert np.abs(center - arrays["center_of_pressure_m"]).max() < 1e-8


def test_the_depth_map_of_a_ball_is_a_cap(arrays):
    points, _ = middles(arrays, ROWS, COLS)
    turn, rest = rotations(arrays), arrays["pad/rest_m"]
    six = faces(arrays)
    face, place = at(rest[six], points)
    plane = np.einsum("in,ni->n", shape(*place.T)[0], rest[six][face, :, 2])
    pads = len(turn)
    carried = (arrays["position_m"] - arrays["displacement_m"]).reshape(-1, pads, len(rest), 3)[:, :, 0]
    for frame, pad in np.ndindex(carried.shape[:2]):
        origin = carried[frame, pad] - turn[pad] @ rest[0]
        ball = turn[pad].T @ (arrays["object_pose"][frame, :3] - origin)
        across = RADIUS**2 - ((points - ball[:2]) ** 2).sum(1)
        lowest = np.where(across > 0, ball[2] - np.sqrt(np.maximum(across, 0)), np.inf)
        seen = arrays["depth_map_m"][frame, pad].ravel()
        assert np.abs(np.maximum(plane - lowest, 0) - seen).max() < 1e-8
        assert seen.max() > 1e-4
