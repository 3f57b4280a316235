// What each test of the smallest suite adds.

function closurePage(view) {
  const place = view.querySelector("[data-plot=gain]"), found = DATA.smallest;
  if (!place || !found) return;
  const all = [[0, found.points], [Math.max(found.sim_s, 1), found.points]];
  linePlot(place, [
    { name: "smallest suite", n: 0, points: found.curve, note: found.curve.length - 1 + " tests" },
    { name: "all tests", n: 1, points: all, note: TESTS.length + " tests" },
  ], { label: "simulated time (s)" }, { label: "points covered", zero: true }, "Points covered over simulated time");
}
