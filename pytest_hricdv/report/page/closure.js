// Plots of the points that each test of the smallest suite adds, and of those that a closing loop hit.

function closurePage(view) {
  const place = view.querySelector("[data-plot=gain]"), minimal = DATA.minimal;
  linePlot(place, [
    { name: "smallest suite", n: 0, points: minimal.curve, note: Object.keys(minimal.gains).length + " tests", curve: "step-after" },
    { name: "all tests, as listed", n: 1, points: minimal.growth, note: TESTS.length + " tests", curve: "step-after" },
  ], { label: "simulated time (s)" }, { label: "points covered", zero: true }, "Points covered over simulated time");
  for (const each of view.querySelectorAll("[data-closing]")) closingPlot(each);
}

/** Points hit so far: of kinds as a share of the points that there are, of ways as numbers. */
function closingPlot(place) {
  const { closing, over } = place.dataset, curves = DATA.closing[closing];
  const series = Object.entries(curves).map(([name, curve], n) => ({ name, n, points: curve[over], curve: "step-after" }));
  const x = over === "runs" ? "runs" : "simulated time (s)";
  const y = closing === "kinds" ? { label: "points hit (%)", domain: percentDomain(series) } : { label: "points hit first", zero: true };
  linePlot(place, series, { label: x }, y, "Points hit over " + x);
}
