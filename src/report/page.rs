//! Page: one HTML file with embedded style, script and data.

use super::chart::Chart;
use super::packed::base64;
use super::recording::Recording;
use base::error::{Error, Result};
use base::table::{Table, escape};
use record::render::colormap::color;
use serde_json::{Value, json};

const FRAME: &str = include_str!("page/page.html");
const VIEWER: &str = include_str!("page/viewer.html");
const STYLE: &str = include_str!("page/style.css");
/// Parts of the script, in order of dependence.
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

/// Part of the script that updates a served page.
const LIVE: &str = include_str!("page/live.js");

/// Content of the page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Sections with tables and charts, from the top.
    pub sections: Vec<Section>,
    /// Recordings of grasps for the 3-D viewer.
    pub recordings: Vec<Recording>,
}

/// Section for one result folder.
#[derive(Debug, Clone)]
pub struct Section {
    /// Heading of the section.
    pub title: String,
    /// Introductory sentences.
    pub lead: String,
    /// Content of the section.
    pub blocks: Vec<PageBlock>,
    /// Time of the results, s since 1970-01-01 UTC.
    pub modified: Option<u64>,
    /// Command and machine that produced the results; may be empty.
    pub origin_texts: Vec<String>,
}

impl Section {
    /// Creates a section without date and origin.
    pub fn new(title: impl Into<String>, lead: impl Into<String>, blocks: Vec<PageBlock>) -> Self {
        Self { title: title.into(), lead: lead.into(), blocks, modified: None, origin_texts: Vec::new() }
    }

    /// Returns the line on the origin of the section for the top of the page. The browser formats the date in the
    /// locale of the reader.
    fn origin(&self) -> String {
        let date = self.modified.map(|at| format!("<time data-at=\"{at}\"></time>"));
        let made = self.origin_texts.iter().map(|text| format!("<span>{}</span>", escape(text)));
        let origin: String = date.into_iter().chain(made).collect();
        format!("<p><strong>{}</strong>{origin}</p>\n", escape(&self.title))
    }
}

/// Part of a section.
#[derive(Debug, Clone)]
pub enum PageBlock {
    /// Table.
    Table(Table),
    /// Chart that the page draws.
    Chart(Chart),
    /// SVG picture from a file, with its caption.
    Picture(String, String),
    /// Remark.
    Note(String),
}

impl Page {
    /// Returns the self-contained HTML file.
    ///
    /// # Errors
    /// Fails in the cases of [`Recording::json`].
    pub fn html(&self) -> Result<String> {
        self.write(None)
    }

    /// Returns the page for a server. It polls the server for the state of the results, initially `state`, and replaces
    /// its content when the state changes.
    ///
    /// # Errors
    /// Fails in the cases of [`Recording::json`].
    pub fn live(&self, state: &str) -> Result<String> {
        self.write(Some(state))
    }

    fn write(&self, state: Option<&str>) -> Result<String> {
        let (mut charts, mut origins, mut body) = (Vec::new(), String::new(), String::new());
        for section in &self.sections {
            origins += &section.origin();
            body += &format!(
                "<section>\n<h2>{}</h2>\n<p class=\"lead\">{}</p>\n",
                escape(&section.title),
                escape(&section.lead)
            );
            for block in &section.blocks {
                body += &match block {
                    PageBlock::Table(table) => table.html(),
                    PageBlock::Note(text) => format!("<p class=\"note\">{}</p>\n", escape(text)),
                    // Embedded as an image, because an SVG from a file must not run scripts or load resources.
                    PageBlock::Picture(svg, about) => format!(
                        "<figure class=\"picture\"><img src=\"data:image/svg+xml;base64,{}\" alt=\"\"><figcaption>{}</figcaption></figure>\n",
                        base64(svg.as_bytes()),
                        escape(about)
                    ),
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
        let data =
            json!({ "charts": charts, "meshes": meshes, "grasps": grasps, "colors": base64(&colors), "state": state });
        let data =
            serde_json::to_string(&data).map_err(|e| Error::Start(format!("the page cannot be written: {e}")))?;
        let (connect, live, end) = match state {
            None => ("", "", "This file is self-contained; nothing is loaded from other sources."),
            Some(_) => ("; connect-src 'self'", LIVE, "It requests updates only from this machine."),
        };
        let parts = [
            ("style", STYLE.to_string()),
            ("connect", connect.to_string()),
            ("origins", origins),
            ("end", end.to_string()),
            ("version", env!("CARGO_PKG_VERSION").to_string()),
            ("viewer", if grasps.is_empty() { String::new() } else { VIEWER.to_string() }),
            ("sections", body),
            // Escaping `<` prevents the data from closing its script element.
            ("data", data.replace('<', "\\u003c")),
            ("script", SCRIPT.concat() + live),
        ];
        Ok(fill_template(FRAME, &parts))
    }

    /// Returns the tables that are not folded as Markdown, for a README.
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
fn fill_template(text: &str, parts: &[(&str, String)]) -> String {
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
