//! The processor that the program runs on.

/// Returns the name of the processor and the number of cores, as text.
pub fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    let cores = machine_threads();
    format!("{model}, {cores} core{}", if cores == 1 { "" } else { "s" })
}

/// Returns the number of hardware threads.
pub fn machine_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}
