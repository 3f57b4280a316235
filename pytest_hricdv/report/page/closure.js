// What each test of the smallest suite adds.

function closurePage(view) {
  const place = view.querySelector("[data-plot=gain]"), found = DATA.smallest;
  if (!place || !found) return;
  linePlot(place, [
    { name: "smallest suite", n: 0, points: found.curve, note: Object.keys(found.gains).length + " tests", curve: "step-after" },
    { name: "all tests, as listed", n: 1, points: found.growth, note: TESTS.length + " tests", curve: "step-after" },
  ], { label: "simulated time (s)" }, { label: "points covered", zero: true }, "Points covered over simulated time");
}
