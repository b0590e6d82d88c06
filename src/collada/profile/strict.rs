//! Reads the attributes of one element of our profile and, at the end, refuses whatever was not asked for.

use glam::Vec3;

use crate::collada::error::Fault;
use crate::collada::numbers::{Tokens, not_a_number};
use crate::collada::xml::Element;
use crate::color::view;

pub struct Strict<'a> {
    pub element: Element<'a>,
    /// Attribute names that were asked for.
    known: Vec<&'static str>,
}

/// What a number may be.
#[derive(Clone, Copy)]
pub enum Bounds {
    Within(f32, f32),
    AtLeast(f32),
    Positive,
    Any,
}

impl Bounds {
    /// Says what is wrong, and the nearest value that is right.
    fn check(self, value: f32) -> Result<(), (String, Option<String>)> {
        let nearest = |low: f32, high: f32| Some(format!("the nearest valid value is {}", value.clamp(low, high)));
        match self {
            _ if !value.is_finite() => Err(("it must be finite".to_owned(), None)),
            Self::Within(low, high) if value < low || value > high => {
                Err((format!("it must lie in {low}..{high}"), nearest(low, high)))
            }
            Self::AtLeast(low) if value < low => {
                Err((format!("it must be at least {low}"), nearest(low, value.max(low))))
            }
            Self::Positive if value <= 0.0 => Err(("it must be greater than 0".to_owned(), None)),
            _ => Ok(()),
        }
    }

    /// What is wrong with the value.
    pub fn accept(self, value: f32) -> Result<(), String> {
        self.check(value).map_err(|(message, _)| message)
    }
}

impl<'a> Strict<'a> {
    pub fn new(element: Element<'a>) -> Self {
        Self { element, known: Vec::new() }
    }

    pub fn text(&mut self, name: &'static str) -> Option<&'a str> {
        self.known.push(name);
        self.element.attribute(name)
    }

    /// An attribute that must be there.
    pub fn required<T>(&self, name: &str, value: Option<T>) -> Result<T, Fault> {
        value.ok_or_else(|| self.element.fault(format!("<{}> has no `{name}`", self.element.name())))
    }

    pub fn numbers(&mut self, name: &'static str, bounds: Bounds) -> Result<Option<Vec<f32>>, Fault> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let mut values = Vec::new();
        for (_, token) in Tokens::new(0, text) {
            let value = token.parse::<f32>().map_err(|_| {
                let (message, hint) = not_a_number(token);
                Fault { hint, ..self.element.fault_at_value(name, format!("`{name}`: {message}")) }
            })?;
            bounds.check(value).map_err(|(message, hint)| Fault {
                hint,
                ..self.element.fault_at_value(name, format!("`{name}` is {token}; {message}"))
            })?;
            values.push(value);
        }
        Ok(Some(values))
    }

    pub fn number(&mut self, name: &'static str, bounds: Bounds) -> Result<Option<f32>, Fault> {
        match self.numbers(name, bounds)?.as_deref() {
            None => Ok(None),
            Some(&[value]) => Ok(Some(value)),
            Some(values) => {
                let message = format!("`{name}` takes 1 number, here are {}", values.len());
                Err(self.element.fault_at_value(name, message))
            }
        }
    }

    /// Three numbers, or one for all three. A `colorspace` attribute beside it says how they are encoded.
    pub fn rgb(&mut self, name: &'static str, bounds: Bounds) -> Result<Option<Vec3>, Fault> {
        let is_srgb = self.choice("colorspace", &[("linear", false), ("srgb", true)])?.unwrap_or(false);
        let value = match self.numbers(name, bounds)?.as_deref() {
            None => return Ok(None),
            Some(&[grey]) => Vec3::splat(grey),
            Some(&[r, g, b]) => Vec3::new(r, g, b),
            Some(values) => {
                let message = format!("`{name}` takes 3 numbers (red, green, blue), here are {}", values.len());
                return Err(self.element.fault_at_value(name, message));
            }
        };
        Ok(Some(if is_srgb { Vec3::from(value.to_array().map(view::srgb_decode)) } else { value }))
    }

    pub fn whole(&mut self, name: &'static str, low: u32, high: u32) -> Result<Option<u32>, Fault> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match text.trim().parse::<u32>() {
            Ok(value) if (low..=high).contains(&value) => Ok(Some(value)),
            _ => {
                let message = format!("`{name}` is {text}; it must be a whole number in {low}..{high}");
                Err(self.element.fault_at_value(name, message))
            }
        }
    }

    /// One of several words.
    pub fn choice<T: Copy>(&mut self, name: &'static str, words: &[(&str, T)]) -> Result<Option<T>, Fault> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match words.iter().find(|(word, _)| *word == text) {
            Some(&(_, value)) => Ok(Some(value)),
            None => {
                let fault = self.element.fault_at_value(name, format!("unknown `{name}`: `{text}`"));
                Err(fault.suggest(text, words.iter().map(|&(word, _)| word)))
            }
        }
    }

    pub fn flag(&mut self, name: &'static str) -> Result<Option<bool>, Fault> {
        self.choice(name, &[("true", true), ("false", false), ("1", true), ("0", false)])
    }

    /// Two attributes of which at most one may be given.
    pub fn not_both(&self, one: &str, other: &str) -> Result<(), Fault> {
        if self.element.attribute(one).is_some() && self.element.attribute(other).is_some() {
            let message = format!("`{one}` and `{other}` exclude each other");
            return Err(self.element.fault_at_name(other, message));
        }
        Ok(())
    }

    /// Refuses attributes that nobody asked for, children other than `children`, and text.
    pub fn finish(self, children: &[&'static str]) -> Result<(), Fault> {
        let element = self.element;
        let unknown = element.attribute_names().find(|name| !self.known.contains(name) && !name.starts_with("xmlns"));
        if let Some(name) = unknown {
            let fault = element.fault_at_name(name, format!("unknown attribute `{name}` of <{}>", element.name()));
            return Err(fault.suggest(name, self.known));
        }
        only_children(element, children)?;
        if !element.text().is_empty() {
            let fault = element.fault_at_text(format!("text inside <{}>", element.name()));
            return Err(fault.hint("values are written as attributes"));
        }
        Ok(())
    }
}

/// Refuses children of other names.
pub fn only_children(element: Element, children: &[&str]) -> Result<(), Fault> {
    match element.children().find(|child| !children.contains(&child.name())) {
        None => Ok(()),
        Some(child) => {
            let fault = child.fault(format!("unknown element <{}> in <{}>", child.name(), element.name()));
            Err(fault.suggest(child.name(), children.iter().copied()))
        }
    }
}

/// The second of several children of which only one may stand here is an error.
pub fn at_most_one<'a>(element: Element<'a>, names: &[&str]) -> Result<Option<Element<'a>>, Fault> {
    let mut found = element.children().filter(|child| names.contains(&child.name()));
    let first = found.next();
    match (first, found.next()) {
        (Some(first), Some(second)) => {
            let message = format!("<{}> after <{}>: only one of them can stand here", second.name(), first.name());
            Err(second.fault(message))
        }
        _ => Ok(first),
    }
}
