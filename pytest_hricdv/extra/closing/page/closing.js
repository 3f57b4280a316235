// Plots of the points that a closing loop hit, in the view of closure.

const OVER = { runs: "runs", sim_s: "simulated time (s)" };

/** Points hit so far, over runs or over simulated time: of kinds as a share of the points that there are, of strategies as numbers. */
function closingPlot(place) {
  const curves = DATA.closing[place.dataset.closing], isShare = place.dataset.closing === "kinds", box = h("div");
  const draw = (over) => {
    const series = Object.entries(curves).map(([name, curve], n) => ({ name, n, points: curve[over], curve: "step-after" }));
    const y = isShare ? { label: "points hit (%)", domain: percentDomain(series) } : { label: "points hit first", zero: true };
    box.replaceChildren();
    linePlot(box, series, { label: OVER[over] }, y, "Points hit over " + OVER[over]);
  };
  const choice = h("select", { "aria-label": "Over", onchange: () => draw(choice.value) },
    Object.entries(OVER).map(([over, text]) => h("option", { value: over }, "over " + text)));
  place.append(choice, box);
  draw("runs");
}

const showClosure = PAGES.closure;
PAGES.closure = (view) => {
  showClosure(view);
  for (const place of view.querySelectorAll("[data-closing]")) closingPlot(place);
};
