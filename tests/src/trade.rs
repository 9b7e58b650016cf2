//! Cost against error: frontiers, and who is ahead at which cost. Plain arithmetic on measured numbers.
//!
//! A *point* is one configuration of an engine: what it costs, and how wrong it is. The *frontier* of an engine is
//! those of its points than which it has none that is both cheaper and better: what one gets for a budget is the
//! best point of the frontier within it. Between two points a budget buys the cheaper one, so a frontier is a
//! staircase and nothing is interpolated.

/// What a configuration costs and how wrong it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// In any unit, the same for all; positive.
    pub cost: f64,
    /// Not negative; infinite for a run that was lost.
    pub error: f64,
}

/// Indices of the points of the frontier, the cheapest first. Of points that are alike the first counts.
pub fn frontier(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a], points[b]);
        a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error))
    });
    let mut best = f64::INFINITY;
    order.retain(|&index| {
        let is_better = points[index].error < best;
        best = best.min(points[index].error);
        is_better
    });
    order
}

/// The corners of the staircase through the costs and errors of a frontier, the cheapest first.
pub fn stairs(best: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let steps = best.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    steps.chain(best.last().copied()).collect()
}

/// The least error that a budget buys; infinite when nothing is so cheap.
pub fn best_within(points: &[Point], budget: f64) -> f64 {
    points.iter().filter(|point| point.cost <= budget).map(|point| point.error).fold(f64::INFINITY, f64::min)
}

/// Own points against those of one peer, at every cost between the peer's cheapest and dearest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// True when the own error is lower at every cost, or both are at the floor.
    pub is_ahead: bool,
    /// The greatest own error over the peer's, both clipped at the floor; infinite where nothing own is so cheap
    /// or all that is was lost, and the peer's was not.
    pub worst: f64,
    /// The cost at which that is so.
    pub worst_cost: f64,
    /// Share of the costs, by their logarithms, at which the own error is lower or both are at the floor.
    pub share: f64,
    /// [`Verdict::is_ahead`] and [`Verdict::worst`] at the costs that both offer: from the own cheapest point on.
    /// True and 0 when that is dearer than all of the peer's.
    pub both: (bool, f64),
    /// The own cheapest cost over the peer's.
    pub cheapest: f64,
}

/// Compares; `None` when the peer has no points. Its lost ones do not count: they are nothing to have. Errors below
/// `floor` are as good as it: what is smaller is not measured but rounding.
pub fn verdict(own: &[Point], peer: &[Point], floor: f64) -> Option<Verdict> {
    let peer: Vec<Point> = peer.iter().copied().filter(|point| point.error.is_finite()).collect();
    let costs = || peer.iter().map(|point| point.cost);
    let (first, last) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
    if peer.is_empty() {
        return None;
    }
    // Both staircases change at points only.
    let mut stairs: Vec<f64> = own.iter().map(|point| point.cost).chain(costs()).collect();
    stairs.retain(|&cost| cost >= first && cost <= last);
    stairs.sort_by(f64::total_cmp);
    stairs.dedup();
    let start = own.iter().map(|point| point.cost).fold(f64::INFINITY, f64::min);
    let (both, cheapest) = ((true, 0.0), start / first);
    let mut found = Verdict { is_ahead: true, worst: 0.0, worst_cost: first, share: 0.0, both, cheapest };
    let whole = (last / first).ln();
    for (place, &cost) in stairs.iter().enumerate() {
        let [ours, theirs] = [own, &peer].map(|points| best_within(points, cost).max(floor));
        let ratio = if ours == theirs { 1.0 } else { ours / theirs };
        let is_ahead = ours < theirs || (ours == floor && theirs == floor);
        if ratio > found.worst {
            (found.worst, found.worst_cost) = (ratio, cost);
        }
        found.is_ahead &= is_ahead;
        if cost >= start {
            found.both = (found.both.0 && is_ahead, found.both.1.max(ratio));
        }
        let next = stairs.get(place + 1).copied().unwrap_or(last);
        if is_ahead {
            found.share += if whole > 0.0 { (next / cost).ln() / whole } else { 1.0 };
        }
    }
    Some(found)
}

/// The middle value, or the mean of the two in the middle; not a number for nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// A line of a table of values between commas. A field with a comma, a quote or a line's end is quoted.
pub fn csv_line(fields: &[String]) -> String {
    let field = |text: &String| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.clone()
        }
    };
    fields.iter().map(field).collect::<Vec<_>>().join(",") + "\n"
}

/// A text with what is between two markers replaced; each stands on a line of its own. `None` when the text has
/// not each of them once, in this order.
pub fn between_markers(text: &str, [begin, end]: [&str; 2], inner: &str) -> Option<String> {
    let once = |marker: &str| (text.matches(marker).count() == 1).then(|| text.find(marker)).flatten();
    let (from, to) = (once(begin)? + begin.len(), once(end)?);
    let (before, after) = (text.get(..from)?, text.get(to..)?);
    (from <= to).then(|| format!("{before}\n{}\n{after}", inner.trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point> {
        list.iter().map(|&(cost, error)| Point { cost, error }).collect()
    }

    #[test]
    fn a_frontier_holds_what_nothing_beats() {
        let all = points(&[(4.0, 1.0), (1.0, 8.0), (2.0, 9.0), (3.0, 1.0), (2.0, 4.0), (9.0, f64::INFINITY)]);
        assert_eq!(frontier(&all), [1, 4, 3]);
        assert!(frontier(&[]).is_empty());
        assert!(frontier(&points(&[(1.0, f64::INFINITY)])).is_empty(), "what was lost is on no frontier");
    }

    #[test]
    fn stairs_fall_at_the_costs_of_the_frontier() {
        let best = [(1.0, 8.0), (2.0, 4.0), (5.0, 1.0)];
        assert_eq!(stairs(&best), [(1.0, 8.0), (2.0, 8.0), (2.0, 4.0), (5.0, 4.0), (5.0, 1.0)]);
        assert_eq!(stairs(&best[..1]), best[..1]);
        assert!(stairs(&[]).is_empty());
    }

    #[test]
    fn a_budget_buys_the_best_within_it() {
        let all = points(&[(1.0, 8.0), (2.0, 4.0), (3.0, 5.0)]);
        assert_eq!(
            [0.5, 1.0, 2.5, 9.0].map(|budget| best_within(&all, budget)),
            [f64::INFINITY, 8.0, 4.0, 4.0]
        );
    }

    #[test]
    fn who_is_better_everywhere_is_ahead() {
        let found = verdict(&points(&[(0.5, 3.0), (2.0, 1.0)]), &points(&[(1.0, 4.0), (4.0, 2.0)]), 0.0);
        let found = found.expect("there are points");
        assert!(found.is_ahead);
        assert_eq!(found.worst, 0.75);
        assert!((found.share - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_peer_is_ahead_where_it_already_improved() {
        // From 2 to 4 the peer has 2 and the own error is still 3: half of the logarithmic range.
        let found =
            verdict(&points(&[(1.0, 3.0), (4.0, 1.0)]), &points(&[(1.0, 4.0), (2.0, 2.0), (4.0, 1.5)]), 0.0);
        let found = found.expect("there are points");
        assert!(!found.is_ahead);
        assert_eq!((found.worst, found.worst_cost), (1.5, 2.0));
        assert!((found.share - 0.5).abs() < 1e-12, "{}", found.share);
    }

    #[test]
    fn nothing_so_cheap_is_the_worst() {
        let found = verdict(&points(&[(2.0, 1.0)]), &points(&[(1.0, 4.0), (4.0, 2.0)]), 0.0);
        let found = found.expect("there are points");
        assert_eq!((found.worst, found.worst_cost), (f64::INFINITY, 1.0));
        assert!((found.share - 0.5).abs() < 1e-12);
        assert_eq!((found.both, found.cheapest), ((true, 0.5), 2.0), "from 2 on: 1 / 4, then 1 / 2");
    }

    #[test]
    fn errors_below_the_floor_are_alike() {
        let found = verdict(&points(&[(1.0, 1.0e-8)]), &points(&[(1.0, 1.0e-9)]), 1.0e-6).expect("points");
        assert!(found.is_ahead);
        assert_eq!((found.worst, found.share), (1.0, 1.0));
        assert_eq!(verdict(&points(&[(1.0, 1.0)]), &[], 0.0), None);
    }

    #[test]
    fn what_a_peer_lost_does_not_count() {
        let lost = points(&[(1.0, f64::INFINITY)]);
        assert_eq!(verdict(&lost, &lost, 1.0e-6), None);
        let peer = points(&[(0.1, f64::INFINITY), (1.0, 4.0), (9.0, f64::INFINITY)]);
        let found = verdict(&points(&[(1.0, 2.0)]), &peer, 0.0).expect("one point is left");
        assert_eq!((found.is_ahead, found.worst, found.cheapest), (true, 0.5, 1.0));
        let found = verdict(&lost, &peer, 0.0).expect("one point is left");
        assert_eq!((found.is_ahead, found.worst), (false, f64::INFINITY), "what we lost does");
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn fields_with_commas_are_quoted() {
        let line = csv_line(&["a".to_string(), "b, \"c\"".to_string(), "1e-3".to_string()]);
        assert_eq!(line, "a,\"b, \"\"c\"\"\",1e-3\n");
    }

    #[test]
    fn markers_stay_and_their_inside_changes() {
        let markers = ["<!-- a -->", "<!-- b -->"];
        let text = "x\n<!-- a -->\nold\n<!-- b -->\ny\n";
        assert_eq!(
            between_markers(text, markers, "new\n").as_deref(),
            Some("x\n<!-- a -->\nnew\n<!-- b -->\ny\n")
        );
        assert_eq!(between_markers("x", markers, "new"), None);
        assert_eq!(between_markers("<!-- b --> <!-- a -->", markers, "new"), None);
        assert_eq!(between_markers("<!-- a --> <!-- a --> <!-- b -->", markers, "new"), None);
    }
}
