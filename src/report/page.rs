//! The page: one HTML file with its style, its script and its data inside.

use super::chart::Chart;
use super::packed::base64;
use super::recording::Recording;
use crate::error::{Error, Result};
use crate::render::colormap::color;
use crate::table::{Table, escape};
use serde_json::{Value, json};

const FRAME: &str = include_str!("page/page.html");
const VIEWER: &str = include_str!("page/viewer.html");
const STYLE: &str = include_str!("page/style.css");
/// The parts of the script, in the order in which they need each other.
const SCRIPT: [&str; 8] = [
    include_str!("page/data.js"),
    include_str!("page/matrix.js"),
    include_str!("page/shaders.js"),
    include_str!("page/scene.js"),
    include_str!("page/viewer.js"),
    include_str!("page/charts.js"),
    include_str!("page/controls.js"),
    include_str!("page/check.js"),
];

/// What is shown.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Tables and charts, from the top.
    pub sections: Vec<Section>,
    /// Grasps in 3-D.
    pub recordings: Vec<Recording>,
}

/// What one folder holds.
#[derive(Debug, Clone)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What it is about, in a sentence or two.
    pub lead: String,
    /// Its content.
    pub blocks: Vec<PageBlock>,
}

/// A part of a section.
#[derive(Debug, Clone)]
pub enum PageBlock {
    /// A table.
    Table(Table),
    /// A chart that the page draws.
    Chart(Chart),
    /// A picture drawn earlier, SVG, with what it shows.
    Picture(String, String),
    /// A remark.
    Note(String),
}

impl Page {
    /// The file.
    ///
    /// # Errors
    /// Those of [`Recording::json`].
    pub fn html(&self) -> Result<String> {
        let (mut charts, mut body) = (Vec::new(), String::new());
        for section in &self.sections {
            body += &format!(
                "<section>\n<h2>{}</h2>\n<p class=\"lead\">{}</p>\n",
                escape(&section.title),
                escape(&section.lead)
            );
            for block in &section.blocks {
                body += &match block {
                    PageBlock::Table(table) => table.html(),
                    PageBlock::Note(text) => format!("<p class=\"note\">{}</p>\n", escape(text)),
                    PageBlock::Picture(svg, about) => {
                        format!("<figure class=\"picture\">{svg}<figcaption>{}</figcaption></figure>\n", escape(about))
                    }
                    PageBlock::Chart(chart) => {
                        charts.push(chart);
                        format!("<figure class=\"chart\" data-chart=\"{}\"></figure>\n", charts.len() - 1)
                    }
                };
            }
            body += "</section>\n";
        }
        let mut meshes: Vec<Value> = Vec::new();
        let grasps = self.recordings.iter().map(|r| r.json(&mut meshes)).collect::<Result<Vec<_>>>()?;
        let colors: Vec<u8> = (0..256).flat_map(|i| color(f64::from(i) / 255.0).map(|c| c.round() as u8)).collect();
        let data = json!({ "charts": charts, "meshes": meshes, "grasps": grasps, "colors": base64(&colors) });
        let data =
            serde_json::to_string(&data).map_err(|e| Error::Start(format!("the page cannot be written: {e}")))?;
        let parts = [
            ("style", STYLE.to_string()),
            ("version", env!("CARGO_PKG_VERSION").to_string()),
            ("viewer", if grasps.is_empty() { String::new() } else { VIEWER.to_string() }),
            ("sections", body),
            // Nothing in the data may end its element.
            ("data", data.replace('<', "\\u003c")),
            ("script", SCRIPT.concat()),
        ];
        Ok(fill(FRAME, &parts))
    }

    /// The tables as Markdown, for a README.
    pub fn markdown(&self) -> String {
        let of = |section: &Section| {
            let tables = section.blocks.iter().filter_map(|block| match block {
                PageBlock::Table(table) if !table.folded => {
                    Some(format!("**{}**\n\n{}\n", table.title, table.markdown()))
                }
                _ => None,
            });
            format!("## {}\n\n{}", section.title, tables.collect::<String>())
        };
        self.sections.iter().map(of).collect()
    }
}

/// `text` with each `{{name}}` replaced, in one pass: what is filled in is not looked at again.
fn fill(text: &str, parts: &[(&str, String)]) -> String {
    let mut out = String::new();
    let mut pieces = text.split("{{");
    out += pieces.next().unwrap_or_default();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or(("", piece));
        out += parts.iter().find(|(n, _)| *n == name).map_or("", |(_, part)| part);
        out += rest;
    }
    out
}
