// SPDX-License-Identifier: Apache-2.0
//! Numbers in rows and columns.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Cells in columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// What it shows, with units; nothing where the finding's title says it.
    pub title: String,
    /// What stands over the columns.
    pub headings: Vec<String>,
    /// As many cells each as there are headings.
    pub rows: Vec<Vec<Cell>>,
}

/// What stands in one place of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// Words, or nothing.
    Text(String),
    /// A number.
    Number {
        /// The one that counts.
        value: f64,
        /// How many digits there are after the point.
        digits: usize,
        /// What all rounds gave, where there were several.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        rounds: Vec<f64>,
    },
}

impl Cell {
    /// Nothing.
    pub const NONE: Self = Self::Text(String::new());

    /// A number without a spread.
    pub fn number(value: f64, digits: usize) -> Self {
        Self::Number { value, digits, rounds: Vec::new() }
    }

    /// A count.
    #[expect(clippy::cast_precision_loss, reason = "counts of what happens in hours are far below 2^53")]
    pub fn count(value: u64) -> Self {
        Self::number(value as f64, 0)
    }

    /// The least of several rounds.
    pub fn least(rounds: &[f64], digits: usize) -> Self {
        Self::of(rounds.iter().copied().reduce(f64::min), rounds, digits)
    }

    /// The greatest of several rounds.
    pub fn greatest(rounds: &[f64], digits: usize) -> Self {
        Self::of(rounds.iter().copied().reduce(f64::max), rounds, digits)
    }

    fn of(value: Option<f64>, rounds: &[f64], digits: usize) -> Self {
        value.map_or(Self::NONE, |value| Self::Number { value, digits, rounds: rounds.to_vec() })
    }

    /// The number, if it is one.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Number { value, .. } => Some(*value),
            Self::Text(_) => None,
        }
    }

    /// Whether some round of this one gave what some round of the other one might have given.
    pub fn overlaps(&self, other: &Self) -> bool {
        let (Some((least, greatest)), Some((other_least, other_greatest))) = (self.range(), other.range()) else {
            return false;
        };
        least <= other_greatest && other_least <= greatest
    }

    /// The least and the greatest of the rounds.
    fn range(&self) -> Option<(f64, f64)> {
        let Self::Number { value, rounds, .. } = self else { return None };
        let all = || rounds.iter().copied().chain([*value]);
        Some((all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max)))
    }

    /// The least and the greatest of the rounds, where they differ in the digits that are shown.
    pub fn spread(&self) -> Option<(String, String)> {
        let Self::Number { digits, .. } = self else { return None };
        let (least, greatest) = self.range()?;
        let (least, greatest) = (grouped(least, *digits), grouped(greatest, *digits));
        (least != greatest).then_some((least, greatest))
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number { value, digits, .. } => {
                f.write_str(&grouped(*value, *digits))?;
                self.spread().map_or(Ok(()), |(least, greatest)| write!(f, " ({least}–{greatest})"))
            }
        }
    }
}

/// A number whose thousands are set apart from ten thousand on.
pub(crate) fn grouped(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let end = text.find('.').unwrap_or(text.len());
    let begin = usize::from(text.starts_with('-'));
    if end - begin < 5 {
        return text;
    }
    let mut grouped = text[..begin].to_owned();
    for (place, digit) in text[begin..end].char_indices() {
        if place > 0 && (end - begin - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped + &text[end..]
}

impl Table {
    /// A table with these headings and no rows.
    pub fn new<Heading: Into<String>>(title: impl Into<String>, headings: impl IntoIterator<Item = Heading>) -> Self {
        let headings = headings.into_iter().map(Into::into).collect();
        Self { title: title.into(), headings, rows: Vec::new() }
    }

    /// Adds a row; cells that it lacks are empty.
    pub fn row(&mut self, mut cells: Vec<Cell>) {
        cells.resize(self.headings.len().max(cells.len()), Cell::NONE);
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.title.is_empty() {
            writeln!(f, "{}\n", self.title)?;
        }
        let mut rows = vec![self.headings.clone()];
        rows.extend(self.rows.iter().map(|row| row.iter().map(Cell::to_string).collect()));
        let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
        let widths: Vec<_> = (0..self.headings.len())
            .map(|column| cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0))
            .collect();
        for (index, row) in rows.iter().enumerate() {
            f.write_str("|")?;
            for (cell, width) in row.iter().zip(&widths) {
                write!(f, " {cell:<width$} |")?;
            }
            writeln!(f)?;
            if index == 0 {
                f.write_str("|")?;
                for width in &widths {
                    write!(f, "{:-<1$}|", "", width + 2)?;
                }
                writeln!(f)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_their_spread_and_their_thousands() {
        assert_eq!(Cell::least(&[35.25, 30.0], 1).to_string(), "30.0 (30.0–35.2)");
        assert_eq!(Cell::greatest(&[7.0, 7.0], 0).to_string(), "7");
        assert_eq!(Cell::number(1_234_567.891, 2).to_string(), "1,234,567.89");
        assert_eq!(Cell::number(-12_345.0, 0).to_string(), "-12,345");
        assert_eq!(Cell::number(1234.0, 0).to_string(), "1234");
        assert_eq!(Cell::least(&[], 1), Cell::NONE);
    }

    #[test]
    fn rounds_that_overlap_do_not_tell_two_apart() {
        let [slow, quick] = [[35.0, 40.0], [30.0, 36.0]].map(|rounds| Cell::least(&rounds, 1));
        assert!(slow.overlaps(&quick) && quick.overlaps(&slow));
        assert!(!slow.overlaps(&Cell::number(34.0, 1)) && slow.overlaps(&Cell::number(36.0, 1)));
        assert!(!slow.overlaps(&Cell::NONE));
    }
}
