// SPDX-License-Identifier: Apache-2.0
//! Renders offsets as text: `lfz plan --stp`.

use core::fmt::{self, Display, Formatter};

use super::{Connection, Deadline, FederateOffset, Offsets, QueueOverflow, ShortWait};
use crate::plan::Time;

impl Display for Offsets {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "smallest safe offsets of {}", self.program)?;
        for federate in &self.federates {
            self.federate(federate, f)?;
        }
        for cycle in &self.cycles {
            self.cycle(cycle, f)?;
        }
        for wait in &self.short_waits {
            self.short_wait(wait, f)?;
        }
        for overflow in &self.overflows {
            self.overflow(overflow, f)?;
        }
        for deadline in &self.deadlines {
            write_deadline(deadline, f)?;
        }
        Ok(())
    }
}

impl Offsets {
    fn federate(&self, federate: &FederateOffset, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(offset_ns) = federate.offset_ns else {
            return writeln!(f, "  {}: none, because of a cycle", federate.name);
        };
        writeln!(f, "  {}: @maxwait({})", federate.name, Time(offset_ns))?;
        let mut from_ns = 0_i64;
        for connection in &federate.path {
            let connection = &self.connections[*connection];
            write!(f, "    {}: ", connection.name)?;
            if from_ns > 0 {
                write!(f, "{} + ", Time(from_ns))?;
            }
            from_ns = from_ns.saturating_add(connection.demand_ns());
            writeln!(f, "{} = {}", Parts(connection), Time(from_ns))?;
        }
        Ok(())
    }

    fn cycle(&self, cycle: &[usize], f: &mut Formatter<'_>) -> fmt::Result {
        let sum = cycle.iter().fold(0_i64, |sum, at| sum.saturating_add(self.connections[*at].demand_ns()));
        writeln!(
            f,
            "cycle: no offset is long enough, because each round needs {} more than the one before",
            Time(sum)
        )?;
        for connection in cycle {
            let connection = &self.connections[*connection];
            let demand_ns = connection.demand_ns();
            let sign = if demand_ns < 0 { "-" } else { "" };
            let amount = Time(demand_ns.saturating_abs());
            writeln!(f, "    {}: {} = {sign}{amount}", connection.name, Parts(connection))?;
        }
        writeln!(f, "  hint: delay its connections by {} more (`after`) in all", Time(sum))
    }

    fn overflow(&self, overflow: &QueueOverflow, f: &mut Formatter<'_>) -> fmt::Result {
        let QueueOverflow { connection, wait_ns, messages, capacity } = overflow;
        writeln!(
            f,
            "warning: `{}` can bring {messages} messages during a wait of {}, and its queue holds {capacity}: its \
             sender may be held up, and later than worked out here; write `@capacity({messages})` before it",
            self.connections[*connection].name,
            Time(*wait_ns)
        )
    }

    fn short_wait(&self, wait: &ShortWait, f: &mut Formatter<'_>) -> fmt::Result {
        let Connection { name, .. } = &self.connections[wait.connection];
        let max_wait = Time(wait.max_wait_ns);
        match wait.needed_ns {
            Some(needed) => {
                write!(
                    f,
                    "warning: `{name}` waits {max_wait}, and messages can come up to {} after their tag",
                    Time(needed)
                )?;
            }
            None => {
                write!(f, "warning: `{name}` waits {max_wait}, and nothing bounds how late messages can come")?;
            }
        }
        if wait.absent_after_helps() {
            let sum = wait.max_wait_ns.saturating_add(wait.absent_after_ns);
            write!(
                f,
                "; at their own tag they are waited for until {}, but no longer once a later tag has begun",
                Time(sum)
            )?;
        }
        writeln!(f)
    }
}

fn write_deadline(deadline: &Deadline, f: &mut Formatter<'_>) -> fmt::Result {
    let Deadline { reaction, deadline_ns, launch_lag_ns, before_ns } = deadline;
    let deadline_text = Time(*deadline_ns);
    match launch_lag_ns {
        _ if !deadline.is_met() => {
            write!(f, "warning: the deadline {deadline_text} of {reaction} can be missed: ")?;
            match launch_lag_ns {
                None => writeln!(f, "there is no safe offset"),
                Some(lag) if *lag < 0 => {
                    writeln!(f, "the offset alone is {} longer", Time(lag.saturating_neg()))
                }
                Some(lag) => writeln!(
                    f,
                    "the offset leaves {}, and what runs before takes up to {}",
                    Time(*lag),
                    Time(*before_ns)
                ),
            }
        }
        Some(lag) => writeln!(
            f,
            "deadline {deadline_text} of {reaction}: the offset leaves {}, and what runs before takes up to {}",
            Time(*lag),
            Time(*before_ns)
        ),
        None => Ok(()),
    }
}

/// The terms of a connection's demand.
struct Parts<'a>(&'a Connection);

impl Display for Parts<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Connection { lag_ns, latency_ns, clock_error_ns, delay_ns, .. } = self.0;
        let (lag, latency, clock_error) = (Time(*lag_ns), Time(*latency_ns), Time(*clock_error_ns));
        write!(f, "lag {lag} + latency {latency} + clock error {clock_error}")?;
        if *delay_ns > 0 { write!(f, " - after {}", Time(*delay_ns)) } else { Ok(()) }
    }
}
