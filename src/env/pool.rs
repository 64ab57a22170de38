//! Threads of a batch. A forked process does not inherit them, so it starts its own.

use crate::error::{Error, Result};

/// Threads of the process that uses them.
pub(crate) struct Pool {
    threads: Option<usize>,
    /// Process that started them.
    owner: u32,
    pool: rayon::ThreadPool,
}

impl Pool {
    /// Starts `threads` threads; None starts as many as the machine has.
    ///
    /// # Errors
    /// Fails if the system cannot start them.
    pub fn new(threads: Option<usize>) -> Result<Self> {
        let mut pool = rayon::ThreadPoolBuilder::new();
        if let Some(threads) = threads {
            pool = pool.num_threads(threads.max(1));
        }
        let pool = pool.build().map_err(|e| Error::Start(format!("cannot start threads: {e}")))?;
        Ok(Self { threads, owner: std::process::id(), pool })
    }

    /// Runs `work` on the threads.
    ///
    /// # Errors
    /// Fails if a forked process cannot start its own threads.
    pub fn install<R: Send>(&mut self, work: impl FnOnce() -> R + Send) -> Result<R> {
        if self.owner != std::process::id() {
            let dead = std::mem::replace(self, Self::new(self.threads)?);
            // Ending threads that are not there might wait for them.
            std::mem::forget(dead);
        }
        Ok(self.pool.install(work))
    }
}
