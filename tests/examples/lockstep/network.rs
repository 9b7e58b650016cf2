//! A network as it is far from home: UDP on this machine, which delays, reorders and loses datagrams.
//!
//! Losses and delays come from a generator with a seed. Delays are counted in looks at the socket, not in time.

use ggrs::{Message, NonBlockingSocket};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

/// How bad it is.
#[derive(Clone, Copy, Debug)]
pub struct Weather {
    /// Datagrams of 1,000 that are lost.
    pub lost: u64,
    /// Looks at the socket after which a datagram is seen: from the first to the second number.
    pub delay: (u64, u64),
    /// Where losses and delays come from.
    pub seed: u64,
}

/// A socket that sees only what gets through.
pub struct Network {
    socket: UdpSocket,
    weather: Weather,
    /// State of the generator.
    random: u64,
    looks: u64,
    /// On their way: the look at which they are seen, and the datagram.
    underway: Vec<(u64, SocketAddr, Message)>,
    buffer: [u8; 4096],
}

impl Network {
    /// On a free port of this machine.
    pub fn new(weather: Weather) -> io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, weather, random: weather.seed, looks: 0, underway: Vec::new(), buffer: [0; 4096] })
    }

    /// Where others reach it.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    /// Below `bound` (SplitMix64).
    fn below(&mut self, bound: u64) -> u64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.random ^ (self.random >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % bound
    }
}

impl NonBlockingSocket<SocketAddr> for Network {
    fn send_to(&mut self, message: &Message, address: &SocketAddr) {
        let config = bincode::config::standard();
        let bytes = bincode::serde::encode_to_vec(message, config).expect("a message is plain");
        // What the system does not take is lost, as it may be on the way.
        let _ = self.socket.send_to(&bytes, address);
    }

    fn receive_all_messages(&mut self) -> Vec<(SocketAddr, Message)> {
        self.looks += 1;
        // Any error means that there is nothing to read now.
        while let Ok((length, from)) = self.socket.recv_from(&mut self.buffer) {
            let config = bincode::config::standard();
            let decoded = bincode::serde::decode_from_slice(&self.buffer[..length], config);
            let is_lost = self.below(1000) < self.weather.lost;
            let (least, most) = self.weather.delay;
            let seen = self.looks + least + self.below(most - least + 1);
            if let (Ok((message, _)), false) = (decoded, is_lost) {
                self.underway.push((seen, from, message));
            }
        }
        let looks = self.looks;
        self.underway
            .extract_if(.., |(seen, ..)| *seen <= looks)
            .map(|(_, from, message)| (from, message))
            .collect()
    }
}
