//! Tables of text and numbers, formatted as HTML and Markdown.

/// Table whose first column is text and whose other columns are right-aligned numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Title of the table.
    pub title: String,
    /// Explanatory note; may be empty.
    pub note: String,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// Rows of cells, one per column.
    pub rows: Vec<Vec<String>>,
    /// True if the table is collapsed until the reader opens it.
    pub folded: bool,
}

impl Table {
    /// Returns a table with these columns and no rows yet.
    pub fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|c| c.to_string()).collect();
        Self { title: title.into(), columns, ..Self::default() }
    }

    /// Returns the table as HTML, with title and note, for a report page. Special characters are escaped.
    pub fn html(&self) -> String {
        let cells = |tag: &str, row: &[String]| -> String {
            let cell = |(k, text): (usize, &String)| match k {
                0 => format!("<th scope=\"{}\">{}</th>", if tag == "th" { "col" } else { "row" }, escape(text)),
                _ if tag == "th" => format!("<th scope=\"col\">{}</th>", escape(text)),
                // Padded numbers within a cell line up only with spaces as wide as digits.
                _ => format!("<td>{}</td>", escape(text).replace("  ", " \u{2007}")),
            };
            row.iter().enumerate().map(cell).collect()
        };
        let rows: String = self.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells("td", row))).collect();
        let note =
            if self.note.is_empty() { String::new() } else { format!("<p class=\"note\">{}</p>", escape(&self.note)) };
        let table = format!(
            "{note}<div class=\"wide\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
            cells("th", &self.columns)
        );
        let title = escape(&self.title);
        match self.folded {
            true => format!("<details><summary>{title}</summary>\n{table}</details>\n"),
            false => format!("<h3>{title}</h3>\n{table}"),
        }
    }

    /// Returns the columns and rows as a Markdown table, without title and note. Vertical bars in cells are escaped.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|c| c.trim().replace("  ", " ").replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}|{}\n{rows}", line(&self.columns), "---|".repeat(self.columns.len()))
    }
}

/// Returns `text` with `&`, `<`, `>` and `"` escaped for HTML, for use in elements and in quoted attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_leave_their_cell() {
        let mut table = Table::new("a & b", &["name", "N"]);
        table.rows.push(vec!["<script>|".into(), "1.0".into()]);
        let html = table.html();
        assert!(html.contains("a &amp; b") && html.contains("&lt;script&gt;") && !html.contains("<script>"));
        assert_eq!(table.markdown(), "| name | N |\n|---|---|\n| <script>\\| | 1.0 |\n");
    }
}
