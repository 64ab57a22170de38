//! Every link of a document leads to an existing file and heading.

use std::path::{Path, PathBuf};

/// Markdown files of the repository root, of `docs` and of `tests/data/reference`.
fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = [root.to_path_buf(), root.join("docs"), root.join("tests/data/reference")];
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    let mut found: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    found.sort();
    found
}

/// Text of a document without its code blocks.
fn prose(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n")
}

/// Anchors of the headings as on GitHub: lower case, no punctuation, hyphens for spaces; repeated ones end in `-1`,
/// `-2` and so on.
fn anchors(path: &Path) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for heading in prose(path).lines().filter(|line| line.starts_with('#')) {
        let title = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let numbered = (1..).map(|k| format!("{anchor}-{k}"));
        let free = std::iter::once(anchor.clone()).chain(numbered).find(|name| !found.contains(name));
        found.extend(free);
    }
    found
}

#[test]
fn every_link_leads_somewhere() {
    let mut dead = Vec::new();
    let mut count = 0;
    for document in documents() {
        let text = prose(&document);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '\n']).next()) {
            if link.contains("://") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { document.clone() } else { document.with_file_name(file) };
            let heading =
                || target.extension().is_some_and(|e| e == "md") && anchors(&target).iter().any(|a| a == anchor);
            if !target.exists() || !anchor.is_empty() && !heading() {
                dead.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(count > 100, "{count} links are found");
    assert!(dead.is_empty(), "these links lead nowhere:\n{}", dead.join("\n"));
}
