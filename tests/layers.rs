//! Order of the folders inside the crates `mech` and `net`: a folder imports only from those before it in the list, so
//! no import cycle spans two of them. The compiler keeps the order of the crates.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Folders of `src/mech`, lowest layer first.
const MECH: [&str; 7] = ["material", "element", "body", "potential", "contact", "newton", "path"];

/// Folders of `src/net`, lowest layer first.
const NET: [&str; 8] = ["matrix", "linear_response", "autodiff", "features", "network", "infer", "train", "eval"];

fn sources(dir: &Path) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    let nested = found.into_iter().flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    nested.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

/// Names that follow `prefix` in a file, including those of a list in braces, each with its line number.
fn imports(text: &str, prefix: &str) -> Vec<(String, usize)> {
    let code: Vec<_> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let mut found: Vec<(String, usize)> = Vec::new();
    for (i, line) in code.iter().enumerate() {
        for (at, _) in line.match_indices(prefix) {
            let rest = &line[at + prefix.len()..];
            let name = |text: &str| text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            match rest.strip_prefix('{') {
                None => found.push((name(rest), i + 1)),
                Some(list) => {
                    let list = format!("{list}{}", code[i + 1..].concat());
                    let list = list.split(';').next().unwrap_or_default();
                    let mut depth = 0;
                    let outer = list.split(|c: char| {
                        depth += i32::from(c == '{') - i32::from(c == '}');
                        c == ',' && depth == 0
                    });
                    found.extend(outer.map(|item| (name(item), i + 1)));
                }
            }
        }
    }
    found.retain(|(name, _)| !name.is_empty() && name != "self");
    found
}

/// Imports from a higher layer of `order`, as `file:line: ...`, and files whose layer is missing from `order`.
fn violations(root: &Path, prefix: &str, order: &[&str]) -> Vec<String> {
    let rank: BTreeMap<_, _> = order.iter().zip(0..).collect();
    let mut wrong = Vec::new();
    for path in sources(root) {
        let inside = path.strip_prefix(root).unwrap();
        let own = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
        if matches!(own, "lib" | "mod") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let Some(at) = rank.get(&own) else {
            wrong.push(format!("{}: `{own}` has no place in the list of layers", path.display()));
            continue;
        };
        // Number of `super::` that lead from this file to the level of the layers.
        let depth = inside.iter().count() - usize::from(inside.ends_with("mod.rs"));
        let up = imports(&text, &"super::".repeat(depth)).into_iter().filter(|(name, _)| name != "super");
        for (name, line) in imports(&text, prefix).into_iter().chain(up) {
            if rank.get(&name.as_str()).is_some_and(|other| other > at) {
                wrong.push(format!("{}:{line}: `{own}` imports `{name}`, which stands above it", path.display()));
            }
        }
    }
    wrong
}

#[test]
fn a_folder_imports_only_what_stands_before_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = violations(&src.join("mech"), "crate::", &MECH);
    wrong.extend(violations(&src.join("net"), "crate::", &NET));
    assert!(wrong.is_empty(), "{} imports go up:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn an_import_that_goes_up_is_named_with_its_line() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("potential")).unwrap();
    let lines = [
        "use crate::body::Body;",
        "use crate::{",
        "    element,",
        "    contact::{EdgeState, law},",
        "};",
        "fn f() -> crate::path::Path { todo!() }",
    ];
    let text = lines.join("\n");
    std::fs::write(dir.path().join("potential/mod.rs"), text).unwrap();
    let wrong = violations(dir.path(), "crate::", &MECH);
    let says = |line: &str| wrong.iter().any(|w| w.contains(line));
    assert_eq!(wrong.len(), 2, "{wrong:?}");
    assert!(
        says("mod.rs:2: `potential` imports `contact`") && says("mod.rs:6: `potential` imports `path`"),
        "{wrong:?}"
    );
}

/// Names of the types that a file defines with a `pub` visibility, outside its tests.
fn public_types(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let name = |line: &str| {
        let rest = line.trim_start().strip_prefix("pub")?;
        let rest = if rest.starts_with('(') { rest.split_once(')')?.1 } else { rest };
        let (kind, rest) = rest.trim_start().split_once(' ')?;
        let defines = ["struct", "enum", "trait", "type", "union"].contains(&kind);
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        // An empty name is a macro variable.
        (defines && !name.is_empty()).then_some(name)
    };
    code.lines().filter_map(name).collect()
}

/// A type name is unambiguous without its module path.
#[test]
fn no_public_type_name_is_defined_twice() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut places: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for path in sources(&src) {
        for name in public_types(&std::fs::read_to_string(&path).unwrap()) {
            places.entry(name).or_default().push(path.clone());
        }
    }
    assert!(places.len() > 300, "{} types are found", places.len());
    let twice: Vec<_> = places.iter().filter(|(_, files)| files.len() > 1).collect();
    assert!(twice.is_empty(), "defined more than once: {twice:#?}");
}
