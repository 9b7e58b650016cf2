//! Document to text: tables and lists of the document line by line, each body on one line.

use super::format::Scene;
use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};
use std::io::{self, Write};

/// Objects and lists that are nested deeper than this are written on one line.
const LINES_DEPTH: usize = 2;

impl Scene {
    /// The document as JSON text: a line for each body and each asset, with a line feed at the end.
    pub fn to_json(&self) -> String {
        let mut text = Vec::new();
        // Writing to memory fails only for maps whose keys are not strings: there are none.
        self.serialize(&mut Serializer::with_formatter(&mut text, Lines::default()))
            .expect("keys are strings");
        text.push(b'\n');
        String::from_utf8(text).expect("JSON is UTF-8")
    }
}

#[derive(Default)]
struct Lines {
    depth: usize,
    /// Whether something was written since the innermost bracket that opened.
    filled: bool,
}

impl Lines {
    fn open<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.depth += 1;
        self.filled = false;
        out.write_all(bracket)
    }

    fn close<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.depth -= 1;
        if self.filled && self.depth < LINES_DEPTH {
            self.feed(out)?;
        }
        self.filled = true;
        out.write_all(bracket)
    }

    fn entry<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        let lines = self.depth <= LINES_DEPTH;
        if !first {
            out.write_all(if lines { b"," } else { b", " })?;
        }
        if lines { self.feed(out) } else { Ok(()) }
    }

    fn feed<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        out.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| out.write_all(b"  "))
    }
}

impl Formatter for Lines {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.entry(out, first)
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.entry(out, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::format::{BodyDoc, GeometryDoc, ShapeDoc};

    #[test]
    fn a_body_is_a_line() {
        let ball = BodyDoc {
            shapes: vec![ShapeDoc::new(GeometryDoc::Sphere { radius: 0.1 })],
            ..BodyDoc::default()
        };
        let scene = Scene { bodies: vec![ball, BodyDoc::default()], ..Scene::default() };
        let expected = r#"{
  "version": 1,
  "gravity": [
    0.0,
    0.0,
    -9.81
  ],
  "bodies": [
    {"position": [0.0, 0.0, 0.0], "shapes": [{"geometry": {"sphere": {"radius": 0.1}}}]},
    {"position": [0.0, 0.0, 0.0], "shapes": []}
  ]
}
"#;
        assert_eq!(scene.to_json(), expected);
        assert!(Scene::default().to_json().contains("\"bodies\": []\n}"));
    }
}
