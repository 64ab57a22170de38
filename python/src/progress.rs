//! Reporting in the thread of the caller during work: progress to a callback, messages to the logger `tactus`.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Log level of a message.
#[derive(Clone, Copy)]
pub enum Level {
    Info,
    Warning,
}

/// Progress and messages of running work.
#[derive(Default)]
pub struct Progress {
    done: AtomicUsize,
    of: AtomicUsize,
    notes: Mutex<Vec<(Level, String)>>,
}

impl Progress {
    /// Sets the total amount of work.
    pub fn expect(&self, of: usize) {
        self.of.store(of, Ordering::SeqCst);
    }

    /// Sets the amount of finished work.
    pub fn reach(&self, done: usize) {
        self.done.store(done, Ordering::SeqCst);
    }

    /// Increments the amount of finished work.
    pub fn advance(&self) {
        self.done.fetch_add(1, Ordering::SeqCst);
    }

    /// Adds a message.
    pub fn note(&self, level: Level, text: &str) {
        let text = text.strip_prefix("note: ").unwrap_or(text).to_string();
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).push((level, text));
    }

    /// Logs the pending messages, and calls `callback` with (done, total) if that has changed since `told`.
    pub fn tell(
        &self,
        py: Python<'_>,
        callback: Option<&Bound<'_, PyAny>>,
        told: &mut Option<(usize, usize)>,
    ) -> PyResult<()> {
        let notes = std::mem::take(&mut *self.notes.lock().unwrap_or_else(PoisonError::into_inner));
        if !notes.is_empty() {
            let logger = py.import("logging")?.call_method1("getLogger", ("tactus",))?;
            for (level, text) in notes {
                let method = match level {
                    Level::Info => "info",
                    Level::Warning => "warning",
                };
                // Passed as an argument, because the text may contain a percent sign.
                logger.call_method1(method, ("%s", text))?;
            }
        }
        let (done, of) = (self.done.load(Ordering::SeqCst), self.of.load(Ordering::SeqCst));
        match callback {
            Some(callback) if of > 0 && *told != Some((done, of)) => {
                *told = Some((done, of));
                callback.call1((done, of)).map(drop)
            }
            _ => Ok(()),
        }
    }
}
