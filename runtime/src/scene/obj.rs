//! Wavefront OBJ files as triangle meshes.
//!
//! `tobj` reads the text; only positions and faces are asked of it, in one index, so that vertices which
//! faces of different objects share stay shared (the engine smooths contacts over shared edges). Its own
//! triangulation is a fan, wrong for concave faces: faces are taken as they are and ear-clipped in
//! [`super::polygon`].
//!
//! The file comes from a stranger. It must lie below the scene's folder and be an ordinary file; its size is
//! checked before it is read; every line goes to the reader alone, so that a mistake has a line number;
//! texture coordinates, normals and colours are cut off before they are read, and with them their mistakes.

use super::clean::{Notes, Soup};
use super::error::{Problem, SceneError};
use super::format::MESH_PARTS_MAX;
use super::polygon::Clipper;
use std::fs::File;
use std::io::{self, BufRead, Read};
use std::path::{Component, Path};

/// Most corners of a face: clipping takes more than linear time, and no tool writes such faces.
const CORNERS_MAX: usize = 1 << 12;

/// Says what is wrong with a path given in a scene; `Ok` when it stays below the scene's folder.
pub(super) fn check_path(path: &str) -> Result<(), String> {
    let sound = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if path.is_empty() {
        return Err("found an empty path".to_string());
    }
    // Backslashes and drive letters would be folders on one system and names on another.
    let portable = !path.contains(['\\', ':', '\0']);
    if portable && Path::new(path).components().all(sound) { Ok(()) } else { Err(format!("found {path:?}")) }
}

/// Reads the OBJ file at `file`, of at most `bytes_max` bytes, into polygons cut into triangles.
///
/// Errors name the file, and the line where there is one.
pub(crate) fn read(file: &Path, bytes_max: u64) -> Result<(Soup, Notes), SceneError> {
    let fail = |line: Option<usize>, problem| SceneError {
        file: Some(file.to_path_buf()),
        at: line.map(|line| (line, 1)),
        path: String::new(),
        problem,
    };
    let text = read_file(file, bytes_max).map_err(|problem| fail(None, problem))?;
    parse(&text).map_err(|(line, message)| fail(line, Problem::Mesh(message)))
}

/// The bytes of an ordinary file of at most `bytes_max` bytes.
pub(crate) fn read_file(file: &Path, bytes_max: u64) -> Result<Vec<u8>, Problem> {
    let meta = std::fs::metadata(file).map_err(Problem::Read)?;
    if !meta.is_file() {
        let message = "not an ordinary file";
        return Err(Problem::Read(io::Error::new(io::ErrorKind::InvalidInput, message)));
    }
    let too_large = |asked| Problem::TooLarge { what: "bytes", asked, limit: bytes_max };
    if meta.len() > bytes_max {
        return Err(too_large(meta.len()));
    }
    // A file may grow between the two looks at it.
    let mut bytes = Vec::new();
    File::open(file).and_then(|f| f.take(bytes_max + 1).read_to_end(&mut bytes)).map_err(Problem::Read)?;
    if bytes.len() as u64 > bytes_max { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

/// What is wrong with a text, and the line, from 1, when one line is to blame.
type Mistake = (Option<usize>, String);

/// Reads OBJ text.
pub(super) fn parse(text: &[u8]) -> Result<(Soup, Notes), Mistake> {
    let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let mut lines = Lines { text, line: 0, current: Vec::new(), given: 0 };
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let models = tobj::load_obj_buf(&mut lines, &options, no_materials);
    let (models, _) = models.map_err(|error| mistake(error, lines.line))?;
    let mut soup = Soup::default();
    let mut notes = Notes::default();
    let mut clipper = Clipper::default();
    for model in models {
        add(&mut soup, &mut clipper, &mut notes, &model.mesh).map_err(|message| (None, message))?;
    }
    if soup.triangles.is_empty() {
        return Err((None, "no face with an area, expected at least one".to_string()));
    }
    if soup.triangles.len().max(soup.vertices.len()) > MESH_PARTS_MAX {
        let message = format!("too many triangles or vertices, expected at most {MESH_PARTS_MAX} of each");
        return Err((None, message));
    }
    Ok((soup, notes))
}

/// Says an error of the reader, which stopped in `line`, in words that help.
fn mistake(error: tobj::LoadError, line: usize) -> Mistake {
    match error {
        tobj::LoadError::PositionParseError => (Some(line), "a vertex that is not `v x y z`".to_string()),
        tobj::LoadError::FaceParseError => (Some(line), "a face whose corners are not indices".to_string()),
        // Indices are checked when all lines are read: no line is to blame.
        tobj::LoadError::FaceVertexOutOfBounds => {
            let message = "a face has the index of a vertex that does not exist, expected 1 up to the number \
                           of vertices, or negative ones from the end";
            (None, message.to_string())
        }
        other => (Some(line), format!("not a Wavefront OBJ file: {other}")),
    }
}

/// Adds the vertices of a mesh and its faces, cut into triangles.
fn add(soup: &mut Soup, clipper: &mut Clipper, notes: &mut Notes, mesh: &tobj::Mesh) -> Result<(), String> {
    let first = soup.vertices.len() as u32;
    for (index, v) in mesh.positions.chunks_exact(3).enumerate() {
        if !v.iter().all(|x| x.is_finite()) {
            let vertex = first as usize + index;
            return Err(format!("vertex {vertex} of the faces has {v:?}, expected finite numbers"));
        }
        soup.vertices.push([v[0], v[1], v[2]]);
    }
    // No arities means that every face is a triangle.
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    let arities =
        std::iter::repeat_n(3, triangles).chain(mesh.face_arities.iter().map(|&arity| arity as usize));
    let mut rest = &mesh.indices[..];
    for arity in arities {
        if arity > CORNERS_MAX {
            return Err(format!("a face has {arity} corners, expected at most {CORNERS_MAX}"));
        }
        let (corners, others) = rest.split_at(arity);
        rest = others;
        let corners: Vec<u32> = corners.iter().map(|&corner| first + corner).collect();
        clipper.clip(&soup.vertices, &corners, &mut soup.triangles, notes);
    }
    Ok(())
}

/// Hands out one line at a time and knows which. Lines other than vertices and faces come out empty.
struct Lines<'a> {
    text: &'a [u8],
    line: usize,
    current: Vec<u8>,
    given: usize,
}

impl Lines<'_> {
    fn next(&mut self) {
        self.current.clear();
        self.given = 0;
        if self.text.is_empty() {
            return;
        }
        let end = self.text.iter().position(|&byte| byte == b'\n').unwrap_or(self.text.len());
        let (line, rest) = self.text.split_at(end);
        self.text = rest.get(1..).unwrap_or(&[]);
        self.line += 1;
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                self.current.extend_from_slice(b"v");
                // Three coordinates and a weight; six numbers are three coordinates and a colour.
                let words: Vec<&[u8]> = words.collect();
                let count = if words.len() >= 6 { 3 } else { words.len() };
                words[..count].iter().for_each(|word| self.word(word));
            }
            Some(b"f") => {
                self.current.extend_from_slice(b"f");
                words.for_each(|word| self.word(word.split(|&byte| byte == b'/').next().unwrap_or(word)));
            }
            _ => {}
        }
        self.current.push(b'\n');
    }

    fn word(&mut self, word: &[u8]) {
        self.current.push(b' ');
        // `v` and `f` lines are ASCII: anything else must not pass for a number.
        self.current.extend(word.iter().map(|byte| if byte.is_ascii_graphic() { *byte } else { b'?' }));
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let line = self.fill_buf()?;
        let count = line.len().min(out.len());
        out[..count].copy_from_slice(&line[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.given == self.current.len() {
            self.next();
        }
        Ok(&self.current[self.given..])
    }

    fn consume(&mut self, count: usize) {
        self.given += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn error(text: &str) -> (Option<usize>, String) {
        parse(text.as_bytes()).expect_err(text)
    }

    #[test]
    fn reads_faces_of_all_spellings() {
        for face in [
            "f 1 2 3 4",
            "f 1/1 2/2 3/3 4/4",
            "f 1//9 2//9 3//9 4//9",
            "f -4 -3 -2 -1",
            "o x\ng y\nf 1 2 3 4",
        ] {
            let (soup, notes) = parse(format!("# a\n{SQUARE}vt 0 0\n{face}\r\n").as_bytes()).unwrap();
            assert_eq!((soup.vertices.len(), soup.triangles.len()), (4, 2), "{face}");
            assert_eq!(notes, Notes::default());
        }
    }

    #[test]
    fn objects_share_vertices() {
        let (soup, _) = parse(format!("o a\n{SQUARE}f 1 2 3\no b\nusemtl m\nf 1 3 4\n").as_bytes()).unwrap();
        assert_eq!((soup.vertices.len(), soup.triangles.len()), (4, 2));
    }

    #[test]
    fn colours_and_weights() {
        let (soup, _) = parse(b"v 2 0 0 2\nv 0 1 0 0.5 0.5 0.5\nv 0 0 1\nf 1 2 3\n").unwrap();
        assert_eq!(soup.vertices, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn mistakes_have_lines() {
        assert_eq!(error("v 0 0\nf 1 1 1").0, Some(1));
        assert_eq!(error(&format!("{SQUARE}f 1 x 3")).0, Some(5));
        assert_eq!(error("v 1 1 1 0\n").0, Some(1));
        assert_eq!(error(&format!("{SQUARE}f 1 2 99999999999999999999")).0, Some(5));
        assert_eq!(error("v \u{0661} 0 0\n").0, Some(1));
    }

    #[test]
    fn refuses_what_is_no_mesh() {
        assert!(error("").1.contains("no face"));
        assert!(error("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").1.contains("finite"));
        assert!(error("v 1e39 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").1.contains("finite"));
        for index in ["0", "5", "-5", "9223372036854775807", "-9223372036854775808"] {
            assert!(error(&format!("{SQUARE}f 1 2 {index}")).1.contains("does not exist"), "{index}");
        }
        let endless = error(&format!("{SQUARE}f {}\n", "1 2 3 ".repeat(2000)));
        assert!(endless.1.contains("6000 corners, expected at most 4096"), "{}", endless.1);
        assert!(error(&format!("{SQUARE}f\nf 1\nf 1 2\n")).1.contains("no face"));
    }

    #[test]
    fn changed_files_never_panic() {
        let text = format!(
            "o a\n{SQUARE}v 2 0 1e-3 0.5\nv 2 1 0 1 1 1\nvt 0 0\nf 1/1 2/1 3/1 4/1\nf 2 5 6 3 1\nf -1 -2 -3\n"
        );
        let text = text.into_bytes();
        let mut seed = 3u64;
        let mut sound = 0;
        for _ in 0..20_000 {
            let mut changed = text.clone();
            for _ in 0..3 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (seed >> 33) as usize % changed.len();
                changed[at] = b"0123456789.e-/ \nvf\xff"[(seed >> 20) as usize % 19];
            }
            let Ok((soup, mut notes)) = parse(&changed) else { continue };
            sound += 1;
            let soup = super::super::clean::clean(soup, &mut notes);
            assert!(soup.triangles.iter().flatten().all(|&v| (v as usize) < soup.vertices.len()));
        }
        assert!(sound > 1000, "{sound}");
    }

    #[test]
    fn paths_stay_below_the_scene() {
        for path in ["a.obj", "./a.obj", "deep/a b.obj", "..obj"] {
            assert_eq!(check_path(path), Ok(()), "{path}");
        }
        for path in ["", "/etc/passwd", "../a.obj", "a/../../b.obj", "c:\\a.obj", "..\\a.obj", "a\0.obj"] {
            assert!(check_path(path).is_err(), "{path}");
        }
    }
}
