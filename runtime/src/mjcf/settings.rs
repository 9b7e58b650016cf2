//! `<compiler>`, `<option>` and `<default>`, and what depends on them: orientations and angles.

use super::math::{Placement, Turn, cross, direction, dot, scaled, sub};
use super::tree::{Files, Tree, shortened};
use super::values::{Defaults, Values};
use crate::scene::SceneError;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Most default classes of a file.
const CLASSES_MAX: usize = 1 << 11;
/// Most attributes that a class sets, inherited ones included.
const CLASS_ATTRIBUTES_MAX: usize = 1 << 9;
/// The class of what names none.
const MAIN: &str = "main";
/// Elements of actuators: as in MuJoCo, what one sets in a class the others have, too.
pub(super) const ACTUATORS: [&str; 3] = ["motor", "position", "velocity"];

/// How numbers of a file are meant.
#[derive(Clone, Debug)]
pub(super) struct Compiler {
    /// Radians of a unit of angle.
    pub unit: f64,
    pub autolimits: bool,
    pub euler: [u8; 3],
    /// Folder of meshes, as it is written.
    pub mesh_folder: String,
    pub strip_path: bool,
    pub inertia: InertiaFrom,
    /// First and last group of geoms whose mass counts.
    pub groups: [i32; 2],
    pub bound_mass: f64,
    pub bound_inertia: f64,
    pub balance: bool,
    pub total_mass: Option<f64>,
}

/// Where the mass of a body comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InertiaFrom {
    /// `<inertial>` alone.
    Given,
    /// Geoms alone.
    Geoms,
    /// `<inertial>`, or geoms where there is none.
    Either,
}

impl Default for Compiler {
    fn default() -> Self {
        Self {
            unit: PI / 180.0,
            autolimits: true,
            euler: *b"xyz",
            mesh_folder: String::new(),
            strip_path: false,
            inertia: InertiaFrom::Either,
            groups: [0, 5],
            bound_mass: 0.0,
            bound_inertia: 0.0,
            balance: false,
            total_mass: None,
        }
    }
}

impl Compiler {
    /// Reads all `<compiler>` elements; later ones go before earlier ones.
    pub(super) fn read(files: &Files, tree: &Tree) -> Result<Self, SceneError> {
        let mut compiler = Self::default();
        for element in tree.with_tag(0, "compiler") {
            compiler.element(Values { files, tree, element, defaults: None })?;
        }
        Ok(compiler)
    }

    fn element(&mut self, values: Values<'_>) -> Result<(), SceneError> {
        if values.keyword("coordinate", &["local", "global"])? == Some(1) {
            let message =
                "found \"global\", expected \"local\": save the model with MuJoCo 2.3.3, which converts it";
            return Err(values.error("coordinate", message));
        }
        if let Some(index) = values.keyword("angle", &["radian", "degree"])? {
            self.unit = [1.0, PI / 180.0][index];
        }
        set(&mut self.autolimits, values.truth("autolimits")?);
        if let Some(text) = values.text("eulerseq") {
            let letters = text.as_bytes();
            let sound = letters.len() == 3 && letters.iter().all(|c| b"xyzXYZ".contains(c));
            if !sound {
                let message = format!("found {:?}, expected three letters of xyzXYZ", shortened(text));
                return Err(values.error("eulerseq", message));
            }
            self.euler.copy_from_slice(letters);
        }
        for name in ["assetdir", "meshdir"] {
            set(&mut self.mesh_folder, values.text(name).map(str::to_string));
        }
        set(&mut self.strip_path, values.truth("strippath")?);
        let rules = [InertiaFrom::Given, InertiaFrom::Geoms, InertiaFrom::Either];
        let rule = values.keyword("inertiafromgeom", &["false", "true", "auto"])?;
        set(&mut self.inertia, rule.map(|index| rules[index]));
        set(&mut self.groups, values.numbers::<2>("inertiagrouprange")?.map(|range| range.map(|x| x as i32)));
        set(&mut self.bound_mass, values.positive("boundmass")?);
        set(&mut self.bound_inertia, values.positive("boundinertia")?);
        set(&mut self.balance, values.truth("balanceinertia")?);
        let total = values.number("settotalmass")?;
        set(&mut self.total_mass, total.map(|mass| (mass > 0.0).then_some(mass)));
        Ok(())
    }

    /// The rotation of three Euler angles in the file's unit: small letters turn about axes that turn along,
    /// capitals about fixed ones.
    pub(super) fn euler(&self, angles: [f64; 3]) -> Turn {
        let mut turn = Turn::IDENTITY;
        for (letter, angle) in self.euler.iter().zip(angles) {
            let mut axis = [0.0; 3];
            axis[usize::from(letter.to_ascii_lowercase() - b'x')] = 1.0;
            let next = Turn::about(axis, angle * self.unit);
            turn = if letter.is_ascii_lowercase() { turn.after(next) } else { next.after(turn) };
        }
        turn
    }

    /// `pos` and one of the five ways to write an orientation.
    pub(super) fn placement(&self, values: Values<'_>) -> Result<Placement, SceneError> {
        let position = values.numbers::<3>("pos")?.unwrap_or([0.0; 3]);
        Ok(Placement::new(position, self.turn(values)?))
    }

    fn turn(&self, values: Values<'_>) -> Result<Turn, SceneError> {
        const NAMES: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
        let own = NAMES.into_iter().filter(|name| values.own().has(name));
        if own.clone().count() > 1 {
            let found: Vec<&str> = own.collect();
            return Err(
                values.error(found[1], format!("found {}, expected one of them", found.join(" and ")))
            );
        }
        // A class may have several: the more special ones go before the quaternion.
        let inherited = NAMES.into_iter().rev().find(|name| values.has(name));
        let Some(name) = own.clone().next().or(inherited) else { return Ok(Turn::IDENTITY) };
        let zero = || values.error(name, "nearly zero, expected a direction");
        match name {
            "quat" => Turn::from_wxyz(values.numbers(name)?.unwrap_or([1.0, 0.0, 0.0, 0.0])).ok_or_else(zero),
            "axisangle" => {
                let [x, y, z, angle] = values.numbers(name)?.unwrap_or([0.0; 4]);
                Ok(Turn::about(direction([x, y, z]).ok_or_else(zero)?, angle * self.unit))
            }
            "xyaxes" => {
                let [a, b, c, d, e, f] = values.numbers(name)?.unwrap_or([0.0; 6]);
                let x = direction([a, b, c]).ok_or_else(zero)?;
                let y = [d, e, f];
                let y = direction(sub(y, scaled(x, dot(x, y)))).ok_or_else(zero)?;
                Ok(Turn::from_columns([x, y, cross(x, y)]))
            }
            "zaxis" => Turn::z_to(values.numbers(name)?.unwrap_or([0.0; 3])).ok_or_else(zero),
            _ => Ok(self.euler(values.numbers(name)?.unwrap_or([0.0; 3]))),
        }
    }
}

pub(super) fn set<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}

/// A default class: for each kind of element the attributes and who gives them.
#[derive(Clone, Debug, Default)]
pub(super) struct Class {
    kinds: BTreeMap<String, Defaults>,
}

/// The default classes of a file by name.
#[derive(Debug, Default)]
pub(super) struct Classes(BTreeMap<String, Class>);

impl Classes {
    /// Reads all `<default>` elements. A class has what its outer class has.
    pub(super) fn read(files: &Files, tree: &Tree) -> Result<Self, SceneError> {
        let mut classes = Self::default();
        classes.0.insert(MAIN.to_string(), Class::default());
        for section in tree.with_tag(0, "default") {
            if let Some(name) = tree.elements[section].text("class").filter(|name| *name != MAIN) {
                let values = Values { files, tree, element: section, defaults: None };
                let message = format!(
                    "found {:?}, expected {MAIN:?} or nothing on an outermost default",
                    shortened(name)
                );
                return Err(values.error("class", message));
            }
            let outer = classes.0.get(MAIN).cloned().unwrap_or_default();
            let mut stack = vec![(section, MAIN.to_string(), outer)];
            while let Some((element, name, mut class)) = stack.pop() {
                class.add(tree, element);
                if class.kinds.values().map(Defaults::len).sum::<usize>() > CLASS_ATTRIBUTES_MAX {
                    let values = Values { files, tree, element, defaults: None };
                    let message = format!("more than {CLASS_ATTRIBUTES_MAX} attributes, expected fewer");
                    return Err(values.error("class", message));
                }
                for inner in tree.with_tag(element, "default") {
                    let values = Values { files, tree, element: inner, defaults: None };
                    let Some(name) = values.text("class") else {
                        return Err(
                            values.error("class", "no `class`, expected one on a default within a default")
                        );
                    };
                    if classes.0.contains_key(name) || stack.iter().any(|known| known.1 == name) {
                        let message =
                            format!("the class {:?} is there already, expected each once", shortened(name));
                        return Err(values.error("class", message));
                    }
                    stack.push((inner, name.to_string(), class.clone()));
                }
                classes.0.insert(name, class);
                if classes.0.len() + stack.len() > CLASSES_MAX {
                    let values = Values { files, tree, element, defaults: None };
                    return Err(
                        values.error("class", format!("more than {CLASSES_MAX} classes, expected fewer"))
                    );
                }
            }
        }
        Ok(classes)
    }

    /// The name of the class of an element: its own, or that of what is around it.
    pub(super) fn of(&self, values: Values<'_>, around: &str, name: &str) -> Result<String, SceneError> {
        let Some(class) = values.own().text(name) else { return Ok(around.to_string()) };
        if self.0.contains_key(class) {
            return Ok(class.to_string());
        }
        Err(values
            .error(name, format!("no default class is named {:?}, expected one that is", shortened(class))))
    }

    /// What a class says of a kind of elements.
    pub(super) fn defaults(&self, class: &str, kind: &str) -> Option<&Defaults> {
        self.0.get(class).or(self.0.get(MAIN))?.kinds.get(kind)
    }

    /// The class of the outermost elements.
    pub(super) fn outermost() -> String {
        MAIN.to_string()
    }
}

impl Class {
    fn add(&mut self, tree: &Tree, section: usize) {
        for &child in &tree.elements[section].children {
            let element = &tree.elements[child];
            if element.tag == "default" {
                continue;
            }
            let shared = ACTUATORS.contains(&element.tag.as_str()).then_some("actuator");
            for kind in [Some(element.tag.as_str()), shared].into_iter().flatten() {
                let kind = self.kinds.entry(kind.to_string()).or_default();
                kind.extend(element.attributes.iter().map(|attribute| (attribute.name.clone(), child)));
            }
        }
    }
}

/// What `<option>` says.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Length of a step, seconds.
    pub timestep: f64,
    /// Acceleration of free bodies, m/s^2; zero where a flag disables it.
    pub gravity: [f64; 3],
    /// Flags that are disabled, in the order of [`FLAGS`].
    pub(super) disabled: [bool; FLAGS.len()],
}

/// Flags of `<option>` that are read.
pub(super) const FLAGS: [&str; 11] = [
    "constraint",
    "equality",
    "frictionloss",
    "limit",
    "contact",
    "spring",
    "damper",
    "passive",
    "gravity",
    "filterparent",
    "actuation",
];

impl Default for Options {
    fn default() -> Self {
        Self { timestep: 0.002, gravity: [0.0, 0.0, -9.81], disabled: [false; FLAGS.len()] }
    }
}

impl Options {
    /// True where a flag is not disabled, nor one that includes it.
    pub(super) fn enables(&self, flag: &str) -> bool {
        let disabled = |name| FLAGS.iter().position(|flag| *flag == name).is_some_and(|i| self.disabled[i]);
        let outer = match flag {
            "equality" | "frictionloss" | "limit" | "contact" => "constraint",
            "spring" | "damper" => "passive",
            _ => flag,
        };
        !disabled(flag) && !disabled(outer)
    }

    /// Reads all `<option>` elements; later ones go before earlier ones.
    pub(super) fn read(files: &Files, tree: &Tree) -> Result<Self, SceneError> {
        let mut options = Self::default();
        for element in tree.with_tag(0, "option") {
            let values = Values { files, tree, element, defaults: None };
            set(&mut options.timestep, values.number("timestep")?);
            if options.timestep <= 0.0 {
                return Err(values.error("timestep", "expected a time greater than 0"));
            }
            set(&mut options.gravity, values.numbers("gravity")?);
            for element in tree.with_tag(element, "flag") {
                let values = Values { files, tree, element, defaults: None };
                for (disabled, name) in options.disabled.iter_mut().zip(FLAGS) {
                    let found = values.keyword(name, &["enable", "disable"])?;
                    set(disabled, found.map(|index| index == 1));
                }
            }
        }
        if !options.enables("gravity") {
            options.gravity = [0.0; 3];
        }
        Ok(options)
    }
}
