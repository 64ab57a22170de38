//! Long work for Python: on a thread of its own, without the interpreter's lock. What a signal handler raises in the
//! meantime, as Ctrl-C does, ends it.

use crate::refusal::Refusal;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tactus::interrupt;

/// How often signals are looked at.
const TICK: Duration = Duration::from_millis(50);
/// How long work that was asked to end is waited for; after that it ends alone.
const PATIENCE: Duration = Duration::from_millis(800);

/// Work under way in a process. The stop flag is for all of it: it stands until the last one has ended.
struct Count {
    process: u32,
    works: usize,
}

static COUNT: Mutex<Count> = Mutex::new(Count { process: 0, works: 0 });

/// The count of this process: a fork takes no work along.
fn count() -> MutexGuard<'static, Count> {
    let mut count = COUNT.lock().unwrap_or_else(PoisonError::into_inner);
    if count.process != std::process::id() {
        *count = Count { process: std::process::id(), works: 0 };
        interrupt::clear();
    }
    count
}

/// Counts as work under way.
struct Work;

impl Work {
    /// Begins, once all that was asked to end has ended; None if this one is `given_up` before.
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

/// Asks what is under way to end.
fn request() {
    if count().works > 0 {
        interrupt::request();
    }
}

/// How work went.
enum Done<T> {
    Good(T),
    Refused(Refusal),
    Interrupted,
    Panicked(String),
}

/// Does `work`, on `threads` threads of its own where it does not bring any.
///
/// # Errors
/// The exception of what `work` refuses; what a signal handler raises; `KeyboardInterrupt` in threads beside the one that
/// a signal came to; `RuntimeError` for a mistake of tactus itself.
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

/// Does `work` as [`supervise`] does, and calls `look` in the caller's thread while it lasts, and once more when it is done.
///
/// # Errors
/// As [`supervise`]; what `look` raises ends the work, too.
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
        // Nobody listens any more to what ended too late.
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
                return Err(PyRuntimeError::new_err(format!("tactus has made a mistake: {message}")));
            }
            Err(RecvTimeoutError::Disconnected) => return Err(PyRuntimeError::new_err("a thread of tactus is lost")),
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
