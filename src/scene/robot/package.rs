//! Resolution of file names in descriptions: relative, absolute, or in a ROS package.

use super::xml::XmlElement;
use std::path::{Path, PathBuf};

/// Returns the path of the file given by the attribute `filename` of an element of the description at `path`.
/// `package://NAME/` is searched in packages NAME that contain the description or are a subfolder of one of its
/// ancestors, then in `ROS_PACKAGE_PATH`, then in the folder of the description.
///
/// # Errors
/// Fails if the attribute is missing, or if a file of a package is not found.
pub(super) fn file(path: &Path, element: &XmlElement) -> Result<PathBuf, String> {
    let name = element.required_text("filename")?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let Some(rest) = name.strip_prefix("package://") else {
        return Ok(folder.join(name.strip_prefix("file://").unwrap_or(name)));
    };
    let (package, inside) = rest.split_once('/').unwrap_or((rest, ""));
    let mut roots = packages(&folder.canonicalize().unwrap_or_default(), package);
    let listed = std::env::var_os("ROS_PACKAGE_PATH").unwrap_or_default();
    roots.extend(std::env::split_paths(&listed).filter(|root| !root.as_os_str().is_empty()).flat_map(|root| {
        let own = is_package(&root, package).then(|| root.clone());
        own.into_iter().chain([root.join(package)])
    }));
    roots.push(folder.to_path_buf());
    roots.iter().map(|root| root.join(inside)).find(|file| file.exists()).ok_or_else(|| {
        element.error(format_args!(
            "refers to {name:?}, which is not found in a package {package:?} above {} or in ROS_PACKAGE_PATH; set \
             ROS_PACKAGE_PATH, or give a path relative to the folder of the description",
            path.display()
        ))
    })
}

/// Returns the candidate folders of package `name`: ancestors of `folder` that are this package, and subfolders `name`
/// of ancestors.
fn packages(folder: &Path, name: &str) -> Vec<PathBuf> {
    let above = folder.ancestors().filter(|root| is_package(root, name)).map(Path::to_path_buf);
    let beside = folder.ancestors().map(|root| root.join(name)).filter(|root| root.is_dir());
    above.chain(beside).collect()
}

/// Returns true if the folder name of `root` is `package`, or its package.xml has this name.
fn is_package(root: &Path, package: &str) -> bool {
    let named = || {
        let text = base::files::regular::read(&root.join("package.xml"), base::files::include::MAX_TOTAL_SIZE).ok()?;
        let text = String::from_utf8_lossy(&text).into_owned();
        let (_, after) = text.split_once("<name>")?;
        Some(after.split_once("</name>")?.0.trim() == package)
    };
    root.file_name().is_some_and(|own| own == package) || named().unwrap_or(false)
}
