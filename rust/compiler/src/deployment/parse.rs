// SPDX-License-Identifier: Apache-2.0
//! Reads a deployment file.

use std::collections::BTreeMap;

use super::check::DeploymentChecker;
use super::raw::RawDeployment;
use super::{Deployment, Place, RtiHome};
use crate::plan::Plan;
use crate::yaml::{self, FileError, place};

impl Deployment {
    /// Reads a deployment file and checks it against the program.
    ///
    /// # Errors
    /// Returns all errors of the file, in the order of its lines; only the first one if the file is not valid YAML or
    /// has a key or a value of the wrong kind.
    pub fn parse(path: &str, text: &str, plan: &Plan) -> Result<Self, Vec<FileError>> {
        let raw: RawDeployment = yaml::read(path, text).map_err(|error| vec![error])?;
        check(path, &raw, plan)
    }
}

/// Converts the file to a deployment.
fn check(path: &str, raw: &RawDeployment, plan: &Plan) -> Result<Deployment, Vec<FileError>> {
    let mut checker = DeploymentChecker { path, errors: Vec::new(), taken: BTreeMap::new() };
    let mut deployment = Deployment::default();
    if let Some(rti) = &raw.rti {
        deployment.rti = checker.rti(rti);
    }
    if let Some(security) = &raw.security {
        deployment.keys = checker.keys(&security.keys, plan);
    }
    // The checks follow the order of the file, so that of two conflicting entries the later one is wrong.
    let mut federates: Vec<_> = raw.federates.iter().collect();
    federates.sort_by_key(|(_, spanned)| spanned.as_ref().map(|spanned| place(spanned.referenced)));
    for (name, raw_place) in &federates {
        // A name without a value (`a:`) is a federate with all defaults.
        let Some(spanned) = raw_place else {
            deployment.federates.insert((*name).clone(), Place::default());
            continue;
        };
        checker.known(name, spanned.referenced, plan);
        let restarts = checker.restarts(name, &spanned.value, plan);
        if let Some(place) = checker.place(name, &spanned.value) {
            let place = Place { restarts, ..place };
            let spare = checker.spare(name, &spanned.value, &place, plan);
            deployment.federates.insert((*name).clone(), Place { spare: spare.map(Box::new), ..place });
        }
    }
    checker.joint(raw, &federates, plan, &mut deployment);
    for (name, spanned) in &federates {
        if let Some(spare) = spanned.as_ref().and_then(|spanned| spanned.value.spare.as_ref())
            && deployment.is_joint(name)
        {
            let message = format!("`spare`: {name} has the RTI in its image, and without it there is no federation");
            checker.error(spare.referenced, message, Some("put the RTI elsewhere"));
        }
    }
    // A wrong address of the RTI allows no conclusions.
    let rti_ip_is_wrong = deployment.rti.ip.is_none()
        && (deployment.rti.home != RtiHome::Program || raw.rti.as_ref().is_some_and(|rti| rti.ip.is_some()));
    for (name, spanned) in federates.iter().filter(|_| !rti_ip_is_wrong) {
        if let (Some(spanned), Some(place)) = (spanned, deployment.federates.get(*name))
            && !deployment.is_joint(name)
        {
            checker.reachable(place, spanned.value.ip.as_ref(), &deployment.rti);
            if let (Some(raw), Some(spare)) = (&spanned.value.spare, &place.spare) {
                checker.reachable(spare, Some(&raw.value.ip), &deployment.rti);
            }
        }
    }
    checker.errors.sort_by_key(|error| (error.line, error.column));
    if checker.errors.is_empty() { Ok(deployment) } else { Err(checker.errors) }
}
