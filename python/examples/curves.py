"""Learning curves and final returns: one panel for each folder of `ppo.py` or `stable_baselines.py`.

    python python/examples/curves.py out/ppo/hold out/ppo/squeeze out/ppo/regrasp -o ppo.png
"""

import argparse
import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

# Label and colour of each stage of training.
STAGES = {"network": ("training on the network", "C0"), "fem": ("training on finite elements", "C1")}


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def draw(folders, path):
    """Draws `curve.csv` and `judged_fem.csv` of each folder into the picture `path`."""
    figure, panels = plt.subplots(1, len(folders), figsize=(0.6 + 3.6 * len(folders), 3), squeeze=False)
    for axes, folder in zip(panels[0], folders):
        curve = rows(folder / "curve.csv")
        for stage, (label, colour) in STAGES.items():
            own = [(float(row["steps"]) / 1000, float(row["return"])) for row in curve if row["on"] == stage]
            if own:
                axes.plot(*zip(*own), color=colour, label=label)
        end = float(curve[-1]["steps"]) / 1000
        found = folder / "judged_fem.csv"
        judged = {row["policy"]: row for row in rows(found)} if found.exists() else {}
        constant = [float(row["return"]) for name, row in judged.items() if name.startswith("always")]
        for name, row in judged.items():
            if name == "random":
                axes.axhline(float(row["return"]), color="grey", ls=":", label="random, finite elements")
            elif not name.startswith("always"):
                deviation = float(row["standard_error"])
                axes.errorbar(end, float(row["return"]), deviation, fmt="ko", capsize=3, label=f"{name}, finite elements")
        if constant:
            axes.axhline(max(constant), color="k", ls="--", label="best constant force, finite elements")
        axes.set(title=folder.name, xlabel="steps, thousands")
    panels[0][0].set_ylabel("return of an episode")
    handles = {label: handle for axes in panels[0] for handle, label in zip(*axes.get_legend_handles_labels())}
    columns = 2 if len(folders) > 1 else 1
    lines = -(-len(handles) // columns)
    figure.set_figheight(2.8 + 0.2 * lines)
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncols=columns, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, (0.1 + 0.2 * lines) / figure.get_figheight(), 1, 1))
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("curves.png"))
    args = parser.parse_args()
    draw(args.folders, args.out)
