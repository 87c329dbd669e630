// SPDX-License-Identifier: Apache-2.0
//! The variation of an RTI's answers in the exchanges of clock synchronization before the start, when all federates
//! join at the same time.
//!
//! A stock federate discards its exchanges, and begins with the whole offset of its clock, if the standard deviation of
//! their round trips is 100 µs or more. One of ten exchanges that takes a third of a millisecond longer suffices for
//! that.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Barrier;
use std::time::{Duration, Instant};

use lf_wire::{Decoded, Limits, Message, NeighborStructure, UDP_PORT_CLOCK_SYNC_INITIAL, decode};

use crate::link::connect;
use crate::{FEDERATION, Program, Result, Samples};

/// LF's default, which both sides know.
const TRIALS: u32 = 10;
/// Bytes of T1 and T4.
const TIME_BYTES: usize = 9;
/// The longest time that an RTI may be silent.
const SILENCE_MAX: Duration = Duration::from_secs(10);
/// The measurements of all federates.
#[derive(Clone, Debug, Default)]
pub struct InitialExchanges {
    /// The standard deviation of each federate's round trips, (T4 - T1) - (T3 - T2).
    pub spreads: Samples,
    /// The time from each T3 to its T4.
    pub answers: Samples,
}

impl InitialExchanges {
    /// Lets this number of federates join a new RTI at the same time, and returns their measurements.
    ///
    /// # Errors
    /// When the RTI cannot be started, or does not answer as it should.
    pub fn run(program: &Program, federates: u16) -> Result<Self> {
        let rti = program.start_with(federates, &["init", "exchanges-per-interval", &TRIALS.to_string()])?;
        let streams: Result<Vec<_>> = (0..federates).map(|_| connect(rti.port)).collect();
        let barrier = Barrier::new(federates.into());
        let seen: Vec<_> = std::thread::scope(|scope| {
            let join = |(id, stream)| {
                let barrier = &barrier;
                scope.spawn(move || {
                    barrier.wait();
                    join(stream, id).map_err(|error| format!("federate {id}: {error}"))
                })
            };
            let threads: Vec<_> = (0..federates).zip(streams?).map(join).collect();
            Ok::<_, crate::Error>(threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect())
        })?;
        let mut all = Self::default();
        for seen in seen {
            let (spread, answers, _) = seen.map_err(|_| "a federate has panicked")??;
            all.spreads.push(spread);
            for answer in answers {
                all.answers.push(answer);
            }
        }
        Ok(all)
    }
}

/// Performs the handshake and the exchanges. Returns the spread of the round trips, the latencies of the answers, and
/// the connection, which stays open because the other federates need it.
fn join(mut stream: TcpStream, id: u16) -> Result<(Duration, Vec<Duration>, TcpStream)> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(SILENCE_MAX))?;
    say(&mut stream, &Message::FedIds { federate: id, federation_id: FEDERATION.as_bytes() })?;
    let mut ack = [0];
    stream.read_exact(&mut ack)?;
    say(&mut stream, &Message::NeighborStructure(NeighborStructure::new(&[], &[])))?;
    say(&mut stream, &Message::UdpPort(UDP_PORT_CLOCK_SYNC_INITIAL))?;
    let (mut round_trips, mut answers) = (Vec::new(), Vec::new());
    for _ in 0..TRIALS {
        let t1 = hear(&mut stream)?;
        let t2 = Instant::now();
        say(&mut stream, &Message::T3 { federate: id })?;
        let t3 = Instant::now();
        let t4 = hear(&mut stream)?;
        answers.push(t3.elapsed());
        round_trips.push(t4 - t1 - i64::try_from((t3 - t2).as_nanos())?);
    }
    Ok((spread(&round_trips), answers, stream))
}

fn say(stream: &mut TcpStream, message: &Message<'_>) -> Result<()> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode(&mut bytes)?;
    Ok(stream.write_all(&bytes)?)
}

/// Reads the time in the RTI's next message.
fn hear(stream: &mut TcpStream) -> Result<i64> {
    let mut bytes = [0; TIME_BYTES];
    stream.read_exact(&mut bytes)?;
    match decode(&bytes, &Limits::NONE) {
        Ok(Decoded::Complete { message: Message::T1(time) | Message::T4(time), .. }) => Ok(time),
        other => Err(format!("the RTI does not synchronize clocks, but says {other:?}").into()),
    }
}

/// Returns the standard deviation of these times in ns.
#[expect(clippy::cast_precision_loss, reason = "round trips are far below 2^53 ns")]
fn spread(times: &[i64]) -> Duration {
    let count = times.len().max(1) as f64;
    let mean = times.iter().map(|time| *time as f64).sum::<f64>() / count;
    let variance = times.iter().map(|time| (*time as f64 - mean).powi(2)).sum::<f64>() / count;
    Duration::from_secs_f64(variance.sqrt() / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_round_trip_of_ten_spreads_them_by_three_tenths_of_what_it_takes_more() {
        let mut times = [50_000; 10];
        times[7] += 400_000;
        assert_eq!(spread(&times), Duration::from_micros(120));
    }
}
