//! Command line entry point.
use mimalloc::MiMalloc;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    // Zeroing huge pages, most of which is never used, takes as long as a prediction, and no solve is faster with them.
    // If the system refuses, only time is lost.
    #[cfg(target_os = "linux")]
    let _ = rustix::thread::disable_transparent_huge_pages(true);
    tactus::cli::main()
}
