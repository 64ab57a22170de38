"""GelSight images from the height maps of a run: three lights on the deformed gel, by Lambert's law.

    tactus run scenes/photometric.ron -o out/photometric
    python python/examples/photometric.py out/photometric

A real sensor is calibrated by a table from the slope of the gel to colour, measured with a ball of known size; here the
table is computed from the directions of the lights. To imitate a particular sensor, replace this table.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Azimuth of the red, green and blue light about z of the pad, and their elevation above the gel, degrees.
AROUND, ABOVE = (0.0, 120.0, 240.0), 25.0
AMBIENT, BRIGHTNESS = 0.25, 0.8
# Largest slope of the table, and number of slopes along x and y.
STEEPEST, STEPS = 1.5, 257
# Width of the lens blur, m; it smooths the jumps of the gel's slope between elements.
BLUR = 0.4e-3


def table():
    """Returns the colour of a gel by its slopes along x and y: (steps, steps, 3)."""
    slopes = np.linspace(-STEEPEST, STEEPEST, STEPS)
    along_x, along_y = np.meshgrid(slopes, slopes, indexing="ij")
    normal = np.stack([-along_x, -along_y, np.ones_like(along_x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    around, above = np.radians(AROUND), np.radians(ABOVE)
    # The lights are next to the camera, behind the gel.
    to_light = np.stack([np.cos(around) * np.cos(above), np.sin(around) * np.cos(above), np.full(3, np.sin(above))])
    return AMBIENT + BRIGHTNESS * np.maximum(normal @ to_light, 0)


def blurred(values, widths):
    """Returns the values (rows, cols) blurred by a Gaussian of these widths, in pixels."""
    for axis, width in enumerate(widths):
        reach = int(np.ceil(3 * width))
        weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
        padded = np.pad(values, [(reach, reach) if k == axis else (0, 0) for k in range(2)], mode="edge")
        values = np.apply_along_axis(np.convolve, axis, padded, weights / weights.sum(), mode="valid")
    return values


def photograph(height, size, colours):
    """Returns the camera image of a height map (rows, cols) in m over a face of `size` m: (rows, cols, 3), 0 to 1."""
    spacing = [length / count for length, count in zip(size, height.shape)]
    slopes = np.gradient(blurred(height, [BLUR / length for length in spacing]), *spacing)
    slopes = np.stack(slopes, -1)
    index = np.rint((slopes / STEEPEST + 1) / 2 * (STEPS - 1)).astype(int).clip(0, STEPS - 1)
    return colours[index[..., 0], index[..., 1]].clip(0, 1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("run", type=Path, help="folder of a run that records `HeightMap`, and `Markers` if these are to be drawn")
    parser.add_argument("--frame", type=int, default=-1)
    parser.add_argument("--out", type=Path, default=Path("photometric.png"))
    args = parser.parse_args()
    with np.load(args.run / "grasp_000" / "arrays.npz") as arrays:
        maps = arrays["height_map_m"][args.frame]
        markers = arrays["markers"][args.frame] if "markers" in arrays else None
    with np.load(args.run / "meshes.npz") as meshes:
        size = np.ptp(meshes["pad/rest_m"][np.unique(meshes["pad/sensing"]), :2], axis=0)
    colours = table()
    figure, panels = plt.subplots(1, len(maps), figsize=(4.6 * len(maps), 4), squeeze=False, layout="constrained")
    for pad, (panel, height) in enumerate(zip(panels[0], maps)):
        low, high = -500 * size, 500 * size
        image = photograph(height, size, colours)
        panel.imshow(image, origin="lower", extent=[low[1], high[1], low[0], high[0]])
        if markers is not None:
            dots = markers[pad].reshape(-1, markers.shape[-1]) * 1e3
            panel.plot(dots[:, 1], dots[:, 0], "o", color="black", markersize=3.5)
        panel.set(title=("left", "right")[pad], xlabel="y, mm", ylabel="x, mm")
    figure.savefig(args.out, dpi=110)


if __name__ == "__main__":
    main()
