// SPDX-License-Identifier: Apache-2.0
//! The location of the RTI: a program of this computer, an image of its own, or the image of a federate.

use core::net::IpAddr;

use serde_saphyr::{Location, Spanned};

use super::check::{DeploymentChecker, RTI};
use super::raw::{RawDeployment, RawPlace, RawRti};
use super::{Deployment, RtiHome, RtiPlace};
use crate::plan::Plan;

/// A federate of the file.
type Listed<'r> = (&'r String, &'r Option<Spanned<RawPlace>>);

impl DeploymentChecker<'_> {
    /// Reads the keys under `rti`.
    pub(super) fn rti(&mut self, raw: &RawRti) -> RtiPlace {
        let port = raw.port.as_ref().and_then(|port| {
            let number = port.value.parse::<u16>().ok().filter(|number| *number != 0);
            if number.is_none() {
                let message = format!("`port`: \"{}\" is no TCP port", port.value);
                self.error(port.referenced, message, Some("write a number from 1 to 65535"));
            }
            number
        });
        if let Some(platform) = raw.platform.as_ref().filter(|platform| platform.value != "host") {
            let place = self.place(RTI, &raw.place(platform.clone())).unwrap_or_default();
            return RtiPlace { ip: place.address(), home: RtiHome::Image(Box::new(place)), port };
        }
        self.refuse_keys(
            &raw.keys()[1..],
            "host",
            "the RTI is a program of this computer where no other platform is given",
        );
        RtiPlace { home: RtiHome::Program, ip: self.address(raw.ip.as_ref(), "ip"), port }
    }

    /// Finds the federate whose image contains the RTI, if there is one: the federate or the program demands it.
    pub(super) fn joint(
        &mut self,
        raw: &RawDeployment,
        federates: &[Listed<'_>],
        plan: &Plan,
        deployment: &mut Deployment,
    ) {
        let rti_platform = raw.rti.as_ref().and_then(|rti| rti.platform.as_ref());
        let mut home: Option<&String> = None;
        for (name, listed) in federates {
            let Some((raw, key)) = listed.as_ref().and_then(|raw| Some((raw, raw.value.joint_rti.as_ref()?))) else {
                continue;
            };
            if !key.value {
                continue;
            }
            if raw.value.platform.value == "host" {
                let hint = "leave it out: `lfz rti` runs beside the programs of this computer";
                self.error(key.referenced, "`joint-rti` has no meaning for platform host", Some(hint));
            } else if !plan.is_federated() {
                let message = format!("`joint-rti`: {} is not federated, so it has no RTI", plan.name);
                self.error(key.referenced, message, Some("remove it"));
            } else if let Some(platform) = rti_platform {
                let message =
                    format!("`joint-rti`: the RTI cannot be part of \"{name}\", as `rti` has a platform of its own");
                let hint = format!("remove `platform: {}` from `rti`, or `joint-rti` here", platform.value);
                self.error(key.referenced, message, Some(&hint));
            } else if let Some(other) = home {
                let message = format!("`joint-rti`: the RTI is already part of \"{other}\"");
                self.error(key.referenced, message, Some("keep one of the two"));
            } else {
                home = Some(name);
            }
        }
        let home = home.cloned();
        let wanted = plan.is_federated() && plan.target.joint_rti && rti_platform.is_none();
        let home = if home.is_none() && wanted { self.joint_of_program(plan, deployment) } else { home };
        let said = raw.rti.as_ref().and_then(|rti| rti.ip.as_ref());
        if let Some(name) = home {
            self.join(name, said, deployment);
        } else if let (RtiHome::Program, Some(ip), Some(said)) = (&deployment.rti.home, deployment.rti.ip, said)
            && !ip.is_loopback()
        {
            self.once("IP address", ip.to_string(), RTI, said.referenced);
        }
    }

    /// Returns the federate for `joint-rti: true` in the program: the board with the RTI's address, or the only one. If
    /// all federates run on this computer, the RTI is a program like them.
    fn joint_of_program(&mut self, plan: &Plan, deployment: &Deployment) -> Option<String> {
        let boards = || deployment.federates.iter().filter_map(|(name, place)| Some((name, place.network?)));
        let at: Option<IpAddr> = plan.rti.as_ref().and_then(|rti| rti.host.parse().ok());
        if let Some((name, _)) = boards().find(|(_, network)| Some(network.ip) == at) {
            return Some(name.clone());
        }
        let names: Vec<&str> = boards().map(|(name, _)| name.as_str()).collect();
        match names[..] {
            [] => None,
            [name] => Some(name.to_owned()),
            _ => {
                let message = format!("{} has `joint-rti: true`, but does not say for which federate", plan.name);
                let hint = format!(
                    "add `joint-rti: true` to one of {}, or write `rti: {{ platform: host }}`",
                    names.join(", ")
                );
                self.error(Location::UNKNOWN, message, Some(&hint));
                None
            }
        }
    }

    /// Makes the RTI a part of this federate, with its address.
    fn join(&mut self, name: String, said: Option<&Spanned<String>>, deployment: &mut Deployment) {
        let ip = deployment.place(&name).address();
        if let (Some(ip), Some(said)) = (ip, said)
            && deployment.rti.ip.is_some_and(|other| other != ip)
        {
            let message = format!("the RTI is part of \"{name}\", so its address is {ip}");
            self.error(said.referenced, message, Some("remove `ip` from `rti`"));
        }
        deployment.rti.ip = ip;
        deployment.rti.home = RtiHome::Joint(name);
    }
}
