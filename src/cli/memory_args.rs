//! How much memory there is, shared by every subcommand that fills it.

use clap::Args;

use crate::render::available_memory;

#[derive(Args, PartialEq)]
pub struct MemoryArgs {
    /// Most memory for the scene, and for the picture, like `8G` or `500M`: what takes more is refused, with its bytes, before
    /// it is made [default: what the machine has left]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    max_memory: Option<u64>,
}

impl MemoryArgs {
    /// In bytes.
    pub fn most(&self) -> u64 {
        self.max_memory.unwrap_or_else(available_memory)
    }
}

/// Bytes, or with the letters k, M, G, T the powers of 1000.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let letters = ["k", "M", "G", "T"];
    let found = letters.iter().zip(1..).find_map(|(letter, power)| Some((text.strip_suffix(letter)?, power)));
    let (digits, power) = found.unwrap_or((text, 0));
    let bytes = digits.parse::<u64>().ok().and_then(|number| number.checked_mul(1000u64.pow(power)));
    bytes.ok_or_else(|| "write it as a whole number of bytes, or like `500M` or `8G`".to_owned())
}
