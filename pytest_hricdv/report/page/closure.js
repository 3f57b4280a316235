// The plot of the points that each test of the smallest suite adds.

function closurePage(view) {
  const place = view.querySelector("[data-plot=gain]"), minimal = DATA.minimal;
  if (!place) return; // no test, no suite
  linePlot(place, [
    { name: "smallest suite", n: 0, points: minimal.curve, note: Object.keys(minimal.gains).length + " tests", curve: "step-after" },
    { name: "all tests, as listed", n: 1, points: minimal.growth, note: TESTS.length + " tests", curve: "step-after" },
  ], { label: "simulated time (s)" }, { label: "points covered", zero: true }, "Points covered over simulated time");
}
