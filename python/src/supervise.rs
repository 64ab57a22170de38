//! Execution of long work for Python in a separate thread without the GIL. An exception raised by a signal handler in
//! the meantime, e.g. by Ctrl-C, interrupts the work.

use crate::refusal::Refusal;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tactus::base::interrupt;

/// Interval between checks for signals.
const TICK: Duration = Duration::from_millis(50);
/// Maximum waiting time for interrupted work, which afterwards ends on its own.
const PATIENCE: Duration = Duration::from_millis(800);

/// Number of running works in a process. They share the interruption flag, which stays set until the last one has
/// ended.
struct Count {
    process: u32,
    works: usize,
}

static COUNT: Mutex<Count> = Mutex::new(Count { process: 0, works: 0 });

/// Returns the count of this process, reset after a fork, because a forked process inherits no work.
fn count() -> MutexGuard<'static, Count> {
    let mut count = COUNT.lock().unwrap_or_else(PoisonError::into_inner);
    if count.process != std::process::id() {
        *count = Count { process: std::process::id(), works: 0 };
        interrupt::clear();
    }
    count
}

/// Guard that counts one running work.
struct Work;

impl Work {
    /// Waits until all interrupted work has ended, then counts this one; None if it is `given_up` before.
    fn begin(given_up: &AtomicBool) -> Option<Self> {
        while !given_up.load(Ordering::SeqCst) {
            let mut count = count();
            if !interrupt::requested() {
                count.works += 1;
                return Some(Self);
            }
            drop(count);
            std::thread::sleep(Duration::from_millis(5));
        }
        None
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        let mut count = count();
        count.works = count.works.saturating_sub(1);
        if count.works == 0 {
            interrupt::clear();
        }
    }
}

/// Requests the interruption of all running work.
fn request() {
    if count().works > 0 {
        interrupt::request();
    }
}

/// Outcome of work.
enum Done<T> {
    Good(T),
    Refused(Refusal),
    Interrupted,
    Panicked(String),
}

/// Runs `work` in a new pool of `threads` threads; None if it brings its own threads.
///
/// # Errors
/// Fails with the exception of an error of `work`; with an exception raised by a signal handler; with
/// `KeyboardInterrupt` in threads other than the one that received the signal; with `RuntimeError` after a panic.
pub fn supervise<T, E>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Into<Refusal> + Send + 'static,
{
    watch(py, threads, |_| Ok(()), work)
}

/// Runs `work` like [`supervise`], and calls `look` in the thread of the caller while it runs, and once when it is
/// done.
///
/// # Errors
/// Fails like [`supervise`]; an exception in `look` also interrupts the work.
pub fn watch<'py, T, E>(
    py: Python<'py>,
    threads: Option<usize>,
    mut look: impl FnMut(Python<'py>) -> PyResult<()>,
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Into<Refusal> + Send + 'static,
{
    let given_up = Arc::new(AtomicBool::new(false));
    let (send, mut receive) = channel();
    let forsaken = given_up.clone();
    let run = move || {
        let Some(counted) = Work::begin(&forsaken) else { return };
        let done = match catch_unwind(AssertUnwindSafe(|| on_threads(threads, work))) {
            Ok(Ok(value)) => Done::Good(value),
            Ok(Err(_)) if interrupt::requested() => Done::Interrupted,
            Ok(Err(refusal)) => Done::Refused(refusal),
            Err(panic) => Done::Panicked(message(panic.as_ref())),
        };
        drop(counted);
        // The receiver is gone if the work ended too late.
        let _ = send.send(done);
    };
    let spawned = std::thread::Builder::new().name("tactus".into()).spawn(run);
    spawned.map_err(|e| PyRuntimeError::new_err(format!("cannot start a thread: {e}")))?;
    loop {
        let got;
        (receive, got) = py.detach(move || {
            let got = receive.recv_timeout(TICK);
            (receive, got)
        });
        match got {
            Ok(Done::Good(value)) => return look(py).map(|()| value),
            Ok(Done::Refused(refusal)) => return Err(refusal.into()),
            Ok(Done::Interrupted) => return Err(PyKeyboardInterrupt::new_err("interrupted")),
            Ok(Done::Panicked(message)) => {
                return Err(PyRuntimeError::new_err(format!("internal error of tactus: {message}")));
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("a thread of tactus ended unexpectedly"));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals().and_then(|()| look(py)) {
                    given_up.store(true, Ordering::SeqCst);
                    request();
                    let _ = py.detach(move || receive.recv_timeout(PATIENCE).is_ok());
                    return Err(raised);
                }
            }
        }
    }
}

fn on_threads<T: Send, E: Into<Refusal>>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> Result<T, Refusal> {
    let Some(threads) = threads else { return work().map_err(Into::into) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    let pool = pool.map_err(|e| format!("cannot start {threads} threads: {e}"))?;
    pool.install(|| work().map_err(Into::into))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}
