// SPDX-License-Identifier: Apache-2.0
//! Suggestions for misspelt names.

/// The maximum number of candidates, so that programs with thousands of errors and names do not take long.
const CANDIDATES_MAX: usize = 500;

/// Returns a hint that names the candidate nearest to `name`, if one is near enough to be a typing error.
pub(crate) fn did_you_mean<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let near = |candidate: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
    let length = name.chars().count();
    candidates
        .into_iter()
        .take(CANDIDATES_MAX)
        // A name that is much longer or shorter is not near.
        .filter(|candidate| *candidate != name && candidate.chars().count().abs_diff(length) <= 1 + length / 4)
        .map(|candidate| (near(candidate), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.chars().count().min(name.chars().count()) / 4)
        .min()
        .map(|(_, candidate)| format!("did you mean `{candidate}`?"))
}

/// Returns the candidate that such a hint names.
pub(super) fn suggested(hint: &str) -> Option<&str> {
    hint.strip_prefix("did you mean `")?.strip_suffix("`?")
}

#[cfg(test)]
mod tests {
    use super::{did_you_mean, suggested};

    #[test]
    fn the_nearest_name_is_suggested_and_a_far_one_is_not() {
        assert_eq!(did_you_mean("timout", ["fast", "timeout"]), Some("did you mean `timeout`?".into()));
        assert_eq!(suggested("did you mean `timeout`?"), Some("timeout"));
        assert_eq!(did_you_mean("zebra", ["fast", "timeout"]), None);
    }
}
