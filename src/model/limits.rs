//! Threads, memory and disk space: available amounts, and requirements of a scene. They are compared before anything
//! large is allocated or written, so that a scene that is too large is refused at once and no process is killed.

use base::error::{Error, Result};
use geometry::mesh::quadratic::midpoint_edges;
use geometry::pad::PadMesh;
use scene::{Element, Scene, StepperChoice};
use std::path::Path;

/// Size of one pad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PadSize {
    /// Number of nodes, mid-edge ones included.
    pub nodes: usize,
    /// Number of unknowns: three per node that is not bonded.
    pub unknowns: usize,
}

impl PadSize {
    /// Returns the size of a grid of `cells` cells of six tetrahedra each, whose lowest layer of nodes is bonded.
    pub fn of_cells(cells: [usize; 3], element: Element) -> Self {
        // Numbers of edges in a layer of nodes, and between two layers: along the axes, diagonals of faces, diagonals
        // of cells.
        let points = cells.map(|n| n as u128 + 1);
        let [x, y, z] = cells.map(|n| n as u128);
        let [px, py, pz] = points;
        let (flat, upright) = (x * py + y * px + x * y, px * py + x * py + y * px + x * y);
        let (nodes, bonded) = match element {
            Element::Linear => (px * py * pz, px * py),
            Element::Quadratic => (px * py * pz + flat * pz + upright * z, px * py + flat),
        };
        let count = |n: u128| usize::try_from(n).unwrap_or(usize::MAX);
        Self { nodes: count(nodes), unknowns: count(3 * (nodes - bonded)) }
    }

    /// Returns the size of a mesh.
    pub fn of_pad(pad: &PadMesh, element: Element) -> Self {
        let bonded = pad.bonded.iter().filter(|b| **b).count();
        let middles: Vec<[u32; 2]> = match element {
            Element::Linear => Vec::new(),
            Element::Quadratic => midpoint_edges(&pad.mesh),
        };
        let glued = middles.iter().filter(|e| e.iter().all(|n| pad.bonded[*n as usize])).count();
        let nodes = pad.mesh.nodes.len() + middles.len();
        Self { nodes, unknowns: 3 * (nodes - bonded - glued) }
    }

    /// Estimates the memory of the solver per pad of this size, bytes.
    fn solver_memory(&self) -> f64 {
        let factor = FACTOR_BYTES * (self.unknowns as f64).powf(FACTOR_POWER);
        factor + SOLVER_BYTES_PER_NODE * self.nodes as f64
    }
}

/// Memory of a Cholesky factor over `unknowns^FACTOR_POWER`, bytes. Both constants are fitted to presses of one pad:
/// 42, 133, 491 and 1366 MB with 5,100, 19,314, 54,390 and 107,604 unknowns, which the estimate reproduces to within a
/// sixth, the large ones to 5 %.
const FACTOR_BYTES: f64 = 60.0;
/// Exponent of the number of unknowns. It is asymptotically 4/3 for nested dissection in three dimensions; the factors
/// of plates of these sizes grow faster.
const FACTOR_POWER: f64 = 1.45;
/// Memory per node without the factor (mesh, stiffness, states), bytes.
const SOLVER_BYTES_PER_NODE: f64 = 3000.0;
/// Memory per node of a mesh without a solver, bytes.
const MESH_BYTES_PER_NODE: f64 = 2500.0;

/// Estimates the memory of a grasp of `scene` with pads of this size, bytes; `sides` is the number of its fingers.
pub fn estimate_memory(scene: &Scene, pad: PadSize, sides: usize) -> u64 {
    let each = match scene.stepper {
        StepperChoice::Fem(_) => pad.solver_memory(),
        StepperChoice::Gnn(_) => MESH_BYTES_PER_NODE * pad.nodes as f64,
    };
    (each * sides as f64).max(MESH_BYTES_PER_NODE * pad.nodes as f64) as u64
}

/// Refuses a scene that needs more memory than is free.
///
/// # Errors
/// Returns [`Error::Mesh`] with the sizes and the remedy.
pub fn check_memory(need: u64, pad: PadSize) -> Result<()> {
    match free_memory() {
        Some(free) if need > free => Err(Error::Mesh(format!(
            "pads of {} nodes, {} unknowns each, need about {} of memory, but only {} are free; use a larger spacing",
            pad.nodes,
            pad.unknowns,
            format_bytes(need),
            format_bytes(free)
        ))),
        _ => Ok(()),
    }
}

/// Refuses files that need more space than is free at `dir`, which need not exist yet.
///
/// # Errors
/// Returns [`Error::File`] with the sizes and the remedy.
pub fn check_disk_space(need: u64, dir: &Path) -> Result<()> {
    match free_disk(dir) {
        Some(free) if need > free => {
            let message = format!(
                "the data set needs up to {}, but only {} are free there; choose another folder, fewer grasps or fewer \
                 frames",
                format_bytes(need),
                format_bytes(free)
            );
            Err(Error::file(dir, message))
        }
        _ => Ok(()),
    }
}

/// Formats a size as text.
pub fn format_bytes(n: u64) -> String {
    let n = n as f64;
    match n {
        n if n >= 1e12 => format!("{:.1} TB", n / 1e12),
        n if n >= 1e9 => format!("{:.1} GB", n / 1e9),
        n => format!("{:.0} MB", n / 1e6),
    }
}

/// Returns the memory that this process can still allocate, bytes: the minimum of what the machine, its control groups
/// and its own limit leave; None if the system does not provide it.
#[cfg(target_os = "linux")]
pub fn free_memory() -> Option<u64> {
    [available(), control_group::free(), address_space()].into_iter().flatten().min()
}

/// Returns None, because this system does not provide the available memory.
#[cfg(not(target_os = "linux"))]
pub fn free_memory() -> Option<u64> {
    None
}

/// Returns the free space at `dir`, which need not exist yet, bytes; None if the system does not provide it.
#[cfg(unix)]
pub fn free_disk(dir: &Path) -> Option<u64> {
    let absolute = std::path::absolute(dir).ok()?;
    let stat = absolute.ancestors().find_map(|dir| rustix::fs::statvfs(dir).ok())?;
    Some(stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// Returns None, because this system does not provide the free space.
#[cfg(not(unix))]
pub fn free_disk(_: &Path) -> Option<u64> {
    None
}

/// Returns the memory that the kernel can provide without swapping.
#[cfg(target_os = "linux")]
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb << 10)
}

/// Returns the memory below the limit of the address space (`ulimit -v`).
#[cfg(target_os = "linux")]
fn address_space() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split(' ').next()?.parse().ok()?;
    Some(limit.saturating_sub(pages * rustix::param::page_size() as u64))
}

/// Control groups of this process, of either version.
#[cfg(target_os = "linux")]
mod control_group {
    use std::path::{Path, PathBuf};

    /// Mount point of the hierarchy of a version, and its files: the limit, the memory in use, and the key of the
    /// reclaimable part in `memory.stat`.
    struct Version {
        root: &'static str,
        limit: &'static str,
        taken: &'static str,
        cached: &'static str,
    }

    const V2: Version =
        Version { root: "/sys/fs/cgroup", limit: "memory.max", taken: "memory.current", cached: "inactive_file" };
    const V1: Version = Version {
        root: "/sys/fs/cgroup/memory",
        limit: "memory.limit_in_bytes",
        taken: "memory.usage_in_bytes",
        cached: "total_inactive_file",
    };

    /// Returns the smallest amount left by any group up to the root.
    pub fn free() -> Option<u64> {
        let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
        groups.lines().filter_map(of_line).min()
    }

    /// Parses a line `0::/path`, or `4:memory:/path` of version 1.
    fn of_line(line: &str) -> Option<u64> {
        let mut parts = line.splitn(3, ':');
        let (number, controllers, path) = (parts.next()?, parts.next()?, parts.next()?);
        let version = match (number, controllers) {
            ("0", "") => V2,
            (_, controllers) if controllers.split(',').any(|c| c == "memory") => V1,
            _ => return None,
        };
        let root = Path::new(version.root);
        // In a container, its own group may be the root of the mounted hierarchy.
        let own: PathBuf = root.join(path.trim_start_matches('/'));
        own.ancestors().take_while(|dir| dir.starts_with(root)).filter_map(|dir| version.free_in_group(dir)).min()
    }

    impl Version {
        fn free_in_group(&self, dir: &Path) -> Option<u64> {
            let number = |file: &str| std::fs::read_to_string(dir.join(file)).ok()?.trim().parse::<u64>().ok();
            let (limit, taken) = (number(self.limit)?, number(self.taken)?);
            let stat = std::fs::read_to_string(dir.join("memory.stat")).unwrap_or_default();
            let cached = stat.lines().find_map(|l| l.strip_prefix(self.cached)?.strip_prefix(' ')?.parse().ok());
            Some(limit.saturating_sub(taken.saturating_sub(cached.unwrap_or(0))))
        }
    }
}
