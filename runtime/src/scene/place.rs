//! Where a value is: its path in the document, and the line and column of that path in a text.

use std::fmt;

/// A path in the document as a chain of steps on the stack: nothing is written out unless there is an error.
#[derive(Clone, Copy)]
pub(super) enum Place<'a> {
    /// The document.
    Root,
    /// A field or a named entry.
    Key(&'a Place<'a>, &'a str),
    /// An entry of a list.
    Index(&'a Place<'a>, usize),
}

impl<'a> Place<'a> {
    pub(super) fn key(&'a self, name: &'a str) -> Place<'a> {
        Place::Key(self, name)
    }

    pub(super) fn index(&'a self, index: usize) -> Place<'a> {
        Place::Index(self, index)
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Root => Ok(()),
            Place::Key(Place::Root, name) => write!(f, "{name}"),
            Place::Key(outer, name) => write!(f, "{outer}.{name}"),
            Place::Index(outer, index) => write!(f, "{outer}[{index}]"),
        }
    }
}

/// Line and column, from 1, of the value at `path` in a JSON text; the column counts bytes. Of the innermost
/// value on the way where the path goes on into what the text leaves out; `None` when the text is not JSON.
pub(super) fn locate(text: &[u8], path: &str) -> Option<(usize, usize)> {
    let mut scan = Scan { text, at: 0 };
    scan.space();
    let mut found = scan.at;
    let mut rest = path;
    while !rest.is_empty() && scan.enter(&mut rest)? {
        found = scan.at;
    }
    let before = &text[..found.min(text.len())];
    let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
    let column = found - before.iter().rposition(|&byte| byte == b'\n').map_or(0, |feed| feed + 1) + 1;
    Some((line, column))
}

/// A reader of JSON that was accepted before: it checks only what it needs to not run astray.
struct Scan<'a> {
    text: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r' | b'\n')) {
            self.at += 1;
        }
        // The mark that some editors put at the start of a file.
        if self.at == 0 && self.text.starts_with(b"\xef\xbb\xbf") {
            self.at = 3;
            self.space();
        }
    }

    /// Goes to the child that the path's first step names and takes the step off; false when there is none.
    fn enter(&mut self, path: &mut &str) -> Option<bool> {
        let start = self.at;
        match self.peek()? {
            b'[' => {
                let Some(inner) = path.strip_prefix('[') else { return Some(false) };
                let (index, rest) = inner.split_once(']')?;
                *path = rest;
                let index: usize = index.parse().ok()?;
                self.child(|position, _| position == index, start)
            }
            b'{' => {
                // Names may contain dots: the longest key that the path starts with is the one.
                let wanted = path.strip_prefix('.').unwrap_or(path);
                let key = self.longest_key(wanted)?;
                self.at = start;
                if key.is_empty() {
                    return Some(false);
                }
                *path = &wanted[key.len()..];
                self.child(|_, name| name == key.as_bytes(), start)
            }
            _ => Some(false),
        }
    }

    /// The longest key of the object here with which `wanted` starts and after which a step begins or it
    /// ends.
    fn longest_key(&mut self, wanted: &str) -> Option<String> {
        let mut longest = String::new();
        self.entries(|_, name| {
            let ends = |rest: &[u8]| rest.is_empty() || rest[0] == b'.' || rest[0] == b'[';
            let name = std::str::from_utf8(name).unwrap_or("");
            if wanted.starts_with(name)
                && ends(&wanted.as_bytes()[name.len()..])
                && name.len() > longest.len()
            {
                longest = name.to_string();
            }
            false
        })?;
        Some(longest)
    }

    /// Stands on the value of the entry that `choose` likes, or where it stood.
    fn child(&mut self, choose: impl FnMut(usize, &[u8]) -> bool, start: usize) -> Option<bool> {
        let found = self.entries(choose)?;
        if !found {
            self.at = start;
        }
        Some(found)
    }

    /// Walks over the entries of the list or object here until `choose(index, key)`; then stands on that
    /// value.
    fn entries(&mut self, mut choose: impl FnMut(usize, &[u8]) -> bool) -> Option<bool> {
        let keyed = self.peek()? == b'{';
        self.at += 1;
        for index in 0.. {
            self.space();
            if matches!(self.peek()?, b']' | b'}') {
                return Some(false);
            }
            let mut key = 0..0;
            if keyed {
                let start = self.at + 1;
                self.skip()?;
                key = start..self.at - 1;
                self.space();
                self.at += 1;
                self.space();
            }
            if choose(index, self.text.get(key)?) {
                return Some(true);
            }
            self.skip()?;
            self.space();
            if self.peek()? == b',' {
                self.at += 1;
            }
        }
        None
    }

    /// Goes behind the value here, without recursion: a text may nest as deep as it likes.
    fn skip(&mut self) -> Option<()> {
        let mut depth = 0usize;
        loop {
            match self.peek()? {
                b'"' => self.skip_string()?,
                b'[' | b'{' => {
                    depth += 1;
                    self.at += 1;
                }
                b']' | b'}' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' | b' ' | b'\t' | b'\r' | b'\n' => self.at += 1,
                _ => {
                    while !matches!(
                        self.peek(),
                        None | Some(b',' | b':' | b']' | b'}' | b' ' | b'\t' | b'\r' | b'\n' | b'"')
                    ) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }

    fn skip_string(&mut self) -> Option<()> {
        self.at += 1;
        loop {
            match self.peek()? {
                b'\\' => self.at += 2,
                b'"' => {
                    self.at += 1;
                    return Some(());
                }
                _ => self.at += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "{\n  \"a\": [1, {\"b.c\": true, \"b\": \"x]\\\"\"}],\n  \"d\": {}\n}";

    #[test]
    fn finds_values() {
        assert_eq!(locate(TEXT.as_bytes(), ""), Some((1, 1)));
        assert_eq!(locate(TEXT.as_bytes(), "a"), Some((2, 8)));
        assert_eq!(locate(TEXT.as_bytes(), "a[0]"), Some((2, 9)));
        assert_eq!(locate(TEXT.as_bytes(), "a[1].b"), Some((2, 31)));
        assert_eq!(locate(TEXT.as_bytes(), "a[1].b.c"), Some((2, 20)));
        assert_eq!(locate(TEXT.as_bytes(), "d"), Some((3, 8)));
    }

    #[test]
    fn falls_back_to_the_innermost_value() {
        assert_eq!(locate(TEXT.as_bytes(), "d.missing.more"), Some((3, 8)));
        assert_eq!(locate(TEXT.as_bytes(), "a[7]"), Some((2, 8)));
        assert_eq!(locate(b"\xef\xbb\xbf {}", "d"), Some((1, 5)));
    }

    #[test]
    fn survives_what_is_not_json() {
        for end in 0..TEXT.len() {
            for path in ["a[1].b", "d.x", "a[3][4]"] {
                locate(&TEXT.as_bytes()[..end], path);
            }
        }
        let deep = "[".repeat(1_000_000);
        assert_eq!(locate(deep.as_bytes(), "[0]"), Some((1, 2)));
        assert_eq!(locate(b"]]}", "a"), Some((1, 1)));
    }

    #[test]
    fn writes_paths() {
        let bodies = Place::Root.key("bodies");
        let body = bodies.index(3);
        assert_eq!(body.key("user").to_string(), "bodies[3].user");
    }
}
