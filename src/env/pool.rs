//! The threads of a batch. A fork does not take them along, so a forked process starts its own.

use crate::error::{Error, Result};

/// Threads of the process that uses them.
pub(crate) struct Pool {
    threads: Option<usize>,
    /// The process that started them.
    owner: u32,
    pool: rayon::ThreadPool,
}

impl Pool {
    /// `threads` threads; None is as many as the machine has.
    ///
    /// # Errors
    /// When the system starts no more.
    pub fn new(threads: Option<usize>) -> Result<Self> {
        let mut pool = rayon::ThreadPoolBuilder::new();
        if let Some(threads) = threads {
            pool = pool.num_threads(threads.max(1));
        }
        let pool = pool.build().map_err(|e| Error::Start(format!("cannot start threads: {e}")))?;
        Ok(Self { threads, owner: std::process::id(), pool })
    }

    /// Does `work` on the threads.
    ///
    /// # Errors
    /// When a forked process can start none of its own.
    pub fn install<R: Send>(&mut self, work: impl FnOnce() -> R + Send) -> Result<R> {
        if self.owner != std::process::id() {
            let dead = std::mem::replace(self, Self::new(self.threads)?);
            // Ending threads that are not there might wait for them.
            std::mem::forget(dead);
        }
        Ok(self.pool.install(work))
    }
}
