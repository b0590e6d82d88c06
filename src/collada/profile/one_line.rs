//! A surface in one line, as the command line takes it: `conductor Au; film 550nm n=1.33; noise amplitude=0.1`.
//!
//! Clauses between semicolons are the elements of our profile, words `name=value` their attributes. The first clause is the
//! base, `film`s lie on it, outermost first; `noise`, `drain` and `map` belong to the film before them. What an element is
//! mostly about needs no name: the metal, the glass or index, the reflectance, a thickness with its unit, `n` for `ior`.
//! Commas stand for the spaces in lists.

use std::ops::Range;

use crate::collada::error::Fault;
use crate::collada::xml::{Attribute, Xml};

use super::film::VARYING;
use super::material::{BASES, SURFACE_CHILDREN};

/// A line as elements, and where in the line the names stand that it leaves out.
pub struct Line {
    /// Element 0 is the technique, with the base in it.
    pub xml: Xml,
    /// Bytes of `xml.source` that are the line itself; full names follow.
    length: usize,
    /// Start of a full name in the source, and what stands for it in the line.
    implied: Vec<(usize, Range<usize>)>,
}

/// Reads a line. Element names are checked here, everything else when the material is read from the elements.
///
/// # Errors
/// Clauses that are none, and words that say nothing about their element; the second of two attributes of one name.
pub fn parse(text: &str) -> Result<Line, Box<(Fault, Line)>> {
    let mut line = Line { xml: Xml::over(text.to_owned()), length: text.len(), implied: Vec::new() };
    match line.fill(text) {
        Ok(()) => Ok(line),
        Err(fault) => Err(Box::new((fault, line))),
    }
}

impl Line {
    /// The fault with a place in the line itself.
    pub fn settle(&self, fault: Fault) -> Fault {
        let implied = self.implied.iter().find(|(start, _)| *start == fault.span.start);
        let span = match implied {
            Some((_, word)) => word.clone(),
            None => fault.span.start.min(self.length)..fault.span.end.min(self.length),
        };
        Fault { span, element: None, ..fault }
    }

    fn fill(&mut self, text: &str) -> Result<(), Fault> {
        let technique = self.name("technique", 0..text.len());
        self.xml.add(None, technique, Vec::new());
        let (mut base, mut film) = (None, None);
        let mut start = 0;
        for clause in text.split(';') {
            let range = start..start + clause.len();
            start = range.end + 1;
            let mut words = words(text, range);
            let Some(name) = words.next() else { continue };
            let element = &text[name.clone()];
            let parent = match (base, film) {
                (None, _) if BASES.contains(&element) => 0,
                (None, _) => return Err(fault(name, format!("unknown base `{element}`")).suggest(element, BASES)),
                (Some(_), Some(film)) if VARYING.contains(&element) => film,
                (Some(base), _) if VARYING.contains(&element) || SURFACE_CHILDREN.contains(&element) => base,
                _ => {
                    let valid = SURFACE_CHILDREN.into_iter().chain(VARYING);
                    return Err(fault(name, format!("unknown layer `{element}`")).suggest(element, valid));
                }
            };
            let mut attributes: Vec<Attribute> = Vec::new();
            for word in words {
                let attribute = self.attribute(text, element, word.clone())?;
                let own = |range: &Range<usize>| self.xml.source[range.clone()].to_owned();
                let own_name = own(&attribute.name);
                if attributes.iter().any(|other| own(&other.name) == own_name) {
                    return Err(fault(word, format!("`{own_name}` of `{element}` is given twice")));
                }
                attributes.push(attribute);
            }
            let index = self.xml.add(Some(parent), name, attributes);
            match element {
                _ if base.is_none() => base = Some(index),
                "film" => film = Some(index),
                _ => {}
            }
        }
        match base {
            Some(_) => Ok(()),
            None => Err(fault(0..text.len(), "no base").hint(format!("begin with one of {}", BASES.join(", ")))),
        }
    }

    fn attribute(&mut self, text: &str, element: &str, word: Range<usize>) -> Result<Attribute, Fault> {
        let written = &text[word.clone()];
        let (name, mut value) = match written.split_once('=') {
            Some(("n", value)) => (self.name("ior", word.start..word.start + 1), word.end - value.len()..word.end),
            Some((name, value)) => (word.start..word.start + name.len(), word.end - value.len()..word.end),
            None => (self.name(meant(element, written, &word)?, word.clone()), word),
        };
        let full = &self.xml.source[name.clone()];
        if full.ends_with("_nm") && text[value.clone()].ends_with("nm") {
            value.end -= 2;
        }
        let list = full != "image" && text[value.clone()].contains(',');
        let unescaped = list.then(|| text[value.clone()].replace(',', " "));
        Ok(Attribute { name, value, unescaped })
    }

    /// A name that the line leaves out, or shortens to `word`.
    fn name(&mut self, full: &str, word: Range<usize>) -> Range<usize> {
        let source = &mut self.xml.source;
        source.push('\n');
        let start = source.len();
        source.push_str(full);
        self.implied.push((start, word));
        start..start + full.len()
    }
}

/// The attribute that a word without a name gives.
fn meant(element: &str, word: &str, span: &Range<usize>) -> Result<&'static str, Fault> {
    let number = word.starts_with(|c: char| c.is_ascii_digit() || ".+-".contains(c));
    match (element, number) {
        ("conductor", false) => Ok("metal"),
        ("dielectric", true) => Ok("ior"),
        ("dielectric", false) => Ok("glass"),
        ("diffuse", true) => Ok("reflectance"),
        ("emitter", true) => Ok("radiance"),
        ("preset", false) => Ok("name"),
        ("film", true) if word.ends_with("nm") => Ok("thickness_nm"),
        ("film", true) => {
            let hint = format!("write `{word}nm` for a thickness, `n={word}` for an index");
            Err(fault(span.clone(), format!("`{word}` has no unit")).hint(hint))
        }
        ("film", false) => Ok("material"),
        ("opacity", true) => Ok("value"),
        _ => {
            let fault = fault(span.clone(), format!("`{word}` says nothing about `{element}`"));
            Err(fault.hint("attributes are written NAME=VALUE, without spaces around the `=`"))
        }
    }
}

/// The words in a range of the text.
fn words(text: &str, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let base = text.as_ptr() as usize;
    text[range].split_whitespace().map(move |word| {
        let start = word.as_ptr() as usize - base;
        start..start + word.len()
    })
}

fn fault(span: Range<usize>, message: impl Into<String>) -> Fault {
    Fault { span, element: None, message: message.into(), hint: None }
}
