//! `docs/scene-reference.md` is made from the schema: every field with its type, default and meaning.
//!
//! `TACTUS_WRITE_DOCS=1 cargo test --release --test scenes reference::` writes it anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Struct or enum of the schema.
#[derive(Default)]
struct Item {
    is_enum: bool,
    docs: String,
    /// Name, type (of a variant: what it holds), default, meaning.
    fields: Vec<[String; 4]>,
    /// Missing fields take their defaults from the struct.
    defaulted: bool,
}

fn schema_files(dir: &Path) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found.into_iter().flat_map(|path| if path.is_dir() { schema_files(&path) } else { vec![path] }).collect()
}

/// Value of a default as a scene writes it: `Positive::preset(1.0)` is 1.
fn value(code: &str) -> String {
    let code = code.trim().trim_end_matches([',', ';']);
    if code.ends_with("::ALL.to_vec()") {
        return "all".into();
    }
    if code == "Vec::new()" {
        return "empty".into();
    }
    let inner = ["Tuple([", "::preset(", "::preset3(", "::preset_size("].iter().find_map(|mark| code.split_once(mark));
    match inner {
        Some((_, rest)) => {
            let close = rest.rfind([')', ']']).unwrap_or(rest.len());
            let text = rest[..close].trim_end_matches(']');
            let numbers: Vec<_> =
                text.split(", ").map(|n| if n.contains("::preset(") { value(n) } else { number(n) }).collect();
            if numbers.len() > 1 { format!("({})", numbers.join(", ")) } else { numbers.concat() }
        }
        None => code.rsplit("::").next().unwrap_or(code).to_string(),
    }
}

/// A literal without the digits that say nothing.
fn number(text: &str) -> String {
    text.parse::<f64>().map_or(text.to_string(), |v| format!("{v}"))
}

/// What may be written for a type of the schema.
fn kind(name: &str) -> String {
    let inside = |wrapper: &str| name.strip_prefix(wrapper).and_then(|rest| rest.strip_suffix('>'));
    if let Some(of) = inside("Option<") {
        return format!("{}, optional", kind(of));
    }
    if let Some(of) = inside("Vec<") {
        return format!("list: {}", kind(of));
    }
    if let Some(range) = inside("Count<") {
        return format!("whole number, {}", range.replace(", ", " to "));
    }
    match name {
        "Positive" => "number above 0",
        "NonNegative" => "number from 0",
        "Finite" => "number",
        "Length" => "length above 0, m",
        "Depth" => "length from 0, m",
        "Fraction" => "above 0, at most 1",
        "Ratio" => "1 to 20",
        "Seconds" => "time above 0, s",
        "Modulus" => "stiffness, Pa",
        "Poisson" => "above -1, below 0.5",
        "Vec3" | "Direction" => "(x, y, z)",
        "Vec2" => "(x, y)",
        "Size" => "(x, y, z), m",
        "Cells" => "(x, y, z), whole numbers",
        "Span" => "(least, most)",
        "String" | "Reason" => "text",
        "(String, String)" => "two texts",
        "PathBuf" => "path",
        "usize" => "whole number from 0",
        "usize, usize" => "two whole numbers from 0",
        "bool" => "true or false",
        other => return format!("[`{}`](#{})", shown(other), shown(other).to_lowercase()),
    }
    .into()
}

/// Name of a type in messages and in this page: that of the scene, where the code has another one.
fn shown(name: &str) -> &str {
    match name {
        "ObjectShape" => "Shape",
        "ObjectMotion" => "Motion",
        "MaterialChoice" => "Material",
        "StepperChoice" => "Stepper",
        "HoldReward" => "Reward: Hold",
        "SlipReward" => "Reward: Slip",
        "StressReward" => "Reward: Stress",
        "EconomyReward" => "Reward: Economy",
        "Motion" => "Motion of the hand",
        other => other,
    }
}

/// All types of the schema.
fn items() -> BTreeMap<String, Item> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scene");
    let texts: Vec<_> = schema_files(&dir).iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    // Constants by name, and by the function that serde calls.
    let (mut constants, mut functions) = (BTreeMap::new(), BTreeMap::new());
    for line in texts.iter().flat_map(|text| text.lines()) {
        let Some((head, code)) = line.trim().split_once(" = ") else { continue };
        let Some((name, _)) = head.split_once(':') else { continue };
        let (name, function) = name.split_once(" (").map_or((name, None), |(n, f)| (n, Some(f.trim_end_matches(')'))));
        if name.chars().all(|c| c.is_ascii_uppercase() || c == '_' || c.is_ascii_digit()) {
            constants.insert(name.to_string(), value(code));
            function.map(|f| functions.insert(f.to_string(), value(code)));
        }
    }
    let of_code = |code: &str| {
        let code = code.trim().trim_end_matches(',');
        match code.strip_prefix("defaults::") {
            Some(name) => constants.get(name).cloned().unwrap_or_default(),
            None if code == "None" => "none".into(),
            None if code.ends_with("::default()") => "its own".into(),
            None => value(code),
        }
    };
    let (mut items, mut given): (BTreeMap<String, Item>, BTreeMap<(String, String), String>) = Default::default();
    for text in &texts {
        let code = text.split("#[cfg(test)]").next().unwrap();
        let (mut docs, mut attributes, mut open) = (String::new(), String::new(), None::<(String, usize)>);
        let mut default_of = None::<String>;
        for line in code.lines() {
            let (trimmed, indent) = (line.trim(), line.len() - line.trim_start().len());
            if let Some(doc) = trimmed.strip_prefix("///") {
                docs += doc;
                continue;
            }
            if trimmed.starts_with("#[") {
                attributes += trimmed;
                continue;
            }
            if let Some(name) = trimmed.strip_prefix("impl Default for ").and_then(|rest| rest.strip_suffix(" {")) {
                default_of = Some(name.to_string());
            }
            if line == "}" {
                default_of = None;
            }
            if let Some(name) = &default_of {
                let inner = trimmed.strip_prefix("Self {").map_or(trimmed, |rest| rest.trim_end_matches('}'));
                for pair in inner.split(", ") {
                    if let Some((field, code)) = pair.trim().split_once(": ") {
                        given.insert((name.clone(), field.to_string()), of_code(code));
                    }
                }
            }
            let opens =
                |mark: &str| trimmed.strip_prefix(mark).and_then(|rest| rest.strip_suffix(" {")).map(str::to_string);
            let bare = (indent == 4 && docs.len() > 1).then(|| opens("")).flatten();
            let bare =
                bare.filter(|name| name.chars().all(char::is_alphanumeric) && name.starts_with(char::is_uppercase));
            let is_enum = opens("pub enum ").is_some();
            match (&open, opens("pub struct ").or_else(|| opens("pub enum ")).or(bare)) {
                (None, Some(name)) if !name.contains(['$', '<']) => {
                    let defaulted = attributes.contains("serde(default");
                    let item = Item { is_enum, docs: docs.trim().into(), fields: Vec::new(), defaulted };
                    items.insert(name.clone(), item);
                    open = Some((name, indent));
                }
                (None, _) if trimmed == "motions! {" => {
                    items.insert(
                        "Motion".into(),
                        Item { is_enum: true, docs: "Motion of the hand.".into(), ..Item::default() },
                    );
                    open = Some(("Motion".into(), indent));
                }
                (Some((_, at)), _) if trimmed == "}" && indent == *at => open = None,
                // What no file can give.
                (Some(_), None) if attributes.contains("serde(skip)") => {}
                (Some((name, _)), None) if !trimmed.is_empty() && !trimmed.starts_with("//") => {
                    let item = items.get_mut(name).unwrap();
                    let field = trimmed.trim_start_matches("pub ").trim_end_matches(',');
                    let entry = if item.is_enum {
                        let (variant, holds) = field.split_once('(').unwrap_or((field, ""));
                        let holds = if name == "Motion" { variant } else { holds.trim_end_matches(')') };
                        {
                            let usual = if attributes.contains("#[default]") { " The default." } else { "" };
                            [variant.into(), holds.into(), String::new(), format!("{}{usual}", docs.trim())]
                        }
                    } else {
                        let Some((field, of)) = field.split_once(": ") else { continue };
                        let function = attributes.split("default = \"").nth(1).and_then(|rest| rest.split('"').next());
                        let own = function.map(|f| {
                            functions.get(f.trim_start_matches("defaults::")).cloned().unwrap_or_else(|| f.into())
                        });
                        let none = attributes.contains("serde(default").then(|| absent(of));
                        [field.into(), of.into(), own.or(none).unwrap_or_default(), docs.trim().to_string()]
                    };
                    item.fields.push(entry);
                }
                _ => {}
            }
            docs.clear();
            attributes.clear();
        }
    }
    for (name, item) in items.iter_mut().filter(|(_, item)| !item.is_enum) {
        for field in &mut item.fields {
            // A file may leave out all of a scene but these two: see `ScenePart::complete`.
            if name == "Scene" && !["object", "loading"].contains(&field[0].as_str()) {
                field[2] = absent(&field[1]);
            }
            if field[2].is_empty() {
                let known = given.get(&(name.clone(), field[0].clone())).cloned();
                let missing = if item.defaulted { "its own" } else { "required" };
                field[2] = known.unwrap_or_else(|| missing.into());
            }
        }
    }
    items
}

/// What stands for a field that is not given and has no value of its own in the schema.
fn absent(of: &str) -> String {
    let text = match of {
        "bool" => "false",
        "String" => "empty",
        of if of.starts_with("Option<") => "none",
        of if of.starts_with("Vec<") => "empty",
        _ => "its own",
    };
    text.into()
}

/// Types that a type names.
fn named(of: &str) -> impl Iterator<Item = String> + '_ {
    of.split(|c: char| !c.is_alphanumeric()).filter(|name| name.starts_with(char::is_uppercase)).map(str::to_string)
}

/// A doc comment as the cell of a table: without links into the code.
fn cell(text: &str) -> String {
    let text = text.replace('|', "\\|").replace("[`", "`").replace("`]", "`");
    text.replace("defaults::", "").replace("crate::", "")
}

fn page() -> String {
    let items = items();
    let mut out = String::from(
        "# Scene reference\n\nEvery field of a scene file, made from the schema in `src/scene` (`TACTUS_WRITE_DOCS=1 cargo test --release --test scenes \
         reference::` writes this page). Units are SI. A default of \"its own\" is that of the type beside it. [scenes.md](scenes.md) tells how scenes work.\n\n\
         A file may also have `include: [\"other.ron\"]`: fields that it does not give come from there; and in place of `object` a list `objects` for a\n\
         data set, or a `universe` that draws them, with `split` for training and test.\n",
    );
    let (mut queue, mut seen) =
        (vec!["Scene".to_string(), "Entry".into(), "Universe".into(), "Split".into()], BTreeSet::new());
    queue.reverse();
    while let Some(name) = queue.pop() {
        let Some(item) = items.get(&name).filter(|_| seen.insert(name.clone())) else { continue };
        let _ = writeln!(out, "\n## {}\n\n{}\n", shown(&name), cell(&item.docs));
        if item.is_enum {
            out += "| one of | with | meaning |\n|---|---|---|\n";
        } else {
            out += "| field | what | default | meaning |\n|---|---|---|---|\n";
        }
        for [field, of, default, docs] in &item.fields {
            let holds = if of.is_empty() { String::new() } else { kind(of) };
            let _ = match item.is_enum {
                true => writeln!(out, "| `{field}` | {holds} | {} |", cell(docs)),
                false => writeln!(out, "| `{field}` | {holds} | {default} | {} |", cell(docs)),
            };
        }
        let mut next: Vec<_> = item.fields.iter().flat_map(|field| named(&field[1])).collect();
        next.reverse();
        queue.extend(next);
    }
    out
}

#[test]
fn the_page_is_that_of_the_schema() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene-reference.md");
    let page = page();
    if std::env::var_os("TACTUS_WRITE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = there.lines().zip(page.lines()).position(|(a, b)| a != b);
    assert!(
        there == page,
        "docs/scene-reference.md is not that of the schema (line {differs:?}): write it anew with TACTUS_WRITE_DOCS=1"
    );
}

/// Fields whose defaults a user relies on stand there with their value.
#[test]
fn the_page_has_the_values_of_defaults() {
    let page = page();
    for row in [
        "| `friction` | number from 0 | 0.8 |",
        "| `force` | number above 0 | required |",
        "| `path` | number above 0 | 0.01 |",
        "| `poisson` | (least, most) | (0.3, 0.495) |",
    ] {
        assert!(page.contains(row), "{row} is missing");
    }
    assert!(!page.contains("defaults::"));
}
