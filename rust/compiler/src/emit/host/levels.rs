// SPDX-License-Identifier: Apache-2.0
//! Levels whose reactions several threads share.

use std::collections::BTreeMap;

use lf_model::ReactionId;

use super::symbols::Owner;
use crate::plan::ReactionKind;

impl Owner<'_> {
    /// Returns one arm per level at which several instances have reactions, if there are threads for them. `job`
    /// returns the job of an instance for some of its reactions. The engine runs copies itself: two of different modes
    /// set one port.
    pub(in crate::emit) fn levels(&self, job: impl Fn(usize, &[ReactionId]) -> String) -> Vec<String> {
        let workers = self.job.workers();
        if workers < 2 {
            return Vec::new();
        }
        let mut levels: BTreeMap<u16, BTreeMap<usize, Vec<ReactionId>>> = BTreeMap::new();
        for (id, (reaction, row)) in (0..).zip(self.federate.reactions.iter().zip(&self.tables.reactions)) {
            if let ReactionKind::Body { instance, .. } = reaction.kind {
                levels.entry(row.level).or_default().entry(instance.0).or_default().push(ReactionId(id));
            }
        }
        let arm = |(level, instances): (u16, BTreeMap<usize, Vec<ReactionId>>)| {
            // The reactions of one instance are in different modes. They share the state that they change, so they are
            // one job.
            let mut groups: Vec<_> = instances.into_iter().collect();
            groups.sort_by_key(|(_, reactions)| reactions[0].0);
            let jobs: Vec<String> = groups.iter().map(|(instance, reactions)| job(*instance, reactions)).collect();
            let jobs = jobs.join(",\n                ");
            let run = format!("level.run::<{workers}, {{ TABLES.note_words() }}>(&lf::Threads::<{workers}>, ");
            (groups.len() > 1).then(|| format!("{level} => {run}&mut [\n                {jobs},\n            ])"))
        };
        levels.into_iter().filter_map(arm).collect()
    }
}
