//! `docs/scene-reference.md` is generated from the schema: every field with its type, default and meaning.
//!
//! `TACTUS_WRITE_DOCS=1 cargo test --release --test scenes reference::` regenerates it.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use tactus::scene;

/// Struct or enum of the schema.
#[derive(Default)]
struct Item {
    is_enum: bool,
    docs: String,
    /// Name, type (for a variant: type of its content), default and meaning of each field.
    fields: Vec<[String; 4]>,
    /// True if missing fields take their values from the default of the struct.
    defaulted: bool,
}

fn schema_files(dir: &Path) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    // Robots are read from their own formats.
    found.retain(|path| path.extension().is_some_and(|e| e == "rs") || path.is_dir() && !path.ends_with("robot"));
    found.into_iter().flat_map(|path| if path.is_dir() { schema_files(&path) } else { vec![path] }).collect()
}

/// Value of a constant in scene syntax: `Positive::new_unchecked(1.0)` is 1.
fn value(code: &str) -> String {
    let code = code.trim().trim_end_matches([',', ';']);
    let inner = ["Tuple([", "::new_unchecked(", "::new_unchecked3(", "::new_unchecked_size("]
        .iter()
        .find_map(|mark| code.split_once(mark));
    match inner {
        Some((_, rest)) => {
            let close = rest.rfind([')', ']']).unwrap_or(rest.len());
            let text = rest[..close].trim_end_matches(']');
            let numbers: Vec<_> =
                text.split(", ").map(|n| if n.contains("::new_unchecked(") { value(n) } else { number(n) }).collect();
            if numbers.len() > 1 { format!("({})", numbers.join(", ")) } else { numbers.concat() }
        }
        None => number(code.rsplit("::").next().unwrap_or(code)),
    }
}

/// A numeric literal in its shortest form.
fn number(text: &str) -> String {
    text.parse::<f64>().map_or(text.to_string(), |v| format!("{v}"))
}

/// Default values of the types that have one, serialised by the crate.
fn defaults() -> BTreeMap<&'static str, Value> {
    macro_rules! defaults {
        ($($module:ident: $($name:ident)*;)*) => {
            BTreeMap::from([$($((stringify!($name), serde_json::to_value(scene::$module::$name::default()).unwrap()),)*)*])
        };
    }
    defaults! {
        bonding: BondingPlane BondingRule;
        convention: Convention;
        expect: Bounds Reason;
        grasps: Grasps;
        gripper: Fingers Gripper Placement RightFinger;
        ground: Plane;
        material: MaterialChoice;
        object: DroppedAfter ObjectMotion;
        objects: Split;
        observation: Grid Markers;
        output: Record;
        pad: GelShape GelSightMini Pads;
        reward: EconomyReward HoldReward Reward SlipReward;
        rotation: Rotation;
        stepper: Condensed Element Fem Solver StepperChoice Tolerance;
        task: Control Randomise Task;
        universe: PadSpans Universe;
    }
}

/// A default value in scene syntax: a struct is `()`, a variant with fields `Name()`.
fn written(value: &Value, items: &BTreeMap<String, Item>, of: &str) -> String {
    let inner =
        ["Option<", "Vec<"].iter().find_map(|wrapper| of.strip_prefix(wrapper)?.strip_suffix('>')).unwrap_or(of);
    match value {
        Value::Null => "none".into(),
        Value::Bool(v) => v.to_string(),
        Value::Number(v) => v.as_f64().map_or(v.to_string(), |v| format!("{v}")),
        Value::String(text) if of == "String" && text.is_empty() => "empty".into(),
        Value::String(text) if of == "String" => format!("{text:?}"),
        Value::String(name) => name.clone(),
        Value::Array(all) if of.starts_with("Vec<") => {
            let known = items.get(inner).map_or(0, |item| item.fields.len());
            match all.iter().map(|v| written(v, items, inner)).collect::<Vec<_>>() {
                list if list.is_empty() => "empty".into(),
                list if list.len() > 4 && list.len() == known => "all".into(),
                list => format!("[{}]", list.join(", ")),
            }
        }
        Value::Array(all) => {
            format!("({})", all.iter().map(|v| written(v, items, inner)).collect::<Vec<_>>().join(", "))
        }
        Value::Object(fields) => match fields.iter().next() {
            Some((name, Value::String(text))) if name.starts_with(char::is_uppercase) => format!("{name}({text:?})"),
            Some((name, _)) if name.starts_with(char::is_uppercase) => format!("{name}()"),
            _ => "()".into(),
        },
    }
}

/// Description of the values that a type of the schema accepts.
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
        "GraspCount" => return kind("Count<1, 1000000>"),
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
        "usize" | "u64" => "whole number from 0",
        "Rotation" => "(w, x, y, z) or RpyDeg((roll, pitch, yaw))",
        "Name" => "name of letters, digits and `-`",
        "usize, usize" => "two whole numbers from 0",
        "bool" => "true or false",
        other => return format!("[`{}`](#{})", shown(other), anchor(shown(other))),
    }
    .into()
}

/// Anchor of a heading, as on GitHub.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

/// Name of a type in messages and on the page, where it differs from that in the code.
fn shown(name: &str) -> &str {
    match name {
        "ObjectShape" => "Shape",
        "ObjectMotion" => "Motion",
        "MaterialChoice" => "Material",
        "ListedPose" => "Pose",
        "StepperChoice" => "Stepper",
        "HoldReward" => "Reward: Hold",
        "SlipReward" => "Reward: Slip",
        "StressReward" => "Reward: Stress",
        "EconomyReward" => "Reward: Economy",
        "Motion" => "Motion of the hand",
        other => other,
    }
}

/// Values of the constants of the schema, by their names, and by the names of the functions that serde calls for them.
fn constants() -> (BTreeMap<String, String>, BTreeMap<String, String>) {
    let (mut constants, mut functions) = (BTreeMap::new(), BTreeMap::new());
    let sources =
        ["src/scene/defaults.rs", "src/base/scales.rs"].map(|path| Path::new(env!("CARGO_MANIFEST_DIR")).join(path));
    for line in sources
        .iter()
        .flat_map(|path| std::fs::read_to_string(path).unwrap().lines().map(str::to_string).collect::<Vec<_>>())
    {
        let line = line.trim().trim_start_matches("pub const ");
        let Some((name, code)) = line.split_once(" = ").and_then(|(head, code)| Some((head.split_once(':')?.0, code)))
        else {
            continue;
        };
        let (name, function) = name.split_once(" (").map_or((name, None), |(n, f)| (n, Some(f.trim_end_matches(')'))));
        constants.insert(name.to_string(), value(code));
        function.map(|f| functions.insert(f.to_string(), value(code)));
    }
    (constants, functions)
}

/// All types of the schema.
fn items() -> BTreeMap<String, Item> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scene");
    let texts: Vec<_> = schema_files(&dir).iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let (_, functions) = constants();
    let mut items = BTreeMap::<String, Item>::new();
    for text in &texts {
        let code = text.split("#[cfg(test)]").next().unwrap();
        let (mut docs, mut attributes, mut open) = (String::new(), String::new(), None::<(String, usize)>);
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
            let opens =
                |mark: &str| trimmed.strip_prefix(mark).and_then(|rest| rest.strip_suffix(" {")).map(str::to_string);
            let bare = (indent == 4 && docs.len() > 1).then(|| opens("")).flatten();
            let bare =
                bare.filter(|name| name.chars().all(char::is_alphanumeric) && name.starts_with(char::is_uppercase));
            let is_enum = opens("pub enum ").is_some();
            match (&open, opens("pub struct ").or_else(|| opens("pub enum ")).or(bare)) {
                (None, Some(name)) if !name.contains(['$', '<']) => {
                    let defaulted =
                        ["serde(default", ", default,", ", default)"].iter().any(|mark| attributes.contains(mark));
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
                // Fields that a file cannot give.
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
                        let none = attributes.contains("serde(default").then(|| USUAL.into());
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
    let known = defaults();
    let usual = |of: &str| match of {
        "bool" => Value::Bool(false),
        "String" => Value::String(String::new()),
        "u64" => 0.into(),
        of if of.starts_with("Option<") => Value::Null,
        of if of.starts_with("Vec<") => Value::Array(Vec::new()),
        other => known.get(other).cloned().unwrap_or_else(|| panic!("the default of {other} is not in the list")),
    };
    let mut values = Vec::new();
    for (name, item) in items.iter().filter(|(_, item)| !item.is_enum) {
        for [field, of, default, _] in &item.fields {
            let of_type =
                || known.get(name.as_str()).unwrap_or_else(|| panic!("the default of {name} is not in the list"));
            let own = item.defaulted.then(of_type);
            // These two fields of a scene are required: see `ScenePart::complete`.
            let optional = name == "Scene" && !["object", "loading"].contains(&field.as_str());
            values.push(match own {
                Some(own) => written(own.get(field).unwrap_or(&Value::Null), &items, of),
                None if optional || default == USUAL => written(&usual(of), &items, of),
                None if default.is_empty() => "required".into(),
                None => default.clone(),
            });
        }
    }
    let fields = items.values_mut().filter(|item| !item.is_enum).flat_map(|item| &mut item.fields);
    fields.zip(values).for_each(|(field, value)| field[2] = value);
    items
}

/// Placeholder for the default of a field's type, replaced after all types are read.
const USUAL: &str = "the default of the type";

/// Names of the types that occur in a type.
fn named(of: &str) -> impl Iterator<Item = String> + '_ {
    of.split(|c: char| !c.is_alphanumeric()).filter(|name| name.starts_with(char::is_uppercase)).map(str::to_string)
}

/// A doc comment as a table cell: a link to a constant becomes its value, a link to other code with a path is removed.
fn cell(text: &str) -> String {
    let (constants, _) = constants();
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, (name, after))) = rest.split_once("[`").and_then(|(b, r)| Some((b, r.split_once("`]")?))) {
        // Skips the address of a link, in parentheses.
        let after = after.strip_prefix('(').and_then(|r| r.split_once(')')).map_or(after, |(_, r)| r);
        let last = name.rsplit("::").next().unwrap_or(name);
        match constants.get(last) {
            Some(value) => out += &format!("{before}{value}"),
            None if name.contains("::") => out += before.trim_end_matches(", see "),
            None => out += &format!("{before}`{name}`"),
        }
        rest = after;
    }
    (out + rest).replace('|', "\\|")
}

fn page() -> String {
    let items = items();
    let mut out = String::from(
        "# Scene reference\n\nEvery field of a scene file, made from the schema in `src/scene` (`TACTUS_WRITE_DOCS=1 cargo test --release --test scenes \
         reference::` writes this page). Units are SI. A default of `()` has all fields as by default. [scenes.md](scenes.md) tells how scenes work.\n\n\
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

/// The page shows the values of important defaults, and every default is in scene syntax.
#[test]
fn the_page_has_the_values_of_defaults() {
    let page = page();
    for row in [
        "| `friction` | number from 0 | 0.8 |",
        "| `force` | number above 0 | required |",
        "| `path` | number above 0 | 0.01 |",
        "| `poisson` | (least, most) | (0.3, 0.495) |",
        "| `motion` | [`Motion`](#motion) | Free |",
        "| `pads` | [`Pads`](#pads) | GelSightMini() |",
        "| `material` | [`Material`](#material) | Preset(\"gelsight_mini\") |",
        "| `rotation` | (w, x, y, z) or RpyDeg((roll, pitch, yaw)) | (1, 0, 0, 0) |",
        "| `fields` | list: [`Field`](#field) | [Displacement, Stress, ContactForce, ObjectPose] | Fields of each frame. |",
        "| `arrays` | [`Arrays`](#arrays), optional | Npz |",
        "| `rows` | whole number, 1 to 512 | 8 |",
    ] {
        assert!(page.contains(row), "{row} is missing");
    }
    assert!(page.contains("If neither it nor `accuracy` is given: 0.0026."), "the spacing of the GelSight Mini, m");
    let body = page.split_once("## ").unwrap().1;
    assert!(!body.contains("::") && !body.contains("](crate"), "paths of the code");
    let rows = page.lines().filter(|line| line.starts_with("| `"));
    for cells in rows.map(|line| line.split(" | ").collect::<Vec<_>>()).filter(|cells| cells.len() == 4) {
        let default = cells[2];
        let names = default.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|name| name.len() > 1);
        let constant = |name: &str| name.chars().all(|c| c.is_ascii_uppercase() || c == '_');
        assert_eq!(default.matches('(').count(), default.matches(')').count(), "{cells:?}");
        assert!(
            !default.contains(['.', ':']) || default.parse::<f64>().is_ok() || default.starts_with('('),
            "{cells:?}"
        );
        assert_eq!(names.filter(|name| constant(name)).count(), 0, "{cells:?}");
    }
}
