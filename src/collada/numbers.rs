//! Lists of numbers, scanned straight from the source: no string is built per number.

use std::ops::Range;

use super::error::Fault;
use super::xml::Element;

/// Whitespace-separated tokens with their byte ranges in the source.
pub struct Tokens<'a> {
    text: &'a str,
    base: usize,
    position: usize,
}

impl<'a> Tokens<'a> {
    /// `base` is the byte offset of `text` in the source.
    pub fn new(base: usize, text: &'a str) -> Self {
        Self { text, base, position: 0 }
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = (Range<usize>, &'a str);

    fn next(&mut self) -> Option<Self::Item> {
        let bytes = self.text.as_bytes();
        let mut start = self.position;
        while start < bytes.len() && bytes[start] <= b' ' {
            start += 1;
        }
        let mut end = start;
        while end < bytes.len() && bytes[end] > b' ' {
            end += 1;
        }
        self.position = end;
        // Both ends touch ASCII whitespace or the ends of the text, so they are character boundaries.
        (start < end).then(|| (self.base + start..self.base + end, &self.text[start..end]))
    }
}

pub fn tokens<'a>(element: Element<'a>) -> impl Iterator<Item = (Range<usize>, &'a str)> {
    element.pieces().flat_map(|(base, text)| Tokens::new(base, text))
}

/// Where the `n`-th token of the element's text lies (its name when there is no such token).
pub fn token_span(element: Element, n: usize) -> Range<usize> {
    let name = element.offset()..element.offset() + element.name().len();
    tokens(element).nth(n).map_or(name, |(span, _)| span)
}

/// What is wrong with a token that is not a number; decimal commas get their own answer.
pub fn not_a_number(token: &str) -> (String, Option<String>) {
    let shown: String = token.chars().take(24).collect();
    let Some((whole, fraction)) = token.split_once(',') else {
        return (format!("`{shown}` is not a number"), None);
    };
    if !fraction.is_empty()
        && !fraction.contains(',')
        && whole.parse::<f32>().is_ok()
        && fraction.parse::<u32>().is_ok()
    {
        let message = format!("`{shown}` has a decimal comma");
        return (
            message,
            Some(format!("write `{whole}.{fraction}`; if these are two numbers, put a space between them")),
        );
    }
    (format!("`{shown}` is not a number"), Some("numbers are separated by spaces, not commas".to_owned()))
}

pub fn parse_float(element: Element, span: Range<usize>, token: &str) -> Result<f32, Fault> {
    token.parse().map_err(|_| {
        let (message, hint) = not_a_number(token);
        Fault { hint, ..element.fault_at(span, message) }
    })
}

/// All numbers of the element's text. `NaN` and `INF` are read as such.
pub fn floats(element: Element) -> Result<Vec<f32>, Fault> {
    let mut values = Vec::new();
    for (base, text) in element.pieces() {
        // Exporters write about 10 bytes for one number.
        values.reserve(text.len() / 10);
        for (span, token) in Tokens::new(base, text) {
            values.push(parse_float(element, span, token)?);
        }
    }
    Ok(values)
}

/// Exactly `N` finite numbers.
pub fn fixed<const N: usize>(element: Element) -> Result<[f32; N], Fault> {
    let values = floats(element)?;
    let count = values.len();
    let Ok(values) = <[f32; N]>::try_from(values) else {
        let plural = if N == 1 { "number" } else { "numbers" };
        return Err(element.fault(format!("<{}> takes {N} {plural}, here are {count}", element.name())));
    };
    match values.iter().position(|value| !value.is_finite()) {
        Some(n) => Err(element.fault_at(token_span(element, n), "not a finite number")),
        None => Ok(values),
    }
}

/// One finite number.
pub fn single(element: Element) -> Result<f32, Fault> {
    fixed::<1>(element).map(|[value]| value)
}

/// Appends all indices of the element's text.
pub fn indices(element: Element, out: &mut Vec<u32>) -> Result<(), Fault> {
    for (base, text) in element.pieces() {
        // Indices of large meshes take about 6 bytes each.
        out.reserve(text.len() / 6);
        let bytes = text.as_bytes();
        let mut position = 0;
        while position < bytes.len() {
            if bytes[position] <= b' ' {
                position += 1;
                continue;
            }
            let start = position;
            let mut value = 0u64;
            while position < bytes.len() && bytes[position].is_ascii_digit() && value <= u64::from(u32::MAX) {
                value = value * 10 + u64::from(bytes[position] - b'0');
                position += 1;
            }
            let ended = position > start && bytes.get(position).is_none_or(|&byte| byte <= b' ');
            match u32::try_from(value) {
                Ok(value) if ended => out.push(value),
                _ => return Err(bad_index(element, base + start, &text[start..])),
            }
        }
    }
    Ok(())
}

fn bad_index(element: Element, offset: usize, rest: &str) -> Fault {
    let token = rest.split(|c: char| c.is_ascii_whitespace()).next().unwrap_or_default();
    let shown: String = token.chars().take(24).collect();
    element.fault_at(offset..offset + token.len(), format!("`{shown}` is not an index (0, 1, 2, ...)"))
}
