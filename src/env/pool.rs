//! Thread pool of a batch. A forked process does not inherit threads, so it starts its own.

use base::error::{Error, Result};

/// Thread pool that is recreated after a fork.
pub(crate) struct Pool {
    threads: Option<usize>,
    /// Id of the process that started the threads.
    owner: u32,
    pool: rayon::ThreadPool,
}

impl Pool {
    /// Starts `threads` threads; None starts one per processor.
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
            // Dropping the pool could block, because it joins threads that do not exist in this process.
            std::mem::forget(dead);
        }
        Ok(self.pool.install(work))
    }
}
