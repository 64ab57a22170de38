//! Page: one HTML file with its style, its script and its data inside.

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
/// Parts of the script, in the order in which they depend on each other.
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

/// Content of the page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Sections with tables and charts, from the top.
    pub sections: Vec<Section>,
    /// Grasps in 3-D.
    pub recordings: Vec<Recording>,
}

/// Section about one folder.
#[derive(Debug, Clone)]
pub struct Section {
    /// Heading of the section.
    pub title: String,
    /// Introduction, a sentence or two.
    pub lead: String,
    /// Content of the section.
    pub blocks: Vec<PageBlock>,
}

/// Part of a section.
#[derive(Debug, Clone)]
pub enum PageBlock {
    /// Table.
    Table(Table),
    /// Chart that the page draws.
    Chart(Chart),
    /// Picture drawn earlier, SVG, with its description.
    Picture(String, String),
    /// Remark.
    Note(String),
}

impl Page {
    /// Returns the HTML file.
    ///
    /// # Errors
    /// Fails in the cases of [`Recording::json`].
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

    /// Returns the tables as Markdown, for a README.
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

/// Returns `text` with each `{{name}}` replaced, in one pass: replacements are not scanned again.
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
