// Plots of the points that a closing loop hit, in the view of closure.

/** Points hit so far: of kinds as a share of the points that there are, of ways as numbers. */
function closingPlot(place) {
  const { closing, over } = place.dataset, curves = DATA.closing[closing];
  const series = Object.entries(curves).map(([name, curve], n) => ({ name, n, points: curve[over], curve: "step-after" }));
  const x = over === "runs" ? "runs" : "simulated time (s)";
  const y = closing === "kinds" ? { label: "points hit (%)", domain: percentDomain(series) } : { label: "points hit first", zero: true };
  linePlot(place, series, { label: x }, y, "Points hit over " + x);
}

const showClosure = PAGES.closure;
PAGES.closure = (view) => {
  showClosure(view);
  for (const place of view.querySelectorAll("[data-closing]")) closingPlot(place);
};
