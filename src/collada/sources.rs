//! `<source>`: an array of numbers and the accessor that cuts it into elements.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{Vec2, Vec3};

use super::error::Fault;
use super::loader::Loader;
use super::numbers;
use super::xml::Element;

/// Float arrays that have been parsed, by element index: several sources may share one.
#[derive(Default)]
pub struct Arrays {
    parsed: HashMap<usize, Rc<Vec<f32>>>,
}

/// How to read element `i` of a source: slot `s` is `values[offset + i * stride + slots[s]]`.
pub struct Accessor<'a> {
    array: Element<'a>,
    values: Rc<Vec<f32>>,
    offset: usize,
    pub stride: usize,
    pub count: usize,
    /// Named parameters; an unnamed one is skipped, as the specification has it.
    slots: Vec<usize>,
}

impl Arrays {
    pub fn accessor<'a>(&mut self, loader: &mut Loader<'a>, source: Element<'a>) -> Result<Accessor<'a>, Fault> {
        let Some(accessor) = source.descend(&["technique_common", "accessor"]) else {
            return Err(source.fault("this <source> has no <technique_common><accessor>"));
        };
        let array = loader.follow(accessor, "source", &["float_array", "int_array"])?;
        let values = self.values(loader, array)?;
        let names: Vec<bool> =
            accessor.children_named("param").map(|param| param.attribute("name").is_some()).collect();
        let stride = whole_number(accessor, "stride")?.unwrap_or(names.len().max(1));
        if stride == 0 {
            return Err(accessor.fault_at_value("stride", "a stride of 0"));
        }
        let mut slots: Vec<usize> = (0..names.len().min(stride)).filter(|&slot| names[slot]).collect();
        if slots.is_empty() {
            slots = (0..stride).collect();
        }
        let offset = whole_number(accessor, "offset")?.unwrap_or(0);
        let available = values.len().saturating_sub(offset) / stride;
        let count = whole_number(accessor, "count")?.unwrap_or(available);
        if count > available {
            let message = format!(
                "the accessor wants {count} elements of {stride}, the array's {} numbers hold {available}",
                values.len()
            );
            return Err(accessor.fault_at_value("count", message));
        }
        Ok(Accessor { array, values, offset, stride, count, slots })
    }

    fn values<'a>(&mut self, loader: &mut Loader<'a>, array: Element<'a>) -> Result<Rc<Vec<f32>>, Fault> {
        if let Some(values) = self.parsed.get(&array.index()) {
            return Ok(Rc::clone(values));
        }
        let values = Rc::new(numbers::floats(array)?);
        check_count(loader, array, values.len(), "numbers")?;
        self.parsed.insert(array.index(), Rc::clone(&values));
        Ok(values)
    }
}

/// Compares a `count` attribute with what is there. It never decides how much is allocated.
pub fn check_count<'a>(loader: &mut Loader<'a>, element: Element<'a>, found: usize, things: &str) -> Result<(), Fault> {
    match whole_number(element, "count")? {
        Some(count) if count != found => {
            let message = format!("count says {count}, here are {found} {things}");
            if !loader.options.lenient {
                return Err(element.fault_at_value("count", message).hint("--lenient takes what is there"));
            }
            loader.warnings.add(element, message, "what is there is taken");
            Ok(())
        }
        _ => Ok(()),
    }
}

/// A non-negative integer attribute.
pub fn whole_number(element: Element, attribute: &str) -> Result<Option<usize>, Fault> {
    let Some(text) = element.attribute(attribute) else { return Ok(None) };
    match text.trim().parse::<u32>() {
        Ok(number) => Ok(Some(number as usize)),
        Err(_) => Err(element.fault_at_value(attribute, format!("`{text}` is not a whole number"))),
    }
}

impl Accessor<'_> {
    fn position(&self, index: usize, slot: usize) -> usize {
        self.offset + index * self.stride + slot
    }

    fn at(&self, index: usize, component: usize) -> f32 {
        self.slots.get(component).map_or(0.0, |&slot| self.values[self.position(index, slot)])
    }

    fn require(&self, components: usize) -> Result<(), Fault> {
        if self.slots.len() < components {
            let message =
                format!("{components} numbers per element are needed, the accessor names {}", self.slots.len());
            return Err(self.array.fault(message));
        }
        Ok(())
    }

    /// Finite points.
    pub fn points(&self) -> Result<Vec<Vec3>, Fault> {
        let points = self.vectors()?;
        match points.iter().position(|point| !point.is_finite()) {
            None => Ok(points),
            Some(index) => {
                let component = (0..3).find(|&component| !self.at(index, component).is_finite()).unwrap_or(0);
                let token = self.position(index, self.slots[component]);
                let message = format!("position {index} is not finite");
                Err(self.array.fault_at(numbers::token_span(self.array, token), message))
            }
        }
    }

    pub fn vectors(&self) -> Result<Vec<Vec3>, Fault> {
        self.require(3)?;
        Ok((0..self.count).map(|i| Vec3::new(self.at(i, 0), self.at(i, 1), self.at(i, 2))).collect())
    }

    /// Texture coordinates; a one-dimensional set has t = 0, a third coordinate is not used.
    pub fn pairs(&self) -> Result<Vec<Vec2>, Fault> {
        self.require(1)?;
        Ok((0..self.count).map(|i| Vec2::new(self.at(i, 0), self.at(i, 1))).collect())
    }

    /// `count` rows of `stride` numbers, whatever the parameters are called.
    pub fn rows(&self) -> &[f32] {
        &self.values[self.offset..self.offset + self.count * self.stride]
    }
}
