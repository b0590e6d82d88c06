//! The values after a PLY header.

use super::error::Fault;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Encoding {
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Self::Ascii),
            "binary_little_endian" => Some(Self::LittleEndian),
            "binary_big_endian" => Some(Self::BigEndian),
            _ => None,
        }
    }

    /// Bytes that a value takes at least.
    pub fn least_bytes(self, scalar: Scalar) -> usize {
        // In text a digit; what parts it from the next is missing at the end of the file.
        if self == Self::Ascii { 1 } else { scalar.bytes() }
    }
}

impl Scalar {
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "char" | "int8" => Some(Self::I8),
            "uchar" | "uint8" => Some(Self::U8),
            "short" | "int16" => Some(Self::I16),
            "ushort" | "uint16" => Some(Self::U16),
            "int" | "int32" => Some(Self::I32),
            "uint" | "uint32" => Some(Self::U32),
            "float" | "float32" => Some(Self::F32),
            "double" | "float64" => Some(Self::F64),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of this many little-endian bytes.
    fn decode(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(i8::from_le_bytes([a])),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// Reads one value after the other.
pub struct Data<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    /// What is left of the current line, in text.
    line: &'a [u8],
    line_number: usize,
    /// What is being read, for messages.
    element: String,
    number: usize,
}

impl<'a> Data<'a> {
    /// `line_number` is that of the first line after the header.
    pub fn new(encoding: Encoding, rest: &'a [u8], line_number: usize) -> Self {
        Self { encoding, rest, line: &[], line_number: line_number - 1, element: String::new(), number: 0 }
    }

    /// Bytes that were not read yet.
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// An error about the element that is being read.
    pub fn fault(&self, message: String) -> Fault {
        match self.encoding {
            Encoding::Ascii => Fault::at(self.line_number, message),
            _ => Fault::new(format!("{} {}: {message}", self.element, self.number)),
        }
    }

    /// Begins the element of this number: in text, the next line that is not blank.
    pub fn begin(&mut self, element: &str, number: usize) -> Result<(), Fault> {
        if self.element != element {
            element.clone_into(&mut self.element);
        }
        self.number = number;
        while self.encoding == Encoding::Ascii {
            if self.rest.is_empty() {
                return Err(self.cut_off());
            }
            let end = self.rest.iter().position(|&byte| byte == b'\n').unwrap_or(self.rest.len());
            self.line = self.rest[..end].trim_ascii();
            self.rest = &self.rest[(end + 1).min(self.rest.len())..];
            self.line_number += 1;
            if !self.line.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Ends the element: in text, nothing may be left of the line.
    pub fn end(&self) -> Result<(), Fault> {
        match self.line {
            [] => Ok(()),
            more => {
                let shown: String = String::from_utf8_lossy(more).chars().take(24).collect();
                Err(self.fault(format!("more values than the header names: `{shown}`")))
            }
        }
    }

    fn cut_off(&self) -> Fault {
        let Self { element, number, .. } = self;
        Fault::new(format!("the file ends in {element} {number}")).hint("it is cut off or damaged")
    }

    /// The next value; f64 holds each of every type.
    pub fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        if self.encoding == Encoding::Ascii {
            return self.next_word();
        }
        let count = scalar.bytes();
        let Some((value, rest)) = self.rest.split_at_checked(count) else { return Err(self.cut_off()) };
        let mut bytes = [0; 8];
        bytes[..count].copy_from_slice(value);
        if self.encoding == Encoding::BigEndian {
            bytes[..count].reverse();
        }
        self.rest = rest;
        Ok(scalar.decode(bytes))
    }

    fn next_word(&mut self) -> Result<f64, Fault> {
        if self.line.is_empty() {
            return Err(self.fault(format!("fewer values than a {} has", self.element)));
        }
        let end = self.line.iter().position(u8::is_ascii_whitespace).unwrap_or(self.line.len());
        let (word, rest) = self.line.split_at(end);
        self.line = rest.trim_ascii_start();
        let text = std::str::from_utf8(word).ok();
        text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            let shown: String = String::from_utf8_lossy(word).chars().take(24).collect();
            self.fault(format!("`{shown}` is not a number"))
        })
    }

    /// The length of a list of `kind`, which the file has room for.
    pub fn length(&mut self, length: Scalar, kind: Scalar) -> Result<usize, Fault> {
        let value = self.next(length)?;
        let left = if self.encoding == Encoding::Ascii { self.line.len() } else { self.rest.len() };
        let room = left / self.encoding.least_bytes(kind);
        if value >= 0.0 && value <= room as f64 && value.fract() == 0.0 {
            return Ok(value as usize);
        }
        let message = format!("a list of {value} values, where there is room for {room}");
        Err(self.fault(message).hint("the file is cut off or damaged"))
    }
}
