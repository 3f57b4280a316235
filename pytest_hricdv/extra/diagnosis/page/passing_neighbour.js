// The nearest run that passes, beside the one that fails.

/** The neighbour's run in the form of a test's details. */
function passingNeighbour({ neighbour }) {
  if (!neighbour || !neighbour.timeline) return null;
  const acted = neighbour.abstract.map(() => null);
  for (const [time, number] of neighbour.begun) acted[number] = time;
  return {
    title: "The nearest run that passes: " + neighbour.words,
    note: neighbour.is_shrunk ? "It is a neighbour of what is left of this test without what the failure does not need: what was taken away differs, too." : "",
    run: { timeline: neighbour.timeline, acted, abstract: neighbour.abstract },
  };
}

/** Of a further test of a cause: where the passing neighbour is shown. */
function neighbourElsewhere({ neighbour }) {
  if (!neighbour || !neighbour.of) return null;
  const element = h("p", { class: "small" }, "What decides was looked for in ", h("a", { href: "#test/" + neighbour.anchor, class: "mono" }, neighbour.of), ", which fails for the same cause: it passes " + neighbour.words + ". Its page shows both runs.");
  return { element, at: () => {} };
}

RUNS_BESIDE.push(passingNeighbour);
RUN_PANELS.push(neighbourElsewhere);
