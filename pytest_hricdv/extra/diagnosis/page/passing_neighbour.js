// The nearest passing run, next to the failing one.

/** The nearest passing run in the form of a test's details. */
function passingNeighbour({ neighbour }) {
  if (!neighbour || !neighbour.timeline) return null;
  const acted = neighbour.abstract.map(() => null);
  for (const [time, number] of neighbour.begun) acted[number] = time;
  return {
    title: "The nearest passing run: passes " + neighbour.words,
    note: neighbour.is_shrunk ? "It is nearest to the shrunk test: what shrinking removed from this test differs, too." : "",
    run: { timeline: neighbour.timeline, acted, abstract: neighbour.abstract },
  };
}

/** On other tests of the cause: where the nearest passing run is shown. */
function neighbourElsewhere({ neighbour }) {
  if (!neighbour || !neighbour.of) return null;
  const element = h("p", { class: "small" }, "The deciding change was searched for in ", h("a", { href: "#test/" + neighbour.anchor, class: "mono" }, neighbour.of), ", which fails for the same cause: it passes " + neighbour.words + ". Its page shows both runs.");
  return { element, at: () => {} };
}

RUNS_BESIDE.push(passingNeighbour);
RUN_PANELS.push(neighbourElsewhere);
