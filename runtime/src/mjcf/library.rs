//! All files of a model: the one that was opened, and the models that it names as assets, each read once.

use super::mesh;
use super::settings::{Classes, Compiler, Options};
use super::tree::{BYTES_MAX, Files, Tree, folder_of, shortened};
use super::values::Values;
use super::vocabulary;
use super::warning::{Effect, Warning, Warnings};
use crate::scene::{Limits, Problem, SceneError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most models within models within models.
const MODELS_DEPTH_MAX: usize = 16;

/// One model with what its files say of how it is meant.
pub(super) struct Source {
    pub tree: Tree,
    pub compiler: Compiler,
    pub classes: Classes,
    pub options: Options,
    /// Folder of its meshes, below that of the model that was opened.
    pub mesh_folder: String,
    /// Elements `<mesh>` by name.
    pub meshes: BTreeMap<String, usize>,
    /// Indices of other sources by name.
    pub models: BTreeMap<String, usize>,
    /// The first element with a tag and a name, of bodies and frames.
    pub named: BTreeMap<(&'static str, String), usize>,
}

/// The sources; the first is the model that was opened.
pub(super) struct Library {
    pub files: Files,
    pub limits: Limits,
    pub sources: Vec<Source>,
    pub warnings: Warnings,
    /// By file, below the folder of the model that was opened.
    known: BTreeMap<String, usize>,
}

impl Library {
    /// Reads a file and all models that it names.
    pub(super) fn open(file: &Path, limits: &Limits) -> Result<Self, SceneError> {
        let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
        let mut library = Self::empty(Some(folder), limits);
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let tree = library.files.read(&name)?;
        library.add(tree, &name, &mut vec![name.clone()])?;
        Ok(library)
    }

    /// Takes a model from memory, which can name no files.
    pub(super) fn of_text(text: &[u8], limits: &Limits) -> Result<Self, SceneError> {
        let asked = text.len() as u64;
        if asked > limits.file_bytes.min(BYTES_MAX) {
            let problem = Problem::TooLarge { what: "bytes", asked, limit: limits.file_bytes.min(BYTES_MAX) };
            return Err(SceneError { file: None, at: None, path: String::new(), problem });
        }
        let mut library = Self::empty(None, limits);
        library.files.names.push(PathBuf::new());
        let tree = library.files.parse(text, "")?;
        library.add(tree, "", &mut Vec::new())?;
        Ok(library)
    }

    fn empty(root: Option<PathBuf>, limits: &Limits) -> Self {
        let files = Files::new(root, limits);
        Self {
            files,
            limits: *limits,
            sources: Vec::new(),
            warnings: Warnings::default(),
            known: BTreeMap::new(),
        }
    }

    /// Adds a model and those that it names; `open` are the files that are being read.
    fn add(&mut self, tree: Tree, relative: &str, open: &mut Vec<String>) -> Result<usize, SceneError> {
        vocabulary::check(&tree, &self.files, &mut self.warnings);
        let compiler = Compiler::read(&self.files, &tree)?;
        let classes = Classes::read(&self.files, &tree)?;
        let options = Options::read(&self.files, &tree)?;
        let mesh_folder = format!("{}/{}", folder_of(relative), compiler.mesh_folder);
        let meshes = self.assets(&tree, "mesh")?;
        let models = self.assets(&tree, "model")?;
        let index = self.sources.len();
        if self.sources.first().is_some_and(|first| first.options != options) {
            // As in MuJoCo, those of the model that was opened hold for all.
            let spot =
                tree.with_tag(0, "option").next().map_or(tree.elements[0].spot, |i| tree.elements[i].spot);
            let what = "option of a model that is attached and says otherwise".to_string();
            let (file, at) = (self.files.shown(spot.file), Some(spot.at));
            self.warnings.add(Warning { effect: Effect::Motion, what, count: 1, file, at });
        }
        let mut named = BTreeMap::new();
        for (index, element) in tree.elements.iter().enumerate() {
            let tag = ["body", "frame"].into_iter().find(|tag| *tag == element.tag);
            if let (Some(tag), Some(name)) = (tag, element.text("name")) {
                named.entry((tag, name.to_string())).or_insert(index);
            }
        }
        let models_named = BTreeMap::new();
        let source =
            Source { tree, compiler, classes, options, mesh_folder, meshes, models: models_named, named };
        self.sources.push(source);
        for (name, element) in models {
            let other = self.model(index, element, relative, open)?;
            self.sources[index].models.insert(name, other);
        }
        Ok(index)
    }

    /// Elements of `<asset>` with a tag, by name.
    fn assets(&self, tree: &Tree, tag: &str) -> Result<BTreeMap<String, usize>, SceneError> {
        let mut assets = BTreeMap::new();
        for section in tree.with_tag(0, "asset") {
            for element in tree.with_tag(section, tag) {
                let values = Values { files: &self.files, tree, element, defaults: None };
                let mut name = mesh::name(&values)?.to_string();
                if tag == "model" && values.name()?.is_empty() {
                    // Known by the name that its own file gives, which is not read yet: the file's stands in.
                    name = values.text("file").unwrap_or_default().to_string();
                }
                if name.is_empty() {
                    return Err(values.error("name", format!("a {tag} without a name, expected one")));
                }
                if assets.insert(name.clone(), element).is_some() {
                    let message =
                        format!("the name {:?} is used twice, expected each once", shortened(&name));
                    return Err(values.error("name", message));
                }
            }
        }
        Ok(assets)
    }

    /// Reads the model that an element of a source names.
    fn model(
        &mut self,
        source: usize,
        element: usize,
        relative: &str,
        open: &mut Vec<String>,
    ) -> Result<usize, SceneError> {
        let tree = &self.sources[source].tree;
        let values = Values { files: &self.files, tree, element, defaults: None };
        let Some(file) = values.text("file") else {
            return Err(values.error("file", "no `file`, expected the name of a model's file"));
        };
        let file = self.files.resolve(folder_of(relative), file);
        let file = file.map_err(|message| values.error("file", message))?;
        if let Some(&known) = self.known.get(&file) {
            return Ok(known);
        }
        if open.contains(&file) || open.len() >= MODELS_DEPTH_MAX {
            let message = format!("{file:?} is within itself, or deeper than {MODELS_DEPTH_MAX} models");
            return Err(values.error("file", message + ", expected models that end"));
        }
        let path = self.files.path(&file);
        if !path.is_file() {
            let message = format!("{:?} does not exist, expected a model's file", path.display().to_string());
            return Err(values.error("file", message));
        }
        let tree = self.files.read(&file)?;
        open.push(file.clone());
        let index = self.add(tree, &file, open)?;
        open.pop();
        self.known.insert(file, index);
        Ok(index)
    }
}
