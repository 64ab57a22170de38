//! Local page of results: the report of a folder, regenerated whenever the folder changes.
//!
//! ```text
//! browser -> server.rs: GET from this machine only -> content.rs: state of the folder, page of crate
//! ```

mod content;
mod server;

use crate::ReportOptions;
use base::error::Result;
use base::interrupt;
use content::Content;
use server::{Reply, Server};
use std::path::PathBuf;
use std::time::Duration;

/// Viewer of a folder; the server stops when it is dropped.
#[derive(Debug)]
pub struct Viewer {
    server: Server,
}

impl Viewer {
    /// Serves the results in `dir`, which need not exist yet, on the loopback address and `port`; 0 selects a free
    /// port.
    ///
    /// # Errors
    /// Fails if the port is in use, or if no thread can be started.
    pub fn start(dir: PathBuf, wishes: ReportOptions, port: u16) -> Result<Self> {
        let content = Content::new(dir, wishes);
        let answer = move |path: &str| match path {
            "/" => Some(Reply { kind: "text/html; charset=utf-8", body: content.page() }),
            "/state" => {
                let state = serde_json::json!({ "state": content.state() });
                Some(Reply { kind: "application/json", body: state.to_string() })
            }
            _ => None,
        };
        Ok(Self { server: Server::start(port, answer)? })
    }

    /// Returns the address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/", self.server.address())
    }

    /// Waits for an interruption.
    pub fn wait(&self) {
        while !interrupt::requested() {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}
