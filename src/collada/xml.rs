//! The file as a light arena of elements: names, attributes and text are ranges of the source, nothing large is copied.

use std::borrow::Cow;
use std::ops::Range;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::error::Fault;

/// Deepest nesting of elements that is read.
pub const DEPTH_LIMIT: usize = 256;

/// One parsed file. Element 0 is the root.
pub struct Xml {
    pub source: String,
    elements: Vec<Record>,
    attributes: Vec<Attribute>,
    /// What text and arena have left of the memory.
    pub left_bytes: u64,
}

struct Record {
    /// Source range of the name without its namespace prefix.
    name: Range<usize>,
    parent: Option<usize>,
    first_child: Option<usize>,
    last_child: Option<usize>,
    next_sibling: Option<usize>,
    attributes: Range<usize>,
    text: Vec<Piece>,
}

pub struct Attribute {
    /// Range of the source, as the value's.
    pub name: Range<usize>,
    pub value: Range<usize>,
    /// What the value means, where that differs from how it is written.
    pub unescaped: Option<String>,
}

/// Text comes in pieces where comments, entities or child elements interrupt it.
enum Piece {
    Source(Range<usize>),
    Character(char),
}

/// Parses the whole text. Errors: not well-formed, a document type definition, nesting beyond [`DEPTH_LIMIT`], so many
/// elements that text and arena take more than `max_bytes` (an element of four letters takes 30 times as many bytes).
/// The source is handed back with the fault so that the caller can show the place.
pub fn parse(source: String, max_bytes: u64) -> Result<Xml, Box<(Fault, Xml)>> {
    let mut xml = Xml::over(String::new());
    let result = xml.fill(&source, max_bytes);
    xml.source = source;
    match result {
        Ok(()) => Ok(xml),
        Err(fault) => Err(Box::new((fault, xml))),
    }
}

fn fault(span: Range<usize>, message: impl Into<String>) -> Fault {
    Fault { span, element: None, message: message.into(), hint: None }
}

impl Xml {
    /// An arena without elements over a text.
    pub fn over(source: String) -> Self {
        Self { source, elements: Vec::new(), attributes: Vec::new(), left_bytes: 0 }
    }

    fn fill(&mut self, source: &str, max_bytes: u64) -> Result<(), Fault> {
        self.left_bytes = max_bytes.saturating_sub(source.len() as u64);
        let mut reader = Reader::from_str(source);
        let mut open: Vec<usize> = Vec::new();
        loop {
            let start = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| {
                let at = reader.error_position() as usize;
                fault(at..at + 1, format!("not well-formed XML: {error}"))
            })?;
            let end = reader.buffer_position() as usize;
            let taken = match &event {
                Event::Start(tag) | Event::Empty(tag) => size_of::<Record>() + tag.len() / 5 * size_of::<Attribute>(),
                Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) => size_of::<Piece>(),
                _ => 0,
            };
            self.left_bytes = self.left_bytes.checked_sub(taken as u64).ok_or_else(|| {
                fault(start..end, format!("so many elements take more than {max_bytes} bytes of memory"))
                    .hint("raise --max-memory if the file is right")
            })?;
            match event {
                Event::Start(tag) => {
                    if open.len() == DEPTH_LIMIT {
                        return Err(fault(start..end, format!("elements are nested deeper than {DEPTH_LIMIT}")));
                    }
                    let index = self.open_element(source, start, &tag, open.last().copied())?;
                    open.push(index);
                }
                Event::Empty(tag) => {
                    self.open_element(source, start, &tag, open.last().copied())?;
                }
                Event::End(_) => {
                    open.pop();
                }
                Event::Text(_) => self.text(source, &open, Piece::Source(start..end))?,
                // `<![CDATA[` is 9 bytes, `]]>` is 3.
                Event::CData(_) => self.text(source, &open, Piece::Source(start + 9..end - 3))?,
                Event::GeneralRef(_) => {
                    let raw = &source[start..end];
                    let resolved =
                        quick_xml::escape::unescape(raw).map_err(|error| fault(start..end, error.to_string()))?;
                    for character in resolved.chars() {
                        self.text(source, &open, Piece::Character(character))?;
                    }
                }
                Event::DocType(_) => {
                    return Err(
                        fault(start..end, "a document type definition is refused").hint("remove the <!DOCTYPE>")
                    );
                }
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
                Event::Eof => break,
            }
        }
        match open.last() {
            Some(&index) => {
                let name = self.elements[index].name.clone();
                let message = format!("not well-formed XML: <{}> is never closed", &source[name.clone()]);
                Err(fault(name, message))
            }
            None if self.elements.is_empty() => Err(fault(0..1, "not well-formed XML: there is no root element")),
            None => Ok(()),
        }
    }

    fn open_element(
        &mut self,
        source: &str,
        start: usize,
        tag: &BytesStart,
        parent: Option<usize>,
    ) -> Result<usize, Fault> {
        let full = start + 1..start + 1 + tag.name().as_ref().len();
        if parent.is_none() && !self.elements.is_empty() {
            return Err(fault(full, "not well-formed XML: a second root element"));
        }
        let name = full.start + source[full.clone()].rfind(':').map_or(0, |colon| colon + 1)..full.end;
        let mut attributes = Vec::new();
        // Attribute slices borrow from the tag, which begins just after `<`: their addresses give the offsets.
        let base = tag.as_ptr() as usize;
        let offset = |slice: &[u8]| start + 1 + (slice.as_ptr() as usize - base);
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| fault(full.clone(), format!("not well-formed XML: {error}")))?;
            let name_start = offset(attribute.key.as_ref());
            let name = name_start..name_start + attribute.key.as_ref().len();
            let value_start = offset(&attribute.value);
            let value = value_start..value_start + attribute.value.len();
            let raw = &source[value.clone()];
            let unescaped = match quick_xml::escape::unescape(raw) {
                Ok(Cow::Borrowed(_)) => None,
                Ok(Cow::Owned(text)) => Some(text),
                Err(error) => return Err(fault(value, format!("not well-formed XML: {error}"))),
            };
            attributes.push(Attribute { name, value, unescaped });
        }
        Ok(self.add(parent, name, attributes))
    }

    /// Appends an element with the name at a range of the source; returns its index.
    pub fn add(&mut self, parent: Option<usize>, name: Range<usize>, attributes: Vec<Attribute>) -> usize {
        let index = self.elements.len();
        let first_attribute = self.attributes.len();
        self.attributes.extend(attributes);
        self.elements.push(Record {
            name,
            parent,
            first_child: None,
            last_child: None,
            next_sibling: None,
            attributes: first_attribute..self.attributes.len(),
            text: Vec::new(),
        });
        if let Some(parent) = parent {
            match self.elements[parent].last_child.replace(index) {
                Some(previous) => self.elements[previous].next_sibling = Some(index),
                None => self.elements[parent].first_child = Some(index),
            }
        }
        index
    }

    fn text(&mut self, source: &str, open: &[usize], piece: Piece) -> Result<(), Fault> {
        let blank = match &piece {
            Piece::Source(range) => source[range.clone()].bytes().all(|byte| byte.is_ascii_whitespace()),
            Piece::Character(_) => false,
        };
        match (open.last(), piece) {
            (_, _) if blank => {}
            (Some(&index), piece) => self.elements[index].text.push(piece),
            (None, Piece::Source(range)) => {
                return Err(fault(range, "not well-formed XML: text outside the root element"));
            }
            (None, Piece::Character(_)) => {
                return Err(fault(0..1, "not well-formed XML: text outside the root element"));
            }
        }
        Ok(())
    }

    pub fn root(&self) -> Element<'_> {
        Element { xml: self, index: 0 }
    }

    /// Every element, in document order.
    pub fn all(&self) -> impl Iterator<Item = Element<'_>> {
        (0..self.elements.len()).map(|index| Element { xml: self, index })
    }
}

/// A handle to one element.
#[derive(Clone, Copy)]
pub struct Element<'a> {
    xml: &'a Xml,
    index: usize,
}

impl<'a> Element<'a> {
    pub fn new(xml: &'a Xml, index: usize) -> Self {
        Self { xml, index }
    }

    pub fn index(self) -> usize {
        self.index
    }

    fn record(self) -> &'a Record {
        &self.xml.elements[self.index]
    }

    /// Without namespace prefix.
    pub fn name(self) -> &'a str {
        &self.xml.source[self.record().name.clone()]
    }

    /// Byte offset of the name in the source.
    pub fn offset(self) -> usize {
        self.record().name.start
    }

    pub fn parent(self) -> Option<Self> {
        self.record().parent.map(|index| Self { index, ..self })
    }

    pub fn children(self) -> impl Iterator<Item = Self> {
        std::iter::successors(self.record().first_child, move |&index| self.xml.elements[index].next_sibling)
            .map(move |index| Self { index, ..self })
    }

    /// The first child of that name.
    pub fn child(self, name: &str) -> Option<Self> {
        self.children().find(|child| child.name() == name)
    }

    pub fn children_named(self, name: &'a str) -> impl Iterator<Item = Self> {
        self.children().filter(move |child| child.name() == name)
    }

    /// Follows child names down.
    pub fn descend(self, names: &[&str]) -> Option<Self> {
        names.iter().try_fold(self, |element, name| element.child(name))
    }

    fn attribute_record(self, name: &str) -> Option<&'a Attribute> {
        let attributes = &self.xml.attributes[self.record().attributes.clone()];
        attributes.iter().find(|attribute| &self.xml.source[attribute.name.clone()] == name)
    }

    pub fn attribute(self, name: &str) -> Option<&'a str> {
        self.attribute_record(name).map(|attribute| match &attribute.unescaped {
            Some(text) => text.as_str(),
            None => &self.xml.source[attribute.value.clone()],
        })
    }

    pub fn attribute_names(self) -> impl Iterator<Item = &'a str> {
        self.xml.attributes[self.record().attributes.clone()]
            .iter()
            .map(move |attribute| &self.xml.source[attribute.name.clone()])
    }

    /// All text directly inside, trimmed.
    pub fn text(self) -> Cow<'a, str> {
        match self.record().text.as_slice() {
            [Piece::Source(range)] => Cow::Borrowed(self.xml.source[range.clone()].trim()),
            pieces => {
                let mut joined = String::new();
                for piece in pieces {
                    match piece {
                        Piece::Source(range) => joined.push_str(&self.xml.source[range.clone()]),
                        Piece::Character(character) => joined.push(*character),
                    }
                }
                Cow::Owned(joined.trim().to_owned())
            }
        }
    }

    /// Byte offset and text of each piece, for lists of numbers.
    pub fn pieces(self) -> impl Iterator<Item = (usize, &'a str)> {
        self.record().text.iter().filter_map(move |piece| match piece {
            Piece::Source(range) => Some((range.start, &self.xml.source[range.clone()])),
            Piece::Character(_) => None,
        })
    }

    /// `COLLADA/library_effects/effect[@id='x']/...`
    pub fn path(self) -> String {
        let mut steps: Vec<String> = std::iter::successors(Some(self), |element| element.parent())
            .map(|element| match (element.attribute("id"), element.attribute("sid")) {
                (Some(id), _) => format!("{}[@id='{id}']", element.name()),
                (None, Some(sid)) => format!("{}[@sid='{sid}']", element.name()),
                (None, None) => element.name().to_owned(),
            })
            .collect();
        steps.reverse();
        steps.join("/")
    }

    /// An error that points at the element's name.
    pub fn fault(self, message: impl Into<String>) -> Fault {
        self.fault_at(self.record().name.clone(), message)
    }

    /// An error that points at a byte range inside the element.
    pub fn fault_at(self, span: Range<usize>, message: impl Into<String>) -> Fault {
        Fault { span, element: Some(self.index), message: message.into(), hint: None }
    }

    /// An error that points at an attribute's name.
    pub fn fault_at_name(self, attribute: &str, message: impl Into<String>) -> Fault {
        let span = self.attribute_record(attribute).map_or(self.record().name.clone(), |record| record.name.clone());
        self.fault_at(span, message)
    }

    /// An error that points at an attribute's value.
    pub fn fault_at_value(self, attribute: &str, message: impl Into<String>) -> Fault {
        let span = self.attribute_record(attribute).map_or(self.record().name.clone(), |record| record.value.clone());
        self.fault_at(span, message)
    }

    /// An error that points at the text inside the element.
    pub fn fault_at_text(self, message: impl Into<String>) -> Fault {
        let span = self.pieces().next().map(|(start, text)| {
            let lead = text.len() - text.trim_start().len();
            start + lead..start + lead + text.trim().len()
        });
        self.fault_at(span.unwrap_or(self.record().name.clone()), message)
    }
}
