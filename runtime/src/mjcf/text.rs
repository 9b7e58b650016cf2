//! What is checked of XML text before a parser sees it, in one pass without memory: size, nesting, counts, and
//! the absence of what a model never needs and what has been used for attacks.
//!
//! A document type may define entities that grow without bound or read files; namespaces are copied from element
//! to element; attributes of an element are compared each with each. So a model has no document type and no
//! namespaces, and its attributes per element are few.

/// Most elements inside each other.
pub(super) const DEPTH_MAX: usize = 200;
/// Most attributes of an element.
pub(super) const ATTRIBUTES_MAX: usize = 64;
/// Most elements of a model with all its files.
pub(super) const ELEMENTS_MAX: usize = 1 << 20;
/// Most brackets, and most equals signs, of a file.
const MARKS_MAX: usize = 4 * ELEMENTS_MAX;

/// What is wrong, at a byte of the text.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Mistake {
    /// Where, from 0.
    pub at: usize,
    /// What was found and what was expected.
    pub message: String,
}

fn mistake(at: usize, message: impl ToString) -> Mistake {
    Mistake { at, message: message.to_string() }
}

/// Refuses text that asks too much of a parser. Whether it is XML is for the parser to say.
pub(super) fn check(text: &[u8]) -> Result<(), Mistake> {
    // The parser reserves memory by these, wherever they stand.
    for mark in *b"<=" {
        if text.iter().filter(|&&byte| byte == mark).count() > MARKS_MAX {
            let message = format!("more than {MARKS_MAX} signs `{}`, expected fewer", char::from(mark));
            return Err(mistake(0, message));
        }
    }
    let mut scan = Scan { text, at: 0, depth: 0, elements: 0 };
    while let Some(open) = scan.find(b"<") {
        scan.at = open;
        scan.markup()?;
    }
    Ok(())
}

struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    depth: usize,
    elements: usize,
}

impl Scan<'_> {
    fn find(&self, what: &[u8]) -> Option<usize> {
        let rest = self.text.get(self.at..)?;
        rest.windows(what.len()).position(|window| window == what).map(|offset| self.at + offset)
    }

    fn starts_with(&self, what: &[u8]) -> bool {
        self.text[self.at..].starts_with(what)
    }

    /// Goes behind the end of what was opened; to the end of the text when it is never closed.
    fn skip_to(&mut self, end: &[u8]) {
        self.at = self.find(end).map_or(self.text.len(), |found| found + end.len());
    }

    fn markup(&mut self) -> Result<(), Mistake> {
        if self.starts_with(b"<!--") {
            self.at += 4;
            self.skip_to(b"-->");
        } else if self.starts_with(b"<![CDATA[") {
            self.skip_to(b"]]>");
        } else if self.starts_with(b"<!") {
            let message = "a document type or entities, expected none: write out what they stand for";
            return Err(mistake(self.at, message));
        } else if self.starts_with(b"<?") {
            self.skip_to(b"?>");
        } else if self.starts_with(b"</") {
            self.depth = self.depth.saturating_sub(1);
            self.skip_to(b">");
        } else {
            return self.element();
        }
        Ok(())
    }

    /// A start tag, from its bracket on.
    fn element(&mut self) -> Result<(), Mistake> {
        let start = self.at;
        self.depth += 1;
        self.elements += 1;
        if self.depth > DEPTH_MAX {
            let message = format!("elements nested {} deep, expected at most {DEPTH_MAX}", self.depth);
            return Err(mistake(start, message));
        }
        if self.elements > ELEMENTS_MAX {
            return Err(mistake(start, format!("more than {ELEMENTS_MAX} elements, expected fewer")));
        }
        let (mut attributes, mut quote) = (0, None);
        while let Some(&byte) = self.text.get(self.at) {
            self.at += 1;
            match (quote, byte) {
                (Some(open), _) if open == byte => quote = None,
                (Some(_), _) => {}
                (None, b'"' | b'\'') => quote = Some(byte),
                (None, b'=') => attributes += 1,
                (None, b'>') => break,
                (None, b'x') if self.text[self.at - 2].is_ascii_whitespace() && self.starts_with(b"mlns") => {
                    return Err(mistake(self.at - 1, "a namespace, expected none: models have no `xmlns`"));
                }
                _ => {}
            }
        }
        if attributes > ATTRIBUTES_MAX {
            let message =
                format!("{attributes} attributes of one element, expected at most {ATTRIBUTES_MAX}");
            return Err(mistake(start, message));
        }
        if self.text[..self.at].ends_with(b"/>") {
            self.depth -= 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordinary_text_passes() {
        let text = b"<?xml version='1.0'?><!-- <a <b --><m a='>' b=\"<!DOCTYPE\"><![CDATA[<<]]><b/></m>";
        assert_eq!(check(text), Ok(()));
        assert_eq!(check(b""), Ok(()));
        assert_eq!(check(b"<"), Ok(()));
        assert_eq!(check(b"<a b='"), Ok(()));
        assert_eq!(check(b"<!-- never closed"), Ok(()));
    }

    #[test]
    fn attacks_are_seen() {
        let deep = "<a>".repeat(1_000_000);
        assert_eq!(check(deep.as_bytes()).unwrap_err().at, 3 * DEPTH_MAX);
        let siblings = "<a/>".repeat(DEPTH_MAX * 3) + &"<a></a>".repeat(DEPTH_MAX * 3);
        assert_eq!(check(siblings.as_bytes()), Ok(()));
        let laughs = b"<!DOCTYPE lolz [<!ENTITY lol \"lol\">]><m>&lol;</m>";
        assert!(check(laughs).unwrap_err().message.contains("document type"));
        let many = format!("<m {}/>", (0..100).map(|i| format!("a{i}='1' ")).collect::<String>());
        assert!(check(many.as_bytes()).unwrap_err().message.contains("100 attributes"));
        assert!(check(b"<m xmlns:a='b'/>").unwrap_err().message.contains("namespace"));
        assert_eq!(check(b"<m a=' xmlns'/>"), Ok(()));
        let signs = format!("<!--{}--><m/>", "=".repeat(MARKS_MAX + 1));
        assert!(check(signs.as_bytes()).unwrap_err().message.contains("signs `=`"));
    }
}
