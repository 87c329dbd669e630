// SPDX-License-Identifier: Apache-2.0
//! The results as one page that needs nothing else: no script, no font and no image from anywhere.

mod canvas;
mod curves;
mod lines;
mod rows;
mod scale;
mod stacked;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::Result;
use crate::results::{Cell, Comparison, Figure, Finding, Machine, Outcome, Part, Plot, Results, Table};

/// What would have to be known of the thesis before more could be compared.
const LIMITS: [&str; 3] = [
    "The thesis measured two boards (NXP MIMXRT1170-EVK) and a Linux computer on a switch of 100 Mbit/s, with the C \
     runtime on Zephyr, by an oscilloscope. None of its hardware is here. Its numbers stand beside ours to show which \
     order they have, and not how much quicker this project would be on the same boards.",
    "Numbers of two runs, or of two computers, cannot be compared: what else the computer does, and whether it is a \
     virtual one, decides more than the programs do. Ratios within one run can, because all that is compared there \
     takes turns.",
    "Of the thesis's figures only what its text tells is drawn: the samples of its histogram and of its line are not \
     published.",
];

/// What a quick run is not.
const QUICK: &str = "A quick run, whose numbers are rough: there were few and short rounds, the smart grid and the \
                     rate ran on Linux alone, and of virtual boards and images only the first ones were measured.";

/// How numbers are to be read.
const READING: &str = "Each number is the best of its rounds unless its section says otherwise; below it is the range \
                       of all rounds. Two whose rounds overlap are not told apart.";

/// The page.
///
/// # Errors
/// When a plot cannot be drawn.
pub fn render(results: &Results) -> Result<String> {
    let sections: Result<Vec<Markup>> = results.parts.iter().map(section).collect();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "lf-zephyr-rs: measurements" }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header {
                    h1 { "Measurements of lf-zephyr-rs" }
                    p.lead {
                        (results.begun) " · " (results.machine.processor) ", " (cores(results.machine.cores))
                        @if let Some(ours) = results.machine.versions.first() { " · commit " (ours.version) }
                    }
                    @if results.quick {
                        p.notice { (QUICK) }
                    }
                    nav { (contents(results)) }
                }
                main {
                    (overview(results))
                    @for section in sections? { (section) }
                    (limits(results))
                    (how(results))
                }
            }
        }
    };
    Ok(page.into_string())
}

fn contents(results: &Results) -> Markup {
    html! {
        ul {
            li { a href="#overview" { "Overview" } }
            @for part in &results.parts { li { a href={ "#" (part.name) } { (title(part)) } } }
            li { a href="#limits" { "What cannot be compared" } }
            li { a href="#how" { "Machine and versions" } }
        }
    }
}

fn title(part: &Part) -> &str {
    match &part.outcome {
        Outcome::Measured(finding) => &finding.title,
        Outcome::Failed(_) | Outcome::Skipped(_) => &part.name,
    }
}

/// Each of our numbers beside another one.
fn overview(results: &Results) -> Markup {
    let findings = results.parts.iter().filter_map(|part| match &part.outcome {
        Outcome::Measured(finding) if !finding.compared.is_empty() => Some((part, finding)),
        _ => None,
    });
    html! {
        section id="overview" {
            h2 { "Overview" }
            p { (READING) }
            div.wide {
                table.compared {
                    thead { tr {
                        th { "what" } th.number { "ours" } th.number { "theirs" } th { "whose" }
                        th.number { "ours is" }
                    } }
                    @for (part, finding) in findings {
                        tbody {
                            tr.group { th colspan="5" { a href={ "#" (part.name) } { (finding.title) } } }
                            @for comparison in &finding.compared { (compared(comparison)) }
                        }
                    }
                }
            }
        }
    }
}

fn compared(comparison: &Comparison) -> Markup {
    let Comparison { what, unit, less_is_better, ours, with, theirs } = comparison;
    let quantity = |cell: &Cell| {
        html! { (value(cell)) @if cell.value().is_some() { " " (unit) } (spread(cell)) }
    };
    let factor = comparison.ratio().map(|ratio| if *less_is_better { 1.0 / ratio } else { ratio });
    // What differs by less than a tenth, or by less than rounds do, is called neither better nor worse.
    let verdict = factor.map(|factor| match factor {
        _ if ours.overlaps(theirs) => ("equal", "within the spread".to_owned()),
        10_000.0.. => ("better", "over 10,000 × better".to_owned()),
        1.1.. => ("better", format!("{} × better", scale::text(factor))),
        ..0.909 => ("worse", format!("{} × worse", scale::text(1.0 / factor))),
        _ => ("equal", "about equal".to_owned()),
    });
    html! {
        tr {
            td { (what) }
            td.number data-label="ours" { (quantity(ours)) }
            td.number data-label="theirs" { (quantity(theirs)) }
            td data-label="whose" { (with) }
            td.number data-label="ours is" { @if let Some((class, words)) = verdict { span class=(class) { (words) } } }
        }
    }
}

/// A cell without its spread.
fn value(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number { value, digits, .. } => Cell::number(*value, *digits).to_string(),
    }
}

/// What a cell's rounds gave, on a line of its own.
fn spread(cell: &Cell) -> Markup {
    html! { @if let Some((least, greatest)) = cell.spread() { span.spread { (least) "–" (greatest) } } }
}

fn section(part: &Part) -> Result<Markup> {
    let body = match &part.outcome {
        Outcome::Measured(finding) => measured(finding)?,
        Outcome::Failed(error) => html! { p.failed { "This part failed:" } pre { (error) } },
        Outcome::Skipped(reason) => html! { p.notice { "This part was left out: " (reason) "." } },
    };
    Ok(html! {
        section id=(part.name) {
            h2 { (title(part)) }
            (body)
            p.small { "Part " code { (part.name) } ", " (Cell::number(part.seconds, 0)) " s" }
        }
    })
}

fn measured(finding: &Finding) -> Result<Markup> {
    let figures: Result<Vec<Markup>> = finding.figures.iter().map(figure).collect();
    Ok(html! {
        p.question { (finding.question) }
        @for figure in figures? { (figure) }
        @for table in &finding.tables { (numbers(table)) }
        h3 { "Method" }
        ul { @for line in &finding.method { li { (line) } } }
        @if !finding.limits.is_empty() {
            h3 { "What cannot be compared" }
            ul { @for line in &finding.limits { li { (line) } } }
        }
    })
}

fn figure(figure: &Figure) -> Result<Markup> {
    let drawing = draw(figure)?;
    Ok(html! {
        figure {
            figcaption {
                b { (figure.title) }
                @if !figure.thesis.is_empty() { " " span.thesis { "thesis, " (figure.thesis) } }
                br;
                (figure.caption)
            }
            div.wide role="img" aria-label=(figure.title) { (PreEscaped(drawing)) }
        }
    })
}

/// The drawing alone, as SVG.
///
/// # Errors
/// When it cannot be drawn.
pub fn draw(figure: &Figure) -> Result<String> {
    match &figure.plot {
        Plot::Rows { axis, rows, marks } => rows::draw(axis, rows, marks),
        Plot::Curves { x, y, curves, marks } => curves::draw(x, y, curves, marks),
        Plot::Stacked { axis, parts, bars } => stacked::draw(axis, parts, bars),
    }
}

fn numbers(table: &Table) -> Markup {
    html! {
        @if !table.title.is_empty() { h3 { (table.title) } }
        div.wide {
            table {
                thead { tr {
                    @for (index, heading) in table.headings.iter().enumerate() {
                        th.number[index > 0] { (heading) }
                    }
                } }
                tbody {
                    @for row in &table.rows {
                        tr { @for (index, cell) in row.iter().enumerate() { (entry(index, cell)) } }
                    }
                }
            }
        }
    }
}

fn entry(index: usize, cell: &Cell) -> Markup {
    match (index, cell) {
        (0, _) => html! { th scope="row" { (cell) } },
        // What went wrong is told in as many words as it takes.
        (_, Cell::Text(text)) if text.len() > 24 => html! { td.words { (text) } },
        _ => html! { td.number { (value(cell)) (spread(cell)) } },
    }
}

fn limits(results: &Results) -> Markup {
    let own = results.parts.iter().filter_map(|part| match &part.outcome {
        Outcome::Measured(finding) => Some(finding.limits.iter().map(|limit| (&finding.title, limit))),
        Outcome::Failed(_) | Outcome::Skipped(_) => None,
    });
    html! {
        section id="limits" {
            h2 { "What cannot be compared, and why" }
            ul {
                @for limit in LIMITS { li { (limit) } }
                @for (title, limit) in own.flatten() { li { b { (title) ": " } (limit) } }
            }
        }
    }
}

fn how(results: &Results) -> Markup {
    let Machine { processor, cores: count, memory_gib, kernel, governor, virtualized_by, load, versions } =
        &results.machine;
    html! {
        section id="how" {
            h2 { "Machine and versions" }
            dl {
                dt { "Processor" } dd { (processor) ", " (cores(*count)) }
                dt { "Memory" } dd { (memory_gib) " GiB" }
                dt { "Kernel" } dd { "Linux " (kernel) }
                dt { "Virtual machine" } dd { (virtualized_by.as_deref().unwrap_or("no")) }
                dt { "Frequency" } dd { (governor.as_deref().unwrap_or("Linux does not choose it")) }
                dt { "Load at the beginning" } dd { (load) }
                @for version in versions { dt { (version.name) } dd { (version.version) } }
                dt { "Made by" } dd { code { "cargo xtask evaluate " (asked(results)) } }
            }
        }
    }
}

/// What was asked for, without what xtask adds by itself.
fn asked(results: &Results) -> String {
    let added = ["--repository", "--lfz"];
    let arguments = &results.arguments;
    let is_added = |index: usize| added.contains(&arguments[index].as_str());
    let asked = (0..arguments.len()).filter(|index| !is_added(*index) && (*index == 0 || !is_added(index - 1)));
    asked.map(|index| arguments[index].as_str()).collect::<Vec<_>>().join(" ")
}

fn cores(count: usize) -> String {
    if count == 1 { "1 core".to_owned() } else { format!("{count} cores") }
}
