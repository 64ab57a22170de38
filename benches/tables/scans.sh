# Scanned objects with their own grasps

# Twenty grasps of each of sixteen objects of DefGraspSim and YCB, to 15 N in ten frames. The grasps are in
# `DATA/FOLDER/*_grasps.h5` next to a mesh; DATA is ../shared/data/objects by default. Grasps that start inside the
# object are excluded.

# Prints a scene with the grasps in the file $1 and the mesh next to it.
scan_scene() {
    local mesh=${1%_grasps.h5}_processed.stl
    [ -f "$mesh" ] || mesh=${1%_grasps.h5}.obj
    printf 'Scene(object: (shape: Mesh("%s")), grasps: File(path: "%s", select: 0..20), gripper: (pads: GelSightMini(spacing: 2.6e-3), opening: 0.08, stroke: 0.04, friction: 0.8), loading: Squeeze(force: 15.0, frames: 10), stepper: Fem(solver: Condensed(error: 0.01)))\n' \
        "$(realpath "$mesh")" "$(realpath "$1")"
}

scans() {
    local data=${DATA:-../shared/data/objects} file name
    [ -d "$data" ] || { echo "not measured: $data is not there"; return; }
    echo '| object | grasps | reached | dropped | no answer | iterations: median, 90 %, worst | wall time a grasp, s: median, worst |'
    echo '|---|---|---|---|---|---|---|'
    rm -f "$OUT"/scan_*.json
    for file in "$data"/*/*/*_grasps.h5; do
        name=$(basename "${file%_grasps.h5}" | tr -d _)
        scan_scene "$file" > "$OUT/scan.ron"
        tactus run "$OUT/scan.ron" -q --no-pictures --max-time "${MOST:-60}" --format json > "$OUT/scan_$name.json" 2> /dev/null || true
    done
    "$python" - "$OUT"/scan_*.json << 'END'
import json, re, sys
every = []
def row(name, grasps):
    grasps = [g for g in grasps if g["status"] != "infeasible"]
    count = lambda status: sum(g["status"] == status for g in grasps)
    at = lambda values, part: sorted(values)[min(int(part * len(values)), len(values) - 1)]
    iterations, wall = ([g[key] for g in grasps] for key in ("newton_iterations", "wall_s"))
    print(f"| {name} | {len(grasps)} | {count('reached')} | {count('dropped')} | {count('fault')} | "
          f"{at(iterations, 0.5)}, {at(iterations, 0.9)}, {max(iterations)} | {at(wall, 0.5):.1f}, {max(wall):.1f} |")
for path in sys.argv[1:]:
    grasps = json.load(open(path))["grasps"]
    row(re.sub(".*scan_(.*).json", r"\1", path), grasps)
    every += grasps
row("all", every)
END
    printf '\nA grasp that takes longer than %s s of wall time has no answer.\n' "${MOST:-60}"
}
