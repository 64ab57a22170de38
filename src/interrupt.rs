//! Stop flag of the process: long computations check it regularly, and end early with the finished part kept.
//!
//! The command line sets it on SIGINT and SIGTERM ([`on_signals`]), the Python package on an exception of a signal
//! handler. An unfinished grasp is dropped, never recorded as one that failed.

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Asks all work of this process to end.
pub fn request() {
    REQUESTED.store(true, Ordering::SeqCst);
}

/// Returns true if work is to end.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Resets the request, so that work may begin again after the interrupted work has ended.
pub fn clear() {
    REQUESTED.store(false, Ordering::SeqCst);
}

/// Checks that work may go on.
///
/// # Errors
/// Returns [`Error::Interrupted`] if work is to end.
pub fn check() -> Result<()> {
    if requested() { Err(Error::Interrupted("interrupted".into())) } else { Ok(()) }
}

/// Time after which an interrupted command is ended, s, if it does not check the flag.
const GRACE: Duration = Duration::from_secs(3);

/// Installs handlers by which SIGINT and SIGTERM request an end, even if they were ignored when the process began, as a shell without job
/// control has it for a command in the background; a second signal ends the process at once, with exit code
/// `code`. `GRACE` after the first the process ends in any case, after `last_words`: files appear whole or not at all,
/// whenever that is.
///
/// # Errors
/// Fails if the system installs no handler.
pub fn on_signals(code: u8, last_words: fn()) -> Result<()> {
    let cannot = |e: std::io::Error| Error::Start(format!("cannot listen for signals: {e}"));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // In this order: the first signal finds the flag not set.
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
