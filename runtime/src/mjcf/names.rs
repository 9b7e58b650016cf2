//! Names of things, before and after replication.
//!
//! A thing within `<replicate>` gets the copy's number behind its name. What refers to it by the name in the file
//! is meant once for each copy; what refers to it by the name with numbers means that copy. So a thing is known by
//! every name on the way: of `a` in copy 1 of an inner and copy 0 of an outer replicate, `a` (in copies 1 and 0),
//! `a1` (in copy 0) and `a10`.

use std::collections::BTreeMap;

/// A replicate, by its element, and the number of the copy.
pub(super) type Copied = (usize, usize);

/// Something that can be referred to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Thing {
    /// An element `<body>`, by its index among all.
    Body(usize),
    /// A site.
    Site(usize),
    /// A joint's index and that of its part.
    Joint(usize, usize),
    /// A free joint.
    FreeJoint,
}

/// Kinds of things have names of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Body,
    Site,
    Joint,
}

/// Copies that are still to be told, the innermost first, and what is meant then.
type Choices = BTreeMap<Vec<Copied>, Thing>;

/// Choices that are looked at for all references of all models together: enough for as many copies as a model
/// may have.
pub(super) const WORK_MAX: usize = 1 << 21;

/// Why something cannot be resolved.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Unresolved {
    /// Nothing has the name with this index.
    Unknown(usize),
    /// Too many combinations of copies.
    TooMany,
}

/// The copy of a replicate that is being read.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub copied: Copied,
    /// What goes behind names.
    pub suffix: String,
}

/// All names of one model.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeMap<(Kind, String), Choices>);

impl Names {
    /// Adds a thing named `name` in the file, within copies `levels`, the outermost first. False when its full
    /// name is taken.
    pub(super) fn add(&mut self, kind: Kind, name: &str, levels: &[Level], thing: Thing) -> bool {
        let mut alias = name.to_string();
        for known in (0..=levels.len()).rev() {
            // Copies `known..` are in the alias, those before are to be told.
            let open = levels[..known].iter().rev().map(|level| level.copied).collect();
            let taken = self.0.entry((kind, alias.clone())).or_default().insert(open, thing).is_some();
            if taken {
                return false;
            }
            if known > 0 {
                alias += &levels[known - 1].suffix;
            }
        }
        true
    }

    /// The things of an attached model, under a prefix. The first name that is taken, without the copies' numbers,
    /// otherwise.
    pub(super) fn attach(&mut self, inner: Self, prefix: &str, levels: &[Level]) -> Result<(), String> {
        for ((kind, name), choices) in inner.0 {
            let Some(&thing) = choices.get(&[][..]) else { continue };
            let name = format!("{prefix}{name}");
            if !self.add(kind, &name, levels, thing) {
                return Err(name);
            }
        }
        Ok(())
    }

    /// What `references` mean together: once for each combination of copies. Takes from `work`, which starts as
    /// [`WORK_MAX`], what it looks at.
    pub(super) fn resolve(
        &self,
        references: &[(Kind, &str)],
        work: &mut usize,
    ) -> Result<Vec<Vec<Thing>>, Unresolved> {
        let mut combinations = vec![Combination::default()];
        for (index, (kind, name)) in references.iter().enumerate() {
            let key = (*kind, name.to_string());
            let choices = self.0.get(&key).ok_or(Unresolved::Unknown(index))?;
            let mut next = Vec::new();
            for combination in combinations {
                combination.extend(choices, work, &mut next)?;
            }
            combinations = next;
        }
        Ok(combinations.into_iter().map(|combination| combination.things).collect())
    }
}

/// Copies chosen so far, and what the references mean with them.
#[derive(Default)]
struct Combination {
    chosen: Vec<Copied>,
    things: Vec<Thing>,
}

impl Combination {
    /// The copy of a replicate, where it is chosen.
    fn copy(&self, replicate: usize) -> Option<usize> {
        self.chosen.iter().find(|chosen| chosen.0 == replicate).map(|chosen| chosen.1)
    }

    /// Adds to `out` this combination with each choice that fits to it.
    fn extend(&self, choices: &Choices, work: &mut usize, out: &mut Vec<Self>) -> Result<(), Unresolved> {
        // All choices of a name are within the same replicates, but for names that copies share by chance.
        let told = |first: &Vec<Copied>| -> Option<Vec<Copied>> {
            first.iter().map(|&(replicate, _)| Some((replicate, self.copy(replicate)?))).collect()
        };
        let told = choices.keys().next().and_then(told);
        let direct = told.and_then(|key| choices.get_key_value(&key));
        let all = direct.is_none().then(|| choices.iter()).into_iter().flatten();
        for (key, &thing) in direct.into_iter().chain(all) {
            *work = work.checked_sub(1 + key.len()).ok_or(Unresolved::TooMany)?;
            if !key.iter().all(|&(replicate, copy)| self.copy(replicate).is_none_or(|known| known == copy)) {
                continue;
            }
            let new = key.iter().filter(|(replicate, _)| self.copy(*replicate).is_none());
            let chosen = self.chosen.iter().chain(new).copied().collect();
            out.push(Self { chosen, things: self.things.iter().copied().chain([thing]).collect() });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(copies: &[usize]) -> Vec<Level> {
        copies
            .iter()
            .enumerate()
            .map(|(depth, &copy)| Level { copied: (depth, copy), suffix: format!("-{copy}") })
            .collect()
    }

    /// Bodies `a` in 2 copies of 3, `b` in the outer ones alone, `c` alone.
    fn names() -> Names {
        let mut names = Names::default();
        for outer in 0..2 {
            for inner in 0..3 {
                assert!(names.add(
                    Kind::Body,
                    "a",
                    &levels(&[outer, inner]),
                    Thing::Body(outer * 10 + inner)
                ));
            }
            assert!(names.add(Kind::Body, "b", &levels(&[outer]), Thing::Body(100 + outer)));
        }
        assert!(names.add(Kind::Body, "c", &[], Thing::Body(200)));
        names
    }

    fn numbers(names: &Names, references: &[&str]) -> Result<Vec<Vec<usize>>, Unresolved> {
        let references: Vec<_> = references.iter().map(|name| (Kind::Body, *name)).collect();
        let number = |thing| if let Thing::Body(number) = thing { number } else { usize::MAX };
        Ok(names
            .resolve(&references, &mut WORK_MAX.clone())?
            .into_iter()
            .map(|things| things.into_iter().map(number).collect())
            .collect())
    }

    #[test]
    fn copies_meet_their_own() {
        let names = names();
        let all = [[0, 100], [1, 100], [2, 100], [10, 101], [11, 101], [12, 101]].map(Vec::from);
        let mut found = numbers(&names, &["a", "b"]).unwrap();
        found.sort();
        assert_eq!(found, all);
        assert_eq!(numbers(&names, &["a-1", "b"]).unwrap(), [[1, 100], [11, 101]]);
        assert_eq!(numbers(&names, &["a-2-1", "c"]).unwrap(), [[12, 200]]);
        assert_eq!(numbers(&names, &["a-0", "a-1"]).unwrap(), [[0, 1], [10, 11]]);
        assert_eq!(numbers(&names, &["c", "b"]).unwrap(), [[200, 100], [200, 101]]);
        assert_eq!(numbers(&names, &["c", "d"]), Err(Unresolved::Unknown(1)));
    }

    #[test]
    fn full_names_are_unique() {
        let mut names = names();
        assert!(!names.add(Kind::Body, "c", &[], Thing::Body(0)));
        assert!(!names.add(Kind::Body, "a-1-0", &[], Thing::Body(0)));
        assert!(names.add(Kind::Site, "c", &[], Thing::Site(0)));
    }

    #[test]
    fn attached_names_have_the_prefix() {
        let mut outer = Names::default();
        for copy in 0..2 {
            outer.attach(names(), "p_", &levels(&[copy])).unwrap();
        }
        assert_eq!(numbers(&outer, &["p_c"]).unwrap().len(), 2);
        assert_eq!(numbers(&outer, &["p_a-2-1-0"]).unwrap(), [[12]]);
        assert_eq!(outer.attach(names(), "p_", &levels(&[1])).unwrap_err(), "p_a-0-0");
    }

    #[test]
    fn combinations_are_bounded() {
        let mut names = Names::default();
        for (replicate, name) in ["a", "b"].into_iter().enumerate() {
            for copy in 0..4000 {
                let level = Level { copied: (replicate, copy), suffix: format!("{copy}") };
                assert!(names.add(Kind::Body, name, &[level], Thing::Body(copy)));
            }
        }
        assert_eq!(numbers(&names, &["a", "b"]), Err(Unresolved::TooMany));
        assert_eq!(numbers(&names, &["a", "a"]).unwrap().len(), 4000);
    }
}
