// SPDX-License-Identifier: Apache-2.0
//! The baseline of messages between two federates: the same number of bytes, at the same rate, over a raw TCP
//! connection between two processes.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::process::start_self;
use crate::{Result, Samples};

/// Bytes of a tagged message with a value of 8 bytes.
const MESSAGE_BYTES: usize = 29;
const STAMP_BYTES: usize = 8;

/// Returns the latencies of `count` messages, one in each period, from one process to another.
///
/// # Errors
/// When there is no second process or no connection.
pub fn ping(count: u32, period: Duration) -> Result<Samples> {
    let (_child, port, lines) = start_self("answer")?;
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
    stream.set_nodelay(true)?;
    let mut next = Instant::now();
    for _ in 0..count {
        next += period;
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
        let mut message = [0; MESSAGE_BYTES];
        message[..STAMP_BYTES].copy_from_slice(&now()?.to_le_bytes());
        stream.write_all(&message)?;
    }
    drop(stream);
    let mut samples = Samples::default();
    for line in lines {
        samples.push(Duration::from_nanos(line?.parse()?));
    }
    Ok(samples)
}

/// Acts as the other process: prints the port and, when the connection ends, the latency of each message in
/// nanoseconds.
///
/// # Errors
/// When the system has no socket, or the connection breaks.
pub fn answer_pings(mut print: impl FnMut(u64)) -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    print(listener.local_addr()?.port().into());
    let (mut stream, _) = listener.accept()?;
    let mut times = Vec::new();
    let mut message = [0; MESSAGE_BYTES];
    while stream.read_exact(&mut message).is_ok() {
        let mut stamp = [0; STAMP_BYTES];
        stamp.copy_from_slice(&message[..STAMP_BYTES]);
        times.push(now()?.saturating_sub(u64::from_le_bytes(stamp)));
    }
    times.into_iter().for_each(print);
    Ok(())
}

/// Returns the time of the clock that both processes share, in nanoseconds.
fn now() -> Result<u64> {
    Ok(u64::try_from(SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos())?)
}
