//! Files to one tree of elements, with every `<include>` replaced by what it names.
//!
//! ```text
//! bytes --text::check--> roxmltree --copy--> Tree     an element knows its file, line and column
//!                                     |
//!                                     include: the children of the other file's root, in its place
//! ```
//! Files are named relative to the folder of the file that was opened first and lie below it; none is included
//! twice, so that includes cannot go round in circles.

use super::text::{self, DEPTH_MAX, ELEMENTS_MAX};
use crate::scene::{Limits, Problem, SceneError};
use std::path::PathBuf;

/// Bytes of a model's XML files together, whatever the limits allow: about eight times what as many elements as
/// a model may have take.
pub(super) const BYTES_MAX: u64 = 64 << 20;

/// Line and column, from 1; columns count bytes.
pub(super) type At = (usize, usize);

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Spot {
    /// Index into [`Files::names`].
    pub file: usize,
    /// Line and column.
    pub at: At,
}

/// `name="value"`.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub name: String,
    pub value: String,
    pub at: At,
}

/// An element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<usize>,
    /// The element around it; itself for the root.
    pub parent: usize,
    pub spot: Spot,
}

impl Element {
    /// The text of an attribute.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|found| found.value.as_str())
    }
}

/// The elements of one model; the first is the root.
#[derive(Debug)]
pub(super) struct Tree {
    pub elements: Vec<Element>,
}

impl Tree {
    /// Children of an element with a tag.
    pub(super) fn with_tag<'a>(&'a self, parent: usize, tag: &'a str) -> impl Iterator<Item = usize> + 'a {
        let children = self.elements[parent].children.iter().copied();
        children.filter(move |&child| self.elements[child].tag == tag)
    }

    /// The tags down to an element, with names where there are: `mujoco/worldbody/body[torso]`.
    pub(super) fn path(&self, mut element: usize) -> String {
        let mut steps = Vec::new();
        loop {
            let found = &self.elements[element];
            let name = found.text("name").or(found.text("class"));
            steps.push(name.map_or(found.tag.clone(), |name| format!("{}[{}]", found.tag, shortened(name))));
            if found.parent == element {
                break;
            }
            element = found.parent;
        }
        steps.reverse();
        steps.join("/")
    }
}

/// A name as it is shown: not longer than a line.
pub(super) fn shortened(name: &str) -> String {
    if name.chars().count() <= 60 {
        name.to_string()
    } else {
        name.chars().take(57).collect::<String>() + "..."
    }
}

/// Where models come from: a folder, and all files that were read below it.
pub(super) struct Files {
    /// What file names are relative to; nothing outside of it is read. `None` when there are no files.
    root: Option<PathBuf>,
    /// As they are shown.
    pub names: Vec<PathBuf>,
    bytes_left: u64,
    elements_left: usize,
}

impl Files {
    pub(super) fn new(root: Option<PathBuf>, limits: &Limits) -> Self {
        let bytes_left = if limits.file_bytes < BYTES_MAX { limits.file_bytes } else { BYTES_MAX };
        Self { root, names: Vec::new(), bytes_left, elements_left: ELEMENTS_MAX }
    }

    /// The path below the root that `file` means when it is named in a file of folder `folder`; slashes between
    /// names. What is wrong with it otherwise.
    pub(super) fn resolve(&self, folder: &str, file: &str) -> Result<String, String> {
        let said = format!("{:?}", shortened(file));
        let Some(root) = &self.root else {
            return Err(format!("found {said}, expected no file: this model came from memory"));
        };
        let shown = if root.as_os_str().is_empty() { ".".to_string() } else { root.display().to_string() };
        let below = format!("a file below the model's folder {shown:?}");
        if file.is_empty() || file.starts_with('/') || file.contains(['\\', ':', '\0']) {
            return Err(format!("found {said}, expected {below}, relative and with `/` between names"));
        }
        let mut names: Vec<&str> = Vec::new();
        let mut outside = false;
        for name in folder.split('/').chain(file.split('/')) {
            match name {
                "" | "." => {}
                ".." => outside |= names.pop().is_none(),
                _ => names.push(name),
            }
        }
        if outside {
            let there = root.join(folder).join(file).is_file();
            let missing = if there { "" } else { "does not exist, and it " };
            return Err(format!(
                "{said} {missing}lies outside of where files are read, expected {below}: put it there"
            ));
        }
        Ok(names.join("/"))
    }

    /// The path of a file below the root as the system takes it.
    pub(super) fn path(&self, relative: &str) -> PathBuf {
        self.root.as_ref().map_or_else(|| PathBuf::from(relative), |root| root.join(relative))
    }

    /// Reads a file below the root into a tree.
    pub(super) fn read(&mut self, relative: &str) -> Result<Tree, SceneError> {
        let path = self.path(relative);
        let bytes = crate::scene::read_file(&path, self.bytes_left).map_err(|problem| SceneError {
            file: Some(path.clone()),
            at: None,
            path: String::new(),
            problem,
        })?;
        self.names.push(path);
        self.parse(&bytes, relative)
    }

    /// Makes a tree of the text of the file that was named last.
    pub(super) fn parse(&mut self, bytes: &[u8], relative: &str) -> Result<Tree, SceneError> {
        let mut tree = Tree { elements: Vec::new() };
        let mut open = vec![relative.to_string()];
        let root = self.root_element(&mut tree, bytes)?;
        let tag = tree.elements[root].tag.clone();
        if tag != "mujoco" {
            let message = format!("the root element is `{}`, expected `mujoco`", shortened(&tag));
            return Err(self.error(&tree, root, None, Problem::Format(message)));
        }
        self.include(&mut tree, relative, &mut open)?;
        Ok(tree)
    }

    /// An error at an element, or at one of its attributes.
    pub(super) fn error(
        &self,
        tree: &Tree,
        element: usize,
        name: Option<&str>,
        problem: Problem,
    ) -> SceneError {
        let found = &tree.elements[element];
        let attribute = found.attributes.iter().find(|attribute| Some(attribute.name.as_str()) == name);
        let path = tree.path(element);
        SceneError {
            file: self.shown(found.spot.file),
            at: Some(attribute.map_or(found.spot.at, |attribute| attribute.at)),
            path: name.map_or(path.clone(), |name| format!("{path}/{name}")),
            problem,
        }
    }

    /// The name of a file; none of text from memory.
    pub(super) fn shown(&self, file: usize) -> Option<PathBuf> {
        self.names.get(file).filter(|name| !name.as_os_str().is_empty()).cloned()
    }

    /// Replaces every `<include>` until there is none.
    fn include(&mut self, tree: &mut Tree, relative: &str, read: &mut Vec<String>) -> Result<(), SceneError> {
        // As in MuJoCo, names of included files are relative to the folder of the model, not of the including file.
        let folder = folder_of(relative);
        let mut next = 0;
        while let Some(including) = (next..tree.elements.len()).find(|&i| tree.elements[i].tag == "include") {
            next = including + 1;
            let element = &tree.elements[including];
            let fail = |message| Err(self.error(tree, including, Some("file"), Problem::Format(message)));
            let Some(file) = element.text("file") else {
                return fail("no `file`, expected the name of the file to include".to_string());
            };
            let file = match self.resolve(folder, file) {
                Ok(file) => file,
                Err(message) => return fail(message),
            };
            if read.contains(&file) {
                return fail(format!("{file:?} is included already, expected each file once"));
            }
            let path = self.path(&file);
            let bytes = match crate::scene::read_file(&path, self.bytes_left) {
                Ok(bytes) => bytes,
                Err(problem) => return fail(format!("{}: {problem}", path.display())),
            };
            self.names.push(path);
            read.push(file);
            let root = self.root_element(tree, &bytes)?;
            self.splice(tree, including, root)?;
        }
        self.check_depth(tree)
    }

    /// Files that are shallow each may be deep together.
    fn check_depth(&self, tree: &Tree) -> Result<(), SceneError> {
        let mut depths = vec![1; tree.elements.len()];
        for (index, element) in tree.elements.iter().enumerate().filter(|(index, e)| e.parent != *index) {
            // What is around an element was read before it.
            depths[index] = depths[element.parent] + 1;
            if depths[index] > DEPTH_MAX {
                let message = format!("elements nested more than {DEPTH_MAX} deep, expected fewer");
                return Err(self.error(tree, index, None, Problem::Format(message)));
            }
        }
        Ok(())
    }

    /// Puts the children of `root` in the place of the element `including`.
    fn splice(&self, tree: &mut Tree, including: usize, root: usize) -> Result<(), SceneError> {
        let around = tree.elements[including].parent;
        if around == including {
            let message = "the root element is `include`, expected `mujoco`".to_string();
            return Err(self.error(tree, including, None, Problem::Format(message)));
        }
        let children = std::mem::take(&mut tree.elements[root].children);
        for &child in &children {
            tree.elements[child].parent = around;
        }
        let place = tree.elements[around].children.iter().position(|&child| child == including);
        let place = place.expect("an element is among the children of its parent");
        tree.elements[around].children.splice(place..=place, children);
        // What was spliced must not be found again; its root has no children any more.
        tree.elements[including].tag.clear();
        Ok(())
    }

    /// Parses a file and adds its elements; the index of its root.
    fn root_element(&mut self, tree: &mut Tree, bytes: &[u8]) -> Result<usize, SceneError> {
        let file = self.names.len() - 1;
        let lines = Lines::new(bytes);
        let shown = self.shown(file);
        let fail = |at: Option<At>, message: String| SceneError {
            file: shown.clone(),
            at,
            path: String::new(),
            problem: Problem::Format(message),
        };
        self.bytes_left = self.bytes_left.saturating_sub(bytes.len() as u64);
        text::check(bytes).map_err(|mistake| fail(Some(lines.at(mistake.at)), mistake.message))?;
        let text = std::str::from_utf8(bytes)
            .map_err(|error| fail(Some(lines.at(error.valid_up_to())), "not UTF-8 text".to_string()))?;
        let options =
            roxmltree::ParsingOptions { nodes_limit: 4 * ELEMENTS_MAX as u32, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
            let at = error.pos();
            let said = error.to_string();
            // The place is told apart from the message; an end that is missing has none.
            let said =
                said.strip_suffix(&format!(" at {at}")).unwrap_or(&said).replace(&format!(" at {at}"), "");
            let known = !matches!(
                error,
                roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode
            );
            let at = if known { (at.row as usize, at.col as usize) } else { lines.at(bytes.len()) };
            fail(Some(at), format!("not XML: {said}"))
        })?;
        let root = self.copy(tree, &document, file, &lines)?;
        Ok(root)
    }

    /// Copies the elements of a document in document order.
    fn copy(
        &mut self,
        tree: &mut Tree,
        document: &roxmltree::Document<'_>,
        file: usize,
        lines: &Lines,
    ) -> Result<usize, SceneError> {
        let first = tree.elements.len();
        // Open elements: the end of each in the text and its index.
        let mut open: Vec<(usize, usize)> = Vec::new();
        for node in document.root().descendants().filter(|node| node.is_element()) {
            let range = node.range();
            while open.last().is_some_and(|&(end, _)| end <= range.start) {
                open.pop();
            }
            let index = tree.elements.len();
            let parent = open.last().map_or(index, |&(_, parent)| parent);
            if parent != index {
                tree.elements[parent].children.push(index);
            }
            open.push((range.end, index));
            let attributes = node.attributes().map(|attribute| Attribute {
                name: attribute.name().to_string(),
                value: attribute.value().to_string(),
                at: lines.at(attribute.range().start),
            });
            tree.elements.push(Element {
                tag: node.tag_name().name().to_string(),
                attributes: attributes.collect(),
                children: Vec::new(),
                parent,
                spot: Spot { file, at: lines.at(range.start) },
            });
        }
        let added = tree.elements.len() - first;
        if added > self.elements_left {
            let limit = ELEMENTS_MAX as u64;
            let problem = Problem::TooLarge { what: "elements of all files", asked: limit + 1, limit };
            return Err(self.error(tree, first, None, problem));
        }
        self.elements_left -= added;
        Ok(first)
    }
}

/// The folder part of a path below the root; empty for the root itself.
pub(super) fn folder_of(relative: &str) -> &str {
    relative.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Where the lines of a text start.
struct Lines(Vec<usize>);

impl Lines {
    fn new(bytes: &[u8]) -> Self {
        let feeds = bytes.iter().enumerate().filter(|&(_, &byte)| byte == b'\n');
        Self(std::iter::once(0).chain(feeds.map(|(index, _)| index + 1)).collect())
    }

    fn at(&self, byte: usize) -> At {
        let line = self.0.partition_point(|&start| start <= byte);
        (line, byte - self.0[line - 1] + 1)
    }
}
