//! Command line entry point.
use mimalloc::MiMalloc;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    // Of huge pages most is cleared for nothing: that takes as long as a prediction, and no solve gets faster by them. Where it is
    // refused it only costs time.
    #[cfg(target_os = "linux")]
    let _ = rustix::thread::disable_transparent_huge_pages(true);
    tactus::cli::main()
}
