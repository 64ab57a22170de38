//! Processor time and peak memory of this process, where the operating system provides them.

/// Returns the processor time of all threads since the start of the process, user and system, s; None on systems other
/// than Unix.
pub fn processor_time() -> Option<f64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64)
    }
    #[cfg(not(unix))]
    None
}

/// Resets the peak resident memory that [`peak_memory`] reads, by `/proc/self/clear_refs`. Returns true if it was
/// reset; false on systems other than Linux.
pub fn reset_peak_memory() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// Returns the peak resident memory of the process since the last call of [`reset_peak_memory`], or else since its
/// start, bytes (`VmHWM` of `/proc/self/status`); None on systems other than Linux.
pub fn peak_memory() -> Option<u64> {
    status("VmHWM:")
}

/// Reads an entry of `/proc/self/status`, bytes.
fn status(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kb| 1024 * kb)
}
