//! Stop flag of the process: long computations poll it and end early, keeping the finished part.
//!
//! The command line sets it on SIGINT and SIGTERM ([`on_signals`]), the Python package when a signal handler raises an
//! exception. An unfinished grasp is discarded, never recorded as failed.

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Sets the stop flag: requests that all long computations of this process end.
pub fn request() {
    REQUESTED.store(true, Ordering::SeqCst);
}

/// Returns true if the stop flag is set.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Clears the stop flag, so that new computations may begin after the interrupted ones have ended.
pub fn clear() {
    REQUESTED.store(false, Ordering::SeqCst);
}

/// Checks that the stop flag is not set.
///
/// # Errors
/// Fails with [`Error::Interrupted`] if it is set.
pub fn check() -> Result<()> {
    if requested() { Err(Error::Interrupted("interrupted".into())) } else { Ok(()) }
}

/// Time from a request until the process is ended, even if its work does not poll the flag, s.
const GRACE: Duration = Duration::from_secs(3);

/// Installs handlers with which SIGINT and SIGTERM set the stop flag, even if they were ignored when the process began
/// (a shell without job control ignores them for background commands). A second signal ends the process at once, with
/// exit code `code`. If the process still runs 3 s after the first signal, it calls `last_words` (to print a final
/// message) and exits with `code`; files are written atomically, so this leaves none incomplete.
///
/// # Errors
/// Fails if a handler or the watching thread cannot be created.
pub fn on_signals(code: u8, last_words: fn()) -> Result<()> {
    let cannot = |e: std::io::Error| Error::Start(format!("cannot listen for signals: {e}"));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // The order matters: at the first signal, the shutdown handler must find the flag unset.
        signal_hook::flag::register_conditional_shutdown(signal, code.into(), REQUESTED.clone()).map_err(cannot)?;
        signal_hook::flag::register(signal, REQUESTED.clone()).map_err(cannot)?;
    }
    let watch = move || {
        let mut since: Option<Instant> = None;
        while since.is_none_or(|since| since.elapsed() < GRACE) {
            std::thread::sleep(Duration::from_millis(100));
            since = since.or_else(|| requested().then(Instant::now));
        }
        last_words();
        std::process::exit(code.into());
    };
    std::thread::Builder::new().name("signals".into()).spawn(watch).map(|_| ()).map_err(cannot)
}
