// SPDX-License-Identifier: Apache-2.0
//! Lines of GPIO chips, by the kernel's character devices.

use std::io;
use std::sync::{Arc, OnceLock};

use gpiocdev::line::{Bias, EdgeDetection, EdgeEvent, EdgeKind, Value};
use gpiocdev::request::{Builder, Request};
use lf_devices::{Device, Edge, EventPoster, Pin, Problem};
use lf_model::PhysicalLink;

use super::super::binding::{Bound, Kind, Pull};
use super::super::recording::Signal;
use super::super::simulation::Simulation;
use super::super::watch::{Lost, Watch};
use super::listener::Listener;
use super::{Advice, DeviceRef, failed};
use crate::outside::{HostOutside, HostOutsideAt};

const ADVICE: Advice = Advice {
    missing: "which is not there: `gpiodetect` lists the chips",
    denied: "which this user may not open: as a rule members of the group gpio may",
    busy: "whose line is in use: `gpioinfo` says by which program or driver",
    other: "but the program uses it as a pin: write gpio, its chip and the number of its line",
};
const NO_CHIP: &str = "which is no GPIO chip: `gpiodetect` lists those that are";
const NO_LINE: &str = "which has no such line, or whose driver cannot do this with it: `gpioinfo` lists the lines";

/// The number of edges that the kernel keeps until the thread takes them, instead of 16: those of a contact that
/// bounces.
const EDGES: u32 = 256;

/// A pin.
#[derive(Debug)]
pub struct Gpio {
    place: DeviceRef,
    line: u32,
    is_active_low: bool,
    pull: Option<Pull>,
    request: OnceLock<Arc<Request>>,
}

impl Gpio {
    /// Returns the pin of a line of the script; the next call sets its direction.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &ADVICE);
        let Kind::Gpio { line, is_active_low, pull } = bound.binding.kind else { return Err(place.is_other()) };
        Ok(Self { place, line, is_active_low, pull, request: OnceLock::new() })
    }

    fn configure(&self, direction: impl FnOnce(&mut Builder)) -> Result<(), Problem> {
        let mut builder = Request::builder();
        builder.on_chip(self.place.path).with_consumer("lf").with_kernel_event_buffer_size(EDGES).with_line(self.line);
        if self.is_active_low {
            builder.as_active_low();
        }
        direction(&mut builder);
        let request = builder.request().map_err(|error| self.refuses(error))?;
        self.request.set(Arc::new(request)).map_err(|_| Problem::NotSupported)
    }

    fn refuses(&self, error: gpiocdev::Error) -> Problem {
        if let gpiocdev::Error::GpioChip(..) = error {
            return self.place.problem(NO_CHIP, 0);
        }
        match system_error(error) {
            error if error.kind() == io::ErrorKind::InvalidInput => self.place.problem(NO_LINE, super::number(&error)),
            error => self.place.refuses(&error),
        }
    }

    /// Returns the kernel's request, which exists once the pin is an input or an output. The program sets that first.
    fn request(&self) -> Result<&Arc<Request>, Problem> {
        self.request.get().ok_or(Problem::NotReady)
    }
}

impl Device for Gpio {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl Pin for Gpio {
    type Watch = Watch;

    fn is_active_low(&self) -> bool {
        self.is_active_low
    }

    fn configure_output(&self, active: bool) -> Result<(), Problem> {
        self.configure(|builder| {
            builder.as_output(active.into());
        })?;
        Simulation::of_program().drives(self.place.name, Signal::Level(active));
        Ok(())
    }

    fn configure_input(&self) -> Result<(), Problem> {
        self.configure(|builder| {
            builder.as_input().with_bias(self.pull.map(|pull| match pull {
                Pull::Up => Bias::PullUp,
                Pull::Down => Bias::PullDown,
                Pull::None => Bias::Disabled,
            }));
        })?;
        Simulation::of_program().drives(self.place.name, Signal::Level(self.is_active()?));
        Ok(())
    }

    fn set(&self, active: bool) -> Result<(), Problem> {
        self.request()?.set_value(self.line, active.into()).map_err(|error| failed(&system_error(error)))?;
        Simulation::of_program().drives(self.place.name, Signal::Level(active));
        Ok(())
    }

    fn is_active(&self) -> Result<bool, Problem> {
        let value = self.request()?.value(self.line).map_err(|error| failed(&system_error(error)))?;
        Ok(value == Value::Active)
    }

    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        let request = self.request()?;
        // These are edges that an earlier watch has not taken.
        while request.has_edge_event().map_err(|error| failed(&system_error(error)))? {
            request.read_edge_event().map_err(|error| failed(&system_error(error)))?;
        }
        let edges = match edge {
            Edge::ToActive => EdgeDetection::RisingEdge,
            Edge::ToInactive => EdgeDetection::FallingEdge,
            Edge::Both => EdgeDetection::BothEdges,
        };
        detect(request, self.line, Some(edges)).map_err(|error| self.place.refuses(&system_error(error)))?;
        let (name, mut sequence) = (self.place.name, Sequence::default());
        let listener = Listener::spawn(name, Arc::clone(request), link, move |request, lost| {
            let event = request.read_edge_event().map_err(system_error)?;
            if let missed @ 1.. = sequence.missed_before(event.line_seqno) {
                log::warn!("edges of {name} that came faster than they could be taken: {missed}");
            }
            take(name, &event, &poster, lost);
            Ok(())
        });
        let listener = listener.map_err(|error| failed(&error))?;
        Ok(Watch::until_dropped(Edges { listener: Some(listener), request: Arc::clone(request), line: self.line }))
    }
}

/// Posts an edge at the time of its interrupt.
fn take(name: &'static str, event: &EdgeEvent, poster: &EventPoster, lost: &mut Lost) {
    let monotonic = i64::try_from(event.timestamp_ns).unwrap_or(i64::MAX);
    let host = HostOutside::of_program();
    let is_active = event.kind == EdgeKind::Rising;
    Simulation::of_program().sees(name, host.clock().at(monotonic), Signal::Level(is_active));
    lost.count(poster.post_by(&HostOutsideAt(host, monotonic), is_active.into()));
}

/// The kernel's sequence numbers of the edges of a line, with a gap where it had no room.
#[derive(Debug, Default)]
struct Sequence {
    last: Option<u32>,
}

impl Sequence {
    /// Returns how many are missing between the last one and this one.
    fn missed_before(&mut self, number: u32) -> u32 {
        let last = self.last.replace(number);
        last.map_or(0, |last| number.wrapping_sub(last).saturating_sub(1))
    }
}

/// The edges of a line, until this is dropped.
#[derive(Debug)]
struct Edges {
    listener: Option<Listener>,
    request: Arc<Request>,
    line: u32,
}

impl Drop for Edges {
    fn drop(&mut self) {
        self.listener = None;
        if let Err(error) = detect(&self.request, self.line, None) {
            log::debug!("edges of line {} are still detected: {error}", self.line);
        }
    }
}

fn detect(request: &Request, line: u32, edges: Option<EdgeDetection>) -> gpiocdev::Result<()> {
    let mut config = request.config();
    config.with_line(line).with_edge_detection(edges);
    request.reconfigure(&config)
}

fn system_error(error: gpiocdev::Error) -> io::Error {
    use gpiocdev::Error::{Os, Uapi};
    match error {
        Os(number) | Uapi(_, gpiocdev_uapi::Error::Os(number)) => io::Error::from_raw_os_error(number.0),
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_that_the_kernel_had_no_room_for_are_counted() {
        let mut sequence = Sequence::default();
        let missed: Vec<_> = [7, 8, 11, 11, u32::MAX, 1].map(|number| sequence.missed_before(number)).into();
        assert_eq!(missed[..4], [0, 0, 2, 0]);
        assert_eq!(missed[5], 1);
    }
}
