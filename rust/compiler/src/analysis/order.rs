// SPDX-License-Identifier: Apache-2.0
//! Levels: reactions that write before those that read, and within an instance in the order of declaration.

use super::graph::{Graph, Node};
use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::instances::Tree;
use crate::resolve::Class;

/// Why one reaction comes after another.
#[derive(Clone, Copy, Debug)]
enum Reason {
    /// It is declared later in the same reactor.
    Declared,
    /// It reads a port that the other one writes.
    Reads(Node),
}

/// The level of every reaction of the graph. Nothing, with a diagnostic, if some wait for each other.
pub(super) fn order(
    graph: &Graph,
    tree: &Tree,
    classes: &[Class<'_>],
    diagnostics: &mut Diagnostics,
) -> Option<Vec<u16>> {
    let count = graph.steps.len();
    let followers: Vec<_> = (0..count).map(|_| Vec::new()).collect();
    let followers = collect_followers(graph, followers);
    let mut missing = vec![0_usize; count];
    for (follower, _) in followers.iter().flatten() {
        missing[*follower] += 1;
    }
    let mut levels = vec![0_usize; count];
    let mut ready: Vec<_> = (0..count).filter(|step| missing[*step] == 0).collect();
    let mut done = 0;
    while let Some(step) = ready.pop() {
        done += 1;
        for (follower, _) in &followers[step] {
            levels[*follower] = levels[*follower].max(levels[step] + 1);
            missing[*follower] -= 1;
            if missing[*follower] == 0 {
                ready.push(*follower);
            }
        }
    }
    if done < count {
        report_cycle(graph, tree, classes, &followers, &missing, diagnostics);
        return None;
    }
    levels.into_iter().map(|level| u16::try_from(level).ok()).collect::<Option<Vec<_>>>().or_else(|| {
        let message = "this program has more than 65535 levels of reactions";
        diagnostics.push(Diagnostic::new(Code::TooLarge, tree.instances[0].span, message));
        None
    })
}

type Followers = Vec<Vec<(usize, Reason)>>;

fn collect_followers(graph: &Graph, mut followers: Followers) -> Followers {
    for (step, pair) in graph.steps.windows(2).enumerate() {
        if pair[0].instance == pair[1].instance {
            followers[step].push((step + 1, Reason::Declared));
        }
    }
    for (node, writers) in graph.writers.iter().enumerate() {
        for writer in writers {
            for (reader, _) in &graph.readers[node] {
                followers[*writer].push((*reader, Reason::Reads(node)));
            }
        }
    }
    followers
}

/// Reports one cycle among the reactions that never became ready.
fn report_cycle(
    graph: &Graph,
    tree: &Tree,
    classes: &[Class<'_>],
    followers: &Followers,
    missing: &[usize],
    diagnostics: &mut Diagnostics,
) {
    let Some(cycle) = find_cycle(followers, missing) else { return };
    let keyword = |step: usize| {
        let step = graph.steps[step];
        classes[tree.instances[step.instance].class.0].reactions[step.reaction].ast.keyword
    };
    let name = |step: usize| graph.step_name(step, tree, classes);
    let mut text = String::new();
    for (step, reason) in &cycle {
        text.push_str(&name(*step));
        match reason {
            Reason::Declared => text.push_str(" -> "),
            Reason::Reads(node) => {
                text.push_str(" -> ");
                text.push_str(&graph.path(*node, tree, classes));
                text.push_str(" -> ");
            }
        }
    }
    text.push_str(&name(cycle[0].0));
    let message = format!("these reactions wait for each other at the same time: {text}");
    let mut diagnostic = Diagnostic::new(Code::CausalityLoop, keyword(cycle[0].0), message);
    for (index, (step, reason)) in cycle.iter().enumerate() {
        let next = name(cycle[(index + 1) % cycle.len()].0);
        let label = match reason {
            Reason::Declared => format!("`{}` comes before `{next}`, which is declared later", name(*step)),
            Reason::Reads(node) => {
                format!("`{}` writes `{}`, which `{next}` reads", name(*step), graph.path(*node, tree, classes))
            }
        };
        if index == 0 {
            diagnostic = diagnostic.label(label);
        } else {
            diagnostic = diagnostic.also(keyword(*step), label);
        }
    }
    let declared = cycle.iter().any(|(_, reason)| matches!(reason, Reason::Declared));
    let hint = if declared {
        "delay one of the connections by `after` (`after 0` is one microstep), or change the order of the reactions"
    } else {
        "delay one of the connections by `after` (`after 0` is one microstep)"
    };
    diagnostics.push(diagnostic.hint(hint));
}

/// A shortest cycle through the first reaction that has one, as steps with the reason for the next one.
fn find_cycle(followers: &Followers, missing: &[usize]) -> Option<Vec<(usize, Reason)>> {
    (0..missing.len()).filter(|step| missing[*step] > 0).find_map(|start| {
        // Breadth first, so that the path is a short one.
        let mut from: Vec<Option<(usize, Reason)>> = vec![None; missing.len()];
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(step) = queue.pop_front() {
            for (follower, reason) in followers[step].iter().filter(|(follower, _)| missing[*follower] > 0) {
                if from[*follower].is_some() {
                    continue;
                }
                from[*follower] = Some((step, *reason));
                if *follower == start {
                    return Some(path_back(&from, start));
                }
                queue.push_back(*follower);
            }
        }
        None
    })
}

fn path_back(from: &[Option<(usize, Reason)>], start: usize) -> Vec<(usize, Reason)> {
    let mut path = Vec::new();
    let mut at = start;
    while let Some((step, reason)) = from[at] {
        path.push((step, reason));
        at = step;
        if at == start {
            break;
        }
    }
    path.reverse();
    path
}
