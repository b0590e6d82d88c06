//! A picture in a viewer that is already open: the network protocol of tev (<https://github.com/Tom94/tev>).
//!
//! A packet is its own length in bytes (u32, itself included), a kind (u8), and what that kind holds: all numbers
//! little-endian, text ended by a zero byte. Nothing comes back.
//!
//! | kind | what follows |
//! |---|---|
//! | 4, create | grab focus (u8), name, width, height, channel count (i32 each), channel names |
//! | 6, update | grab focus (u8), name, channel count (i32), channel names, x, y, width, height (i32 each), per channel the offset of its first value (i64), per channel the step to its next (i64), values (f32) |

use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::error::OutputError;

/// Where tev listens unless told otherwise.
const PORT: u16 = 14158;
/// A viewer that takes nothing for so long counts as gone.
const PATIENCE: Duration = Duration::from_secs(5);
const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// Largest side of what one packet updates.
const SIDE: u32 = 256;

/// A picture in a viewer.
pub struct Viewer {
    stream: TcpStream,
    name: String,
    size: [u32; 2],
}

impl Viewer {
    /// Opens a black picture of this name and size in the viewer at `HOST`, `HOST:PORT` or `[IPv6]:PORT`.
    ///
    /// # Errors
    /// Nobody listens there.
    pub fn open(address: &str, name: &str, size: [u32; 2]) -> Result<Self, OutputError> {
        let named = if address.parse::<std::net::Ipv6Addr>().is_ok() {
            format!("[{address}]:{PORT}")
        } else if address.contains(':') {
            address.to_owned()
        } else {
            format!("{address}:{PORT}")
        };
        let lost = |source| OutputError::Viewer { address: named.clone(), source };
        let mut last = std::io::ErrorKind::AddrNotAvailable.into();
        let mut streams = named
            .to_socket_addrs()
            .map_err(lost)?
            .filter_map(|place| TcpStream::connect_timeout(&place, PATIENCE).map_err(|error| last = error).ok());
        let found = streams.next();
        drop(streams);
        let Some(stream) = found else { return Err(lost(last)) };
        let mut viewer = Self { stream, name: name.to_owned(), size };
        viewer.create().map_err(lost)?;
        Ok(viewer)
    }

    fn create(&mut self) -> std::io::Result<()> {
        self.stream.set_nodelay(true)?;
        self.stream.set_write_timeout(Some(PATIENCE))?;
        let mut packet = Packet::new(4, true, &self.name);
        packet.numbers(&[self.size[0], self.size[1], CHANNELS.len() as u32]);
        CHANNELS.iter().for_each(|channel| packet.text(channel));
        packet.send(&mut self.stream)
    }

    /// Shows the picture as it is now: row by row from the upper left, linear sRGB.
    ///
    /// # Errors
    /// The viewer is gone, or takes nothing any more.
    pub fn update(&mut self, rgb: &[[f32; 3]]) -> std::io::Result<()> {
        let [width, height] = self.size;
        for y in (0..height).step_by(SIDE as usize) {
            for x in (0..width).step_by(SIDE as usize) {
                let [columns, rows] = [SIDE.min(width - x), SIDE.min(height - y)];
                let mut packet = Packet::new(6, false, &self.name);
                packet.numbers(&[CHANNELS.len() as u32]);
                CHANNELS.iter().for_each(|channel| packet.text(channel));
                packet.numbers(&[x, y, columns, rows]);
                // The three channels of a pixel lie side by side.
                let offsets = 0..CHANNELS.len() as i64;
                let steps = CHANNELS.map(|_| CHANNELS.len() as i64);
                offsets.chain(steps).for_each(|value| packet.0.extend(value.to_le_bytes()));
                for row in rgb.chunks(width as usize).skip(y as usize).take(rows as usize) {
                    let pixels = row.iter().skip(x as usize).take(columns as usize);
                    packet.0.extend(pixels.flatten().flat_map(|value| value.to_le_bytes()));
                }
                packet.send(&mut self.stream)?;
            }
        }
        Ok(())
    }
}

/// Bytes on their way, with room for their number.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, grab_focus: bool, name: &str) -> Self {
        let mut packet = Self(vec![0, 0, 0, 0, kind, u8::from(grab_focus)]);
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    fn numbers(&mut self, numbers: &[u32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn send(mut self, stream: &mut TcpStream) -> std::io::Result<()> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        stream.write_all(&self.0)
    }
}
