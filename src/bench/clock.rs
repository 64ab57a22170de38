//! Time and memory of this process, where the system tells.

/// Processor time of all threads since the start of the process, user and system, s; None where unknown.
pub fn processor_time() -> Option<f64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64)
    }
    #[cfg(not(unix))]
    None
}

/// Memory that [`Memory::growth`] counts from.
#[derive(Debug, Clone, Copy)]
pub struct Memory(Option<u64>);

impl Memory {
    /// Forgets the peak so far (Linux: `/proc/self/clear_refs`), and notes what is resident now.
    pub fn mark() -> Self {
        let reset = std::fs::write("/proc/self/clear_refs", "5");
        Self(reset.ok().and_then(|()| status("VmRSS:")))
    }

    /// How far the resident memory rose above the mark at its peak, bytes; None where unknown.
    pub fn growth(self) -> Option<u64> {
        Some(status("VmHWM:")?.saturating_sub(self.0?))
    }
}

/// A line of `/proc/self/status`, bytes.
fn status(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kb| 1024 * kb)
}
