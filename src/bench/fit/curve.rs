//! Measured curve: a CSV table of depth and force.

use base::error::{Error, Result};
use base::files::regular;
use base::number::{format_count, format_number};
use scene::leaf::{Length, Positive};
use std::path::Path;

/// Columns of the table.
const HEADER: [&str; 2] = ["depth_m", "force_n"];
/// Largest file that is read, bytes.
const MAX_SIZE: u64 = 1 << 20;
/// Smallest number of points: any single parameter fits one point exactly, which is no evidence.
const MIN_POINTS: usize = 2;

/// Force against depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Depth after first contact, m, increasing, and normal force on the pad, N.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// Reads a table with the header `depth_m,force_n`; lines that start with `#` are comments.
    ///
    /// # Errors
    /// Fails, with `file:line`, for an entry that is not a number, not positive, or not deeper than the line before;
    /// also for another header and for fewer than two points.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = regular::read(path, MAX_SIZE)?;
        let at = |line: u64, message: String| Error::file(format!("{}:{line}", path.display()), message);
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(&bytes[..]);
        let broken = |e: csv::Error| at(e.position().map_or(1, csv::Position::line), "is not UTF-8 text".into());
        let header = reader.headers().map_err(broken)?;
        if header.iter().ne(HEADER) {
            let found: Vec<&str> = header.iter().take(4).collect();
            let message = format!("the header must be `depth_m,force_n`, found `{}`", clipped(&found.join(",")));
            return Err(at(header.position().map_or(1, csv::Position::line), message));
        }
        let mut points: Vec<(f64, f64)> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(1, csv::Position::line);
            let [depth, force] = row(&record).map_err(|m| at(line, m))?;
            if let Some((before, _)) = points.last().filter(|(before, _)| depth <= *before) {
                let message =
                    format!("depths must increase: {} m after {} m", format_number(depth), format_number(*before));
                return Err(at(line, message));
            }
            points.push((depth, force));
        }
        if points.len() < MIN_POINTS {
            let message = format!("has {}; a fit needs at least {MIN_POINTS}", format_count(points.len(), "point"));
            return Err(Error::file(path, message));
        }
        Ok(Self { points })
    }
}

/// Parses depth, m, and force, N, of a line. The error states what is wrong with it.
fn row(record: &csv::StringRecord) -> std::result::Result<[f64; 2], String> {
    let [depth, force] = record.iter().collect::<Vec<_>>()[..] else {
        return Err(format!("a line is `depth,force`: two numbers, found {}", record.len()));
    };
    let number = |name: &str, text: &str| {
        text.parse::<f64>().map_err(|_| format!("{name} must be a number, found `{}`", clipped(text)))
    };
    let told = |name: &str, message: String| format!("{name} {}", message.replace('\n', "; "));
    let depth = Length::new(number("depth_m", depth)?).map_err(|m| told("depth_m", m))?;
    let force = Positive::new(number("force_n", force)?).map_err(|m| told("force_n", m))?;
    Ok([depth.get(), force.get()])
}

/// Returns the first 40 characters of a text.
fn clipped(text: &str) -> String {
    text.chars().take(40).collect()
}
