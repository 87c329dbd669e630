// SPDX-License-Identifier: Apache-2.0
//! The deployment file as it is written: keys and kinds of values, with their places.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_saphyr::Spanned;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Raw {
    pub(super) rti: Option<RawRti>,
    #[serde(default)]
    pub(super) federates: BTreeMap<String, Option<Spanned<RawPlace>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRti {
    pub(super) platform: Option<Spanned<String>>,
    pub(super) ip: Option<Spanned<String>>,
    pub(super) port: Option<Spanned<String>>,
    pub(super) netmask: Option<Spanned<String>>,
    pub(super) gateway: Option<Spanned<String>>,
    pub(super) mac: Option<Spanned<String>>,
    pub(super) ethernet: Option<Spanned<String>>,
    pub(super) runner: Option<Spanned<String>>,
    pub(super) probe: Option<Spanned<String>>,
}

impl RawRti {
    /// What is said about its place, on a platform.
    pub(super) fn place(&self, platform: Spanned<String>) -> RawPlace {
        RawPlace {
            platform,
            ip: self.ip.clone(),
            netmask: self.netmask.clone(),
            gateway: self.gateway.clone(),
            mac: self.mac.clone(),
            ethernet: self.ethernet.clone(),
            runner: self.runner.clone(),
            probe: self.probe.clone(),
            joint_rti: None,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RawPlace {
    pub(super) platform: Spanned<String>,
    pub(super) ip: Option<Spanned<String>>,
    pub(super) netmask: Option<Spanned<String>>,
    pub(super) gateway: Option<Spanned<String>>,
    pub(super) mac: Option<Spanned<String>>,
    pub(super) ethernet: Option<Spanned<String>>,
    pub(super) runner: Option<Spanned<String>>,
    pub(super) probe: Option<Spanned<String>>,
    pub(super) joint_rti: Option<Spanned<bool>>,
}
