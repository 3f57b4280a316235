// The run that is shown beside a test's own, below the same lanes and at the same cursor.

/** The run beside a test's: its lanes and curves; null where there is none. `labelled`: of the test's own lanes. */
function otherRun(found, labelled) {
  const given = RUNS_BESIDE.map((of) => of(found)).find(Boolean);
  if (!given || !given.run) return null;
  const made = lanes(given.run, labelled), curves = new Map(curvesOf(given.run.timeline).map(({ name, points }) => [name, points]));
  return { ...given, made, points: (name) => curves.get(name), events: runEvents(made, []) };
}

/** What an event says beside its numbers, which are others in nearly every run. */
const wordsOf = (event) => event && event.text.replace(/-?\d+(\.\d+)?(e-?\d+)?/g, "#");

// Of these a run may have nothing since nobody noted it.
const NOT_ALWAYS_NOTED = ["requirement", "node"];

/** The open lanes that both runs have: an event that is missing in one then did not happen in it. */
function lanesOfBoth({ made, other }, names) {
  return names.filter((name) => !NOT_ALWAYS_NOTED.includes(made.kinds[name]) || other.made.names.includes(name));
}

/** The first event of open lanes that differs between both runs: {time, mine, theirs}; null where none does. */
function parting(run, names) {
  const open = lanesOfBoth(run, names).filter((name) => run.made.kinds[name] !== "requirement"), places = [];
  for (const lane of open) {
    const [mine, theirs] = [run.events, run.other.events].map((events) => events.filter((event) => event.lane === lane));
    const n = Array.from({ length: Math.max(mine.length, theirs.length) }, (_, n) => n).find((n) => wordsOf(mine[n]) !== wordsOf(theirs[n]));
    if (n !== undefined) places.push({ time: Math.min(mine[n]?.time ?? Infinity, theirs[n]?.time ?? Infinity), mine: mine[n], theirs: theirs[n] });
  }
  return places.reduce((first, place) => (!first || place.time < first.time ? place : first), null);
}

/** The lanes of the other run, with where both part. */
function otherLanes(run, names, width) {
  const { other, room, window } = run, kept = lanesOfBoth(run, names);
  const parts = parting(run, names), said = (event) => (event ? event.text + " (" + seconds(event.time) + ")" : "(end of run)");
  const marks = parts ? [{ lane: (parts.mine ?? parts.theirs).lane, name: (parts.mine ?? parts.theirs).lane, time: parts.time, parts: true }] : [];
  return [
    h("div", { class: "other" }, h("h4", {}, other.title), other.note && h("p", { class: "small soft" }, other.note),
      parts && h("p", { class: "small" }, "Both part ", h("button", { type: "button", class: "link", onclick: () => run.go(parts.time) }, "at " + seconds(parts.time)), ": here ", h("strong", {}, said(parts.mine)), ", there ", h("strong", {}, said(parts.theirs)), ".")),
    lanePlot(width, room, window.shown, other.made, kept, marks),
  ];
}
