// SPDX-License-Identifier: Apache-2.0
//! The deployment file as it is written: keys and kinds of values, with their places.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_saphyr::Spanned;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RawDeployment {
    pub(super) rti: Option<RawRti>,
    pub(super) security: Option<RawSecurity>,
    #[serde(default)]
    pub(super) federates: BTreeMap<String, Option<Spanned<RawPlace>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RawSecurity {
    pub(super) keys: Spanned<String>,
}

/// A key with a text, if it is present.
pub(super) type Key = Option<Spanned<String>>;

/// Declares the keys of a participant: its own, and those of a place in the network.
macro_rules! participant {
    ($name:ident { $($key:ident: $ty:ty),* $(,)? }) => {
        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields, rename_all = "kebab-case")]
        pub(super) struct $name {
            $(pub(super) $key: $ty,)*
            pub(super) ip: Key,
            pub(super) netmask: Key,
            pub(super) prefix: Key,
            pub(super) gateway: Key,
            pub(super) mac: Key,
            pub(super) ethernet: Key,
            pub(super) runner: Key,
            pub(super) probe: Key,
        }

        impl $name {
            /// Returns the keys of a place in the network; the first five are about its addresses.
            pub(super) fn keys(&self) -> [(&'static str, &Key); 8] {
                [
                    ("ip", &self.ip),
                    ("netmask", &self.netmask),
                    ("prefix", &self.prefix),
                    ("gateway", &self.gateway),
                    ("mac", &self.mac),
                    ("ethernet", &self.ethernet),
                    ("runner", &self.runner),
                    ("probe", &self.probe),
                ]
            }
        }
    };
}

participant!(RawRti { platform: Key, port: Key });

participant!(RawPlace {
    platform: Spanned<String>,
    joint_rti: Option<Spanned<bool>>,
    restart: Key,
    spare: Option<Spanned<RawSpare>>,
});

/// A second board of the same kind, in the network of the first one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RawSpare {
    pub(super) ip: Spanned<String>,
    pub(super) mac: Key,
    pub(super) probe: Key,
}

impl RawRti {
    /// Returns the keys of its place, on a platform.
    pub(super) fn place(&self, platform: Spanned<String>) -> RawPlace {
        let [ip, netmask, prefix, gateway, mac, ethernet, runner, probe] = self.keys().map(|(_, value)| value.clone());
        RawPlace {
            platform,
            joint_rti: None,
            restart: None,
            spare: None,
            ip,
            netmask,
            prefix,
            gateway,
            mac,
            ethernet,
            runner,
            probe,
        }
    }
}
